//! Until when a door is to be reached: `by 6 pm`, `within ten minutes`, `下午6点前`, `18時までに`.
//!
//! A deadline belongs to the door before it in its sentence, and to those that are listed with that; where no door stands before it, or a comma or the like comes between and
//! none between it and the next one, to the one after; after `both` and the like to all doors of the sentence. What is denied (`not before 6 pm`), of another day, or the end of a span (`9 to 6 pm`) is none.

use std::ops::Range;

use openbench_core::Deadline;

use super::lexicon::{Class, LANGUAGES, Times};
use super::numbers;
use super::pairing::Door;
use super::reading::Reading;
use super::text::{Kind, Token, tokenize};
use super::words::{Languages, Lex, Words};

/// A day that is named so many tokens from a time is the time's.
const DAY_BESIDE: usize = 3;
/// A word for all doors is so many tokens before a deadline at most.
const ALL_BESIDE: usize = 5;
/// No number is a longer word, bytes.
const LONGEST_WORD: usize = 40;
/// The most tokens that a number spelt in words takes.
const LONGEST_NUMBER: usize = 4;

/// The deadline of each door.
pub(super) fn deadlines(
    reading: &Reading<'_>,
    words: &Words,
    languages: Languages,
    doors: &[Door],
) -> Vec<Option<Deadline>> {
    let mut due: Vec<Option<Deadline>> = vec![None; doors.len()];
    let speakers: Vec<Speaker<'_>> = (0..LANGUAGES.len())
        .filter(|language| languages & (1 << language) != 0)
        .map(|language| Speaker { times: &words.times[language], words, languages })
        .collect();
    let mut at = 0;
    while at < reading.tokens.len() {
        let mut fresh = speakers.iter().filter(|s| !s.goes_on(reading.tokens, at));
        let Some((length, deadline)) = fresh.find_map(|s| s.deadline(&reading.tokens[at..])) else {
            at += 1;
            continue;
        };
        let time = at..at + length;
        at += length;
        if is_denied(reading, time.clone())
            || !speakers.iter().all(|s| s.is_today(reading.tokens, time.clone()))
        {
            continue;
        }
        let is_of_all = speakers.iter().any(|s| s.is_of_all(reading.tokens, time.start));
        for door in meant(reading, doors, time.start, is_of_all) {
            due[door] = Some(due[door].map_or(deadline, |known| known.min(deadline)));
        }
    }
    due
}

/// The doors that a deadline at a token is for.
fn meant(reading: &Reading<'_>, doors: &[Door], token: usize, is_of_all: bool) -> Range<usize> {
    let at = lexeme_of(reading, token);
    let parted = |from: usize, to: usize| (from..to).any(|i| reading.lex(i) == Some(&Lex::Stop));
    let breaks = |from: usize, to: usize| {
        let is_break =
            |lex: &Lex| matches!(lex, Lex::Comma | Lex::Word(Class::And | Class::Then | Class::Finally, _));
        (from..to).any(|i| reading.lex(i).is_some_and(is_break))
    };
    let listed = |a: &Door, b: &Door| {
        (a.last.min(b.first)..b.first).all(|i| {
            matches!(
                reading.lex(i),
                Some(Lex::Comma | Lex::Word(Class::And | Class::Article | Class::Link, _))
            )
        })
    };
    if is_of_all {
        let first = doors.iter().position(|d| d.last <= at && !parted(d.last, at));
        let end = doors.iter().rposition(|d| d.first >= at && !parted(at, d.first)).map(|i| i + 1);
        let none_before = || doors.iter().position(|d| d.first >= at).unwrap_or(doors.len());
        let from = first.unwrap_or_else(none_before);
        let before = || doors.iter().rposition(|d| d.last <= at).map_or(from, |i| i + 1);
        return from..end.unwrap_or_else(before).max(from);
    }
    if let Some(inside) = doors.iter().position(|d| d.first < at && at < d.last) {
        return inside..inside + 1;
    }
    let before = doors.iter().rposition(|d| d.last <= at).filter(|i| !parted(doors[*i].last, at));
    let after = doors.iter().position(|d| d.first >= at).filter(|i| !parted(at, doors[*i].first));
    let leads = before
        .zip(after)
        .is_some_and(|(before, after)| breaks(doors[before].last, at) && !breaks(at, doors[after].first));
    if let Some(last) = before.filter(|_| !leads) {
        let first = (1..=last).rev().find(|i| !listed(&doors[i - 1], &doors[*i])).unwrap_or(0);
        return first..last + 1;
    }
    let Some(first) = after else { return 0..0 };
    let end = (first + 1..doors.len()).find(|i| !listed(&doors[i - 1], &doors[*i])).unwrap_or(doors.len());
    first..end
}

