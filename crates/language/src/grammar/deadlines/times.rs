//! Times of day and lengths of time, as one language says them.

use std::ops::Range;

use openbench_core::Deadline;

use crate::lexicon::languages::numeral;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::marks;
use crate::lexicon::numbers::{Number, number};
use crate::lexicon::times::{FoldedTimes, Phrase};
use crate::lexicon::tokens::{Kind, Token};
use crate::lexicon::words::Vocabulary;

/// A day that is named at most so many tokens from a time is the time's.
const DAY_BESIDE: usize = 3;
/// A word for all doors stands at most so many tokens before a deadline.
const ALL_BESIDE: usize = 5;
/// No number is a longer word, in bytes.
const LONGEST_WORD: usize = 40;
/// The most tokens of a number that is spelt in words.
const LONGEST_NUMBER: usize = 4;
/// Larger numbers are of no time.
const LARGEST_NUMBER: u32 = 999;
/// Marks that end a sentence in Latin letters.
const ENDS: [&str; 4] = [".", "!", "?", ";"];

const MINUTES_OF_HOUR: u32 = 60;
const SECONDS_OF_MINUTE: u32 = 60;
const SECONDS_OF_HOUR: u32 = 3600;
const NOON_HOUR: u32 = 12;
const LAST_HOUR: u32 = 24;
/// The latest hour that is one of the afternoon, if nothing says which half of the day is meant:
/// parcels are brought by day.
const LATEST_AFTERNOON_HOUR: u32 = 7;
/// The same for an hour with minutes.
const LATEST_AFTERNOON_HOUR_WITH_MINUTES: u32 = 6;

/// What stands at the beginning of some tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Parsed<T> {
    /// How many tokens it takes.
    pub length: usize,
    pub value: T,
}

impl<T> Parsed<T> {
    fn new(length: usize, value: T) -> Self {
        Self { length, value }
    }

    /// The same behind some tokens.
    fn behind(self, tokens: usize) -> Self {
        Self {
            length: tokens + self.length,
            ..self
        }
    }

    /// The same with some tokens behind it.
    fn with(self, tokens: usize) -> Self {
        Self {
            length: self.length + tokens,
            ..self
        }
    }

    fn map<U>(self, change: impl FnOnce(T) -> U) -> Parsed<U> {
        Parsed {
            length: self.length,
            value: change(self.value),
        }
    }
}

/// The half of a day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Half {
    Morning,
    Afternoon,
}

/// Reads times in one language.
pub(super) struct TimeReader<'a> {
    pub times: &'a FoldedTimes,
    pub vocabulary: Vocabulary<'a>,
}

impl TimeReader<'_> {
    /// The deadline at the beginning of `tokens`.
    pub(super) fn deadline(&self, tokens: &[Token]) -> Option<Parsed<Deadline>> {
        let times = self.times;
        // `d'ici 2 heures` is no time of day.
        let within = marked(tokens, &times.within, &times.within_after, |tokens| {
            self.duration(tokens)
        });
        if let Some(length) = within {
            return Some(length.map(|seconds| Deadline::Within { seconds }));
        }
        let by = marked(tokens, &times.by, &times.by_after, |tokens| {
            self.clock(tokens)
        });
        let clock = by.or_else(|| self.by_bare_hour(tokens))?;
        Some(clock.map(|minutes| Deadline::Clock { minutes }))
    }

    /// Whether what stands at a token goes on with a time before it: `9 am to 6 pm`, `von 9 bis 17
    /// Uhr`, `1小时30分钟内`.
    pub(super) fn goes_on(&self, tokens: &[Token], at: usize) -> bool {
        let times = self.times;
        let units = [
            &times.clock,
            &times.am,
            &times.pm,
            &times.minutes,
            &times.hours,
        ];
        if units
            .into_iter()
            .any(|entries| ends(&tokens[..at], entries))
        {
            return true;
        }
        let Some(before) = at.checked_sub(1) else {
            return false;
        };
        let is_span = is_number(&tokens[before]) && ends(&tokens[..before], &times.from);
        let is_point = tokens[before].text == marks::POINT && tokens[at].glued;
        is_span || is_number(&tokens[at]) && (is_number(&tokens[before]) || is_point)
    }

    /// Whether a deadline that begins at a token is of all doors: `both by 6 pm`, `都要在下午6点前`.
    pub(super) fn is_of_all(&self, tokens: &[Token], at: usize) -> bool {
        let mut near = at.saturating_sub(ALL_BESIDE)..at;
        near.any(|from| begins(&tokens[from..at], &self.times.all).is_some())
    }

    /// Whether no other day is named beside a time.
    pub(super) fn is_today(&self, tokens: &[Token], time: Range<usize>) -> bool {
        let end = (time.end + DAY_BESIDE).min(tokens.len());
        let mut beside =
            (time.start.saturating_sub(DAY_BESIDE)..end).filter(|at| !time.contains(at));
        beside.all(|at| begins(&tokens[at..], &self.times.other_days).is_none())
    }

    /// An hour with no word for it, where nothing else can be meant: `antes de las 10`, or `by 4`
    /// at the end of a sentence. In minutes since midnight.
    fn by_bare_hour(&self, tokens: &[Token]) -> Option<Parsed<u32>> {
        let marker = begins(tokens, &self.times.by)?;
        let rest = &tokens[marker..];
        let hour = self.number(rest).filter(|hour| hour.value <= LAST_HOUR)?;
        // The last token of the words before the hour, as `las` in `antes de las`.
        let last_word = &tokens[marker.checked_sub(1)?..];
        let is_of_hours = begins(last_word, &self.times.hour_articles).is_some();
        let is_by = begins(tokens, &self.times.by_bare_hour) == Some(marker);
        // Elsewhere a number behind `by` may count something: `by 4 boxes`.
        let is_last = rest
            .get(hour.length)
            .is_none_or(|next| ENDS.contains(&next.text.as_str()));
        let is_hour = is_of_hours || is_by && is_last;
        is_hour.then(|| {
            hour.map(|hour| self.by_day(hour, 0, None) * MINUTES_OF_HOUR)
                .behind(marker)
        })
    }

    /// The hour of twenty-four.
    fn by_day(&self, hour: u32, minutes: u32, half: Option<Half>) -> u32 {
        let latest = if minutes > 0 {
            LATEST_AFTERNOON_HOUR_WITH_MINUTES
        } else {
            LATEST_AFTERNOON_HOUR
        };
        match half {
            Some(Half::Afternoon) if hour < NOON_HOUR => hour + NOON_HOUR,
            // 12 am is midnight, here at the end of the day.
            Some(Half::Morning) if hour == NOON_HOUR => LAST_HOUR,
            None if self.times.has_half_days && (1..=latest).contains(&hour) => hour + NOON_HOUR,
            _ => hour,
        }
    }

    /// A time of day, minutes since midnight: `6 pm`, `18:30`, `下午6点半`, `noon`.
    fn clock(&self, tokens: &[Token]) -> Option<Parsed<u32>> {
        let noon = begins(tokens, &self.times.noon);
        // `中午1点`
        let half = noon.map(|length| Parsed::new(length, Half::Afternoon));
        let half = half.or_else(|| self.half_of_day(tokens));
        let time = self.hour_and_minutes(tokens, half);
        time.or_else(|| noon.map(|length| Parsed::new(length, NOON_HOUR * MINUTES_OF_HOUR)))
    }

    /// A time of day behind the words for its half, if any.
    fn hour_and_minutes(
        &self,
        tokens: &[Token],
        before: Option<Parsed<Half>>,
    ) -> Option<Parsed<u32>> {
        let mut at = before.map_or(0, |half| half.length);
        let marker = begins(&tokens[at..], &self.times.at);
        at += marker.unwrap_or(0);
        let hour = self.number(&tokens[at..])?;
        at += hour.length;
        let rest = self.rest_of_hour(&tokens[at..], marker.is_some());
        at += rest.length;
        let after = self.half_of_day(&tokens[at..]);
        at += after.map_or(0, |half| half.length);

        let half = before.or(after).map(|half| half.value);
        let Rest { minutes, is_clock } = rest.value;
        let hour = self.by_day(hour.value, minutes, half);
        let minutes = hour * MINUTES_OF_HOUR + minutes;
        // A bare number may be anything; only a word for hours, minutes or a half of the day makes
        // it a time.
        let is_time = is_clock || half.is_some();
        (is_time && minutes <= LAST_HOUR * MINUTES_OF_HOUR).then_some(Parsed::new(at, minutes))
    }

    /// What stands behind an hour: words for hours, minutes. Without either a number is an hour
    /// if `is_marked` before it.
    fn rest_of_hour(&self, tokens: &[Token], is_marked: bool) -> Parsed<Rest> {
        if let Some(clock) = begins(tokens, &self.times.clock) {
            let minutes = self.minutes_behind_clock(&tokens[clock..]);
            return minutes.behind(clock).map(|minutes| Rest {
                minutes,
                is_clock: true,
            });
        }
        self.minutes_behind_mark(tokens).unwrap_or(Parsed::new(
            0,
            Rest {
                minutes: 0,
                is_clock: is_marked,
            },
        ))
    }

    /// Minutes behind a word for hours; 0 if there are none.
    fn minutes_behind_clock(&self, tokens: &[Token]) -> Parsed<u32> {
        if let Some(half) = begins(tokens, &self.times.half) {
            return Parsed::new(half, 30);
        }
        match minutes_of(tokens, !self.times.has_half_days) {
            Some(minutes) => {
                let unit = begins(&tokens[minutes.length..], &self.times.minutes);
                minutes.with(unit.unwrap_or(0))
            }
            None => Parsed::new(0, 0),
        }
    }

    /// Minutes behind a colon or a point. `12.50` may be a price, `12.50 Uhr` is none.
    fn minutes_behind_mark(&self, tokens: &[Token]) -> Option<Parsed<Rest>> {
        let mark = tokens.first().filter(|mark| mark.glued)?;
        let is_colon = mark.text == marks::COLON;
        if !is_colon && mark.text != marks::POINT {
            return None;
        }
        let minutes = minutes_of(&tokens[1..], false)?.behind(1);
        let clock = begins(&tokens[minutes.length..], &self.times.clock);
        let is_clock = is_colon || clock.is_some();
        let rest = minutes.map(|minutes| Rest { minutes, is_clock });
        Some(rest.with(clock.unwrap_or(0)))
    }

    /// Words for the half of the day.
    fn half_of_day(&self, tokens: &[Token]) -> Option<Parsed<Half>> {
        let half = |entries, half| begins(tokens, entries).map(|length| Parsed::new(length, half));
        half(&self.times.pm, Half::Afternoon).or_else(|| half(&self.times.am, Half::Morning))
    }

    /// How long, in seconds: `ten minutes`, `2 hours`, `half an hour`.
    fn duration(&self, tokens: &[Token]) -> Option<Parsed<u32>> {
        if let Some(length) = begins(tokens, &self.times.half_hour) {
            return Some(Parsed::new(length, SECONDS_OF_HOUR / 2));
        }
        if let Some(length) = begins(tokens, &self.times.one_hour) {
            return Some(self.with_minutes(tokens, Parsed::new(length, SECONDS_OF_HOUR)));
        }
        let count = self.number(tokens)?;
        let rest = &tokens[count.length..];
        let seconds = |unit: u32| count.map(|count| count * unit);
        if let Some(length) = begins(rest, &self.times.minutes) {
            return Some(seconds(SECONDS_OF_MINUTE).with(length));
        }
        let length = begins(rest, &self.times.hours)?;
        Some(self.with_minutes(tokens, seconds(SECONDS_OF_HOUR).with(length)))
    }

    /// Hours, in seconds, and the minutes behind them: `1 hour 30 minutes`, `une heure et 15
    /// minutes`.
    fn with_minutes(&self, tokens: &[Token], hours: Parsed<u32>) -> Parsed<u32> {
        let rest = &tokens[hours.length..];
        match (0..=1).find_map(|skipped| self.minutes_behind(rest, skipped)) {
            Some(minutes) => hours
                .with(minutes.length)
                .map(|sum| sum + SECONDS_OF_MINUTE * minutes.value),
            None => hours,
        }
    }

    /// Minutes with their unit behind some tokens.
    fn minutes_behind(&self, tokens: &[Token], skipped: usize) -> Option<Parsed<u32>> {
        let minutes = self.number(tokens.get(skipped..)?)?.behind(skipped);
        let unit = begins(&tokens[minutes.length..], &self.times.minutes)?;
        (minutes.value < MINUTES_OF_HOUR).then_some(minutes.with(unit))
    }

    /// A number in digits or words, no ordinal.
    fn number(&self, tokens: &[Token]) -> Option<Parsed<u32>> {
        let first = tokens.first()?;
        if first.kind == Kind::Digits {
            return small(&first.text).map(|value| Parsed::new(1, value));
        }
        if first.text.len() > LONGEST_WORD {
            return None;
        }
        // Without what follows, which may be a measure.
        // The longest first: `twenty` is the beginning of `twenty one`.
        let mut lengths = (1..=LONGEST_NUMBER.min(tokens.len())).rev();
        lengths.find_map(|length| self.spelt(&tokens[..length]))
    }

    /// The number that all of some tokens spell.
    fn spelt(&self, tokens: &[Token]) -> Option<Parsed<u32>> {
        match number(tokens, 0, self.vocabulary)? {
            Number {
                length,
                lex:
                    Lex::Number {
                        label,
                        ordinal: false,
                    },
            } if length == tokens.len() => small(&label).map(|value| Parsed::new(length, value)),
            _ => None,
        }
    }
}