/// The lexeme that a token is of, or the next.
fn lexeme_of(reading: &Reading<'_>, token: usize) -> usize {
    reading.lexemes.partition_point(|l| l.tokens.end <= token)
}

/// `not before 6 pm`, `下午6点前不要送`.
fn is_denied(reading: &Reading<'_>, tokens: Range<usize>) -> bool {
    let denies = |at: usize| {
        matches!(reading.class(at), Some(Class::Not | Class::Except | Class::NotBefore | Class::Dropped))
    };
    let (first, next) = (lexeme_of(reading, tokens.start), lexeme_of(reading, tokens.end));
    (first.saturating_sub(2)..first).any(denies) || denies(next)
}

/// A language's [`Times`] as tokens.
pub(crate) struct FoldedTimes {
    by: Vec<Vec<String>>,
    by_after: Vec<Vec<String>>,
    within: Vec<Vec<String>>,
    within_after: Vec<Vec<String>>,
    at: Vec<Vec<String>>,
    clock: Vec<Vec<String>>,
    half: Vec<Vec<String>>,
    am: Vec<Vec<String>>,
    pm: Vec<Vec<String>>,
    noon: Vec<Vec<String>>,
    minutes: Vec<Vec<String>>,
    hours: Vec<Vec<String>>,
    half_hour: Vec<Vec<String>>,
    one_hour: Vec<Vec<String>>,
    all: Vec<Vec<String>>,
    other_days: Vec<Vec<String>>,
    from: Vec<Vec<String>>,
    has_half_days: bool,
}

impl FoldedTimes {
    pub(super) fn new(times: &Times) -> Self {
        let folded = |entries: &[&str]| -> Vec<Vec<String>> {
            entries
                .iter()
                .map(|entry| tokenize(entry).into_iter().map(|token| token.text).collect())
                .collect()
        };
        Self {
            by: folded(times.by),
            by_after: folded(times.by_after),
            within: folded(times.within),
            within_after: folded(times.within_after),
            at: folded(times.at),
            clock: folded(times.clock),
            half: folded(times.half),
            am: folded(times.am),
            pm: folded(times.pm),
            noon: folded(times.noon),
            minutes: folded(times.minutes),
            hours: folded(times.hours),
            half_hour: folded(times.half_hour),
            one_hour: folded(times.one_hour),
            all: folded(times.all),
            other_days: folded(times.other_days),
            from: folded(times.from),
            has_half_days: times.has_half_days,
        }
    }
}

/// Reads times in one language.
struct Speaker<'a> {
    times: &'a FoldedTimes,
    words: &'a Words,
    languages: Languages,
}

impl Speaker<'_> {
    /// The deadline at the beginning of `tokens`: how many tokens, and when.
    fn deadline(&self, tokens: &[Token]) -> Option<(usize, Deadline)> {
        let clock = |(length, minutes)| (length, Deadline::Clock { minutes });
        let within = |(length, seconds)| (length, Deadline::Within { seconds });
        // `d'ici 2 heures` is no time of day.
        let length = self.marked(tokens, &self.times.within, &self.times.within_after, |t| self.duration(t));
        let by_clock = || {
            let marker = begins(tokens, &self.times.by)?;
            let (length, minutes) = self.bare_hour(tokens, marker)?;
            Some((marker + length, minutes))
        };
        length.map(within).or_else(|| {
            let marked = self.marked(tokens, &self.times.by, &self.times.by_after, |t| self.clock(t));
            marked.or_else(by_clock).map(clock)
        })
    }

    /// Whether what stands at a token goes on with a time before it: `9 am to 6 pm`, `von 9 bis 17 Uhr`, `1小时30分钟内`.
    fn goes_on(&self, tokens: &[Token], at: usize) -> bool {
        let ends_before = |at: usize, entries: &[Vec<String>]| {
            entries.iter().any(|entry| {
                let start = at.checked_sub(entry.len());
                start.is_some_and(|start| entry.iter().zip(&tokens[start..at]).all(|(e, t)| *e == t.text))
            })
        };
        let is_number = |at: usize| match tokens[at].kind {
            Kind::Digits => true,
            Kind::Ideograph => numbers::numeral(&tokens[at].text).is_some(),
            _ => false,
        };
        let times = self.times;
        let is_span = at >= 1 && is_number(at - 1) && ends_before(at - 1, &times.from);
        let lists = [&times.clock, &times.am, &times.pm, &times.minutes, &times.hours];
        let is_rest =
            at >= 1 && is_number(at) && (is_number(at - 1) || tokens[at - 1].text == "." && tokens[at].glued);
        is_span || is_rest || lists.into_iter().any(|entries| ends_before(at, entries))
    }

    /// Whether a deadline that begins at a token is of all doors: `both by 6 pm`, `都要在下午6点前`.
    fn is_of_all(&self, tokens: &[Token], at: usize) -> bool {
        let near = at.saturating_sub(ALL_BESIDE)..at;
        near.into_iter().any(|from| begins(&tokens[from..at], &self.times.all).is_some())
    }

    /// Whether no other day is named beside a time.
    fn is_today(&self, tokens: &[Token], time: Range<usize>) -> bool {
        let beside = time.start.saturating_sub(DAY_BESIDE)..(time.end + DAY_BESIDE).min(tokens.len());
        let mut outside = beside.filter(|at| !time.contains(at));
        outside.all(|at| begins(&tokens[at..], &self.times.other_days).is_none())
    }

    /// What `read` finds after one of `before`, or before one of `after`.
    fn marked(
        &self,
        tokens: &[Token],
        before: &[Vec<String>],
        after: &[Vec<String>],
        read: impl Fn(&[Token]) -> Option<(usize, u32)>,
    ) -> Option<(usize, u32)> {
        if let Some(marker) = begins(tokens, before)
            && let Some((length, value)) = read(&tokens[marker..])
        {
            return Some((marker + length, value));
        }
        let (length, value) = read(tokens)?;
        let marker = begins(&tokens[length..], after)?;
        Some((length + marker, value))
    }

    /// An hour with no word for it, where nothing else can be meant: `antes de las 10`, or `by 4` at the end of a sentence.
    fn bare_hour(&self, tokens: &[Token], marker: usize) -> Option<(usize, u32)> {
        let rest = &tokens[marker..];
        let (length, hour) = self.number(rest).filter(|(_, hour)| *hour <= 24)?;
        let is_of_hours = matches!(tokens[marker.checked_sub(1)?].text.as_str(), "las" | "la");
        let is_last = rest.get(length).is_none_or(|next| matches!(next.text.as_str(), "." | "!" | "?" | ";"));
        let is_by = marker == 1 && tokens[0].text == "by";
        (is_of_hours || is_by && is_last).then(|| (length, self.by_day(hour, 0, None) * 60))
    }

    /// The hour of twenty-four; parcels are brought by day.
    fn by_day(&self, hour: u32, minutes: u32, is_afternoon: Option<bool>) -> u32 {
        let latest = if minutes > 0 { 6 } else { 7 };
        match is_afternoon {
            Some(true) if hour < 12 => hour + 12,
            Some(false) if hour == 12 => 24,
            None if self.times.has_half_days && (1..=latest).contains(&hour) => hour + 12,
            _ => hour,
        }
    }

    /// A time of day, minutes since midnight: `6 pm`, `18:30`, `下午6点半`, `noon`.
    fn clock(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        let noon = begins(tokens, &self.times.noon);
        // `中午1点`
        let before = noon.map(|length| (length, true)).or_else(|| self.half_of_day(tokens));
        let read = self.hour_and_minutes(tokens, before);
        read.or_else(|| noon.map(|length| (length, 12 * 60)))
    }

    /// A time of day after the words for its half, if any.
    fn hour_and_minutes(&self, tokens: &[Token], before: Option<(usize, bool)>) -> Option<(usize, u32)> {
        let mut at = before.map_or(0, |(length, _)| length);
        let marker = begins(&tokens[at..], &self.times.at);
        at += marker.unwrap_or(0);
        let (length, hour) = self.number(&tokens[at..])?;
        at += length;
        let mut minutes = 0;
        let mut is_clock = marker.is_some();
        if let Some(length) = begins(&tokens[at..], &self.times.clock) {
            at += length;
            is_clock = true;
            if let Some(length) = begins(&tokens[at..], &self.times.half) {
                (at, minutes) = (at + length, 30);
            } else if let Some((length, value)) = minutes_of(&tokens[at..], !self.times.has_half_days) {
                (at, minutes) = (at + length, value);
                at += begins(&tokens[at..], &self.times.minutes).unwrap_or(0);
            }
        } else if tokens.get(at).is_some_and(|t| t.glued && matches!(t.text.as_str(), ":" | "."))
            && let Some((length, value)) = minutes_of(&tokens[at + 1..], false)
        {
            // `12.50` may be a price.
            is_clock = tokens[at].text == ":";
            (at, minutes) = (at + 1 + length, value);
            let clock = begins(&tokens[at..], &self.times.clock);
            is_clock |= clock.is_some();
            at += clock.unwrap_or(0);
        }
        let after = self.half_of_day(&tokens[at..]);
        at += after.map_or(0, |(length, _)| length);
        let half = before.or(after).map(|(_, is_afternoon)| is_afternoon);
        let hour = self.by_day(hour, minutes, half);
        let minutes = hour * 60 + minutes;
        ((is_clock || half.is_some()) && minutes <= 24 * 60).then_some((at, minutes))
    }

    /// Words for the half of the day, and whether it is the second.
    fn half_of_day(&self, tokens: &[Token]) -> Option<(usize, bool)> {
        let afternoon = begins(tokens, &self.times.pm).map(|length| (length, true));
        afternoon.or_else(|| begins(tokens, &self.times.am).map(|length| (length, false)))
    }

    /// How long, seconds: `ten minutes`, `2 hours`, `half an hour`.
    fn duration(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        if let Some(length) = begins(tokens, &self.times.half_hour) {
            return Some((length, 30 * 60));
        }
        if let Some(length) = begins(tokens, &self.times.one_hour) {
            let more = self.minutes_more(&tokens[length..]);
            return Some(
                more.map_or((length, 3600), |(after, minutes)| (length + after, 3600 + 60 * minutes)),
            );
        }
        let (at, value) = self.number(tokens)?;
        let units = [(&self.times.minutes, 60), (&self.times.hours, 3600)];
        let unit =
            units.into_iter().find_map(|(unit, seconds)| Some((begins(&tokens[at..], unit)?, seconds)));
        let (length, seconds) = unit?;
        let (at, sum) = (at + length, value * seconds);
        let more = (seconds == 3600).then(|| self.minutes_more(&tokens[at..])).flatten();
        Some(more.map_or((at, sum), |(length, minutes)| (at + length, sum + 60 * minutes)))
    }

    /// The minutes after hours: `1 hour 30 minutes`, `une heure et 15 minutes`.
    fn minutes_more(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        (0..=1).find_map(|skipped| {
            let (length, minutes) = self.number(tokens.get(skipped..)?)?;
            let unit = begins(&tokens[skipped + length..], &self.times.minutes)?;
            (minutes < 60).then_some((skipped + length + unit, minutes))
        })
    }

    /// A number in digits or words, no ordinal, below a thousand.
    fn number(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        let first = tokens.first()?;
        if first.kind == Kind::Digits {
            return first.text.parse().ok().filter(|n| *n < 1000).map(|n| (1, n));
        }
        if first.text.len() > LONGEST_WORD {
            return None;
        }
        // Without what follows, which may be a measure.
        (1..=LONGEST_NUMBER.min(tokens.len())).rev().find_map(|length| {
            match numbers::number(self.words, &tokens[..length], 0, self.languages)? {
                (taken, Lex::Number { label, ordinal: false }) if taken == length => {
                    label.parse().ok().filter(|n| *n < 1000).map(|n| (length, n))
                }
                _ => None,
            }
        })
    }
}

/// Two digits that are minutes, with a blank before them or none: `17h30`, `18 Uhr 30`.
fn minutes_of(tokens: &[Token], may_be_apart: bool) -> Option<(usize, u32)> {
    let is_near = |t: &&Token| t.glued || may_be_apart;
    let token = tokens.first().filter(is_near).filter(|t| t.kind == Kind::Digits && t.text.len() == 2)?;
    token.text.parse().ok().filter(|minutes| *minutes < 60).map(|minutes| (1, minutes))
}

/// The length of the longest of `entries` that `tokens` begin with.
fn begins(tokens: &[Token], entries: &[Vec<String>]) -> Option<usize> {
    let fits = |entry: &Vec<String>| {
        let same = tokens.len() >= entry.len() && entry.iter().zip(tokens).all(|(e, t)| *e == t.text);
        same.then_some(entry.len())
    };
    entries.iter().filter_map(fits).max()
}