/// What stands behind an hour.
struct Rest {
    minutes: u32,
    /// Whether it makes the number an hour.
    is_clock: bool,
}

/// A number that may be of a time.
fn small(digits: &str) -> Option<u32> {
    digits.parse().ok().filter(|value| *value <= LARGEST_NUMBER)
}

fn is_number(token: &Token) -> bool {
    match token.kind {
        Kind::Digits => true,
        Kind::Ideograph => numeral(&token.text).is_some(),
        Kind::Letters | Kind::Mark => false,
    }
}

/// Two digits that are minutes, with a blank before them or none: `17h30`, `18 Uhr 30`.
fn minutes_of(tokens: &[Token], may_be_apart: bool) -> Option<Parsed<u32>> {
    let token = tokens.first().filter(|token| token.glued || may_be_apart)?;
    if token.kind != Kind::Digits || token.text.len() != 2 {
        return None;
    }
    let minutes = token
        .text
        .parse()
        .ok()
        .filter(|minutes| *minutes < MINUTES_OF_HOUR)?;
    Some(Parsed::new(1, minutes))
}

/// What `read` finds behind one of `before`, or before one of `after`.
fn marked(
    tokens: &[Token],
    before: &[Phrase],
    after: &[Phrase],
    read: impl Fn(&[Token]) -> Option<Parsed<u32>>,
) -> Option<Parsed<u32>> {
    if let Some(marker) = begins(tokens, before)
        && let Some(found) = read(&tokens[marker..])
    {
        return Some(found.behind(marker));
    }
    let found = read(tokens)?;
    // Without its marker a time is no deadline.
    let marker = begins(&tokens[found.length..], after)?;
    Some(found.with(marker))
}

/// The length of the longest of `entries` that `tokens` begin with.
fn begins(tokens: &[Token], entries: &[Phrase]) -> Option<usize> {
    let fits = |entry: &&Phrase| {
        tokens.len() >= entry.len() && entry.iter().zip(tokens).all(|(e, t)| *e == t.text)
    };
    entries.iter().filter(fits).map(Vec::len).max()
}

/// Whether `tokens` end with one of `entries`.
fn ends(tokens: &[Token], entries: &[Phrase]) -> bool {
    entries.iter().any(|entry| {
        let start = tokens.len().checked_sub(entry.len());
        start.is_some_and(|start| {
            entry
                .iter()
                .zip(&tokens[start..])
                .all(|(e, t)| *e == t.text)
        })
    })
}
