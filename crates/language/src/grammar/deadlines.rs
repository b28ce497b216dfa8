//! Until when a door is to be reached: `by 6 pm`, `within ten minutes`, `下午6点前`, `18時までに`.
//!
//! A deadline belongs to the door before it in its sentence, and to those that are listed with that; where no door stands before it, to the one after.

use openbench_core::Deadline;

use super::lexicon::{Class, LANGUAGES, Times};
use super::mentions::Reading;
use super::numbers;
use super::pairing::Door;
use super::text::{Kind, Token, tokenize};
use super::words::{Languages, Lex, Words};

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
        let Some((length, deadline)) = speakers.iter().find_map(|s| s.deadline(&reading.tokens[at..])) else {
            at += 1;
            continue;
        };
        for door in meant(reading, doors, at) {
            due[door] = Some(due[door].map_or(deadline, |known| known.min(deadline)));
        }
        at += length;
    }
    due
}

/// The doors that a deadline at a token is for.
fn meant(reading: &Reading<'_>, doors: &[Door], token: usize) -> std::ops::Range<usize> {
    let Some(at) = reading.lexemes.iter().position(|l| l.tokens.end > token) else { return 0..0 };
    let parted = |from: usize, to: usize| (from..to).any(|i| reading.lex(i) == Some(&Lex::Stop));
    let listed = |a: &Door, b: &Door| {
        (a.last.min(b.first)..b.first).all(|i| {
            matches!(
                reading.lex(i),
                Some(Lex::Comma | Lex::Word(Class::And | Class::Article | Class::Link, _))
            )
        })
    };
    if let Some(last) = doors.iter().rposition(|d| d.last <= at).filter(|i| !parted(doors[*i].last, at)) {
        let first = (1..=last).rev().find(|i| !listed(&doors[i - 1], &doors[*i])).unwrap_or(0);
        return first..last + 1;
    }
    let Some(first) = doors.iter().position(|d| d.first >= at && !parted(at, d.first)) else { return 0..0 };
    let end = (first + 1..doors.len()).find(|i| !listed(&doors[i - 1], &doors[*i])).unwrap_or(doors.len());
    first..end
}

/// A language's [`Times`] as tokens.
pub(crate) struct FoldedTimes {
    by: Vec<Vec<String>>,
    by_after: Vec<Vec<String>>,
    within: Vec<Vec<String>>,
    within_after: Vec<Vec<String>>,
    clock: Vec<Vec<String>>,
    half: Vec<Vec<String>>,
    am: Vec<Vec<String>>,
    pm: Vec<Vec<String>>,
    noon: Vec<Vec<String>>,
    minutes: Vec<Vec<String>>,
    hours: Vec<Vec<String>>,
    half_hour: Vec<Vec<String>>,
    one_hour: Vec<Vec<String>>,
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
            clock: folded(times.clock),
            half: folded(times.half),
            am: folded(times.am),
            pm: folded(times.pm),
            noon: folded(times.noon),
            minutes: folded(times.minutes),
            hours: folded(times.hours),
            half_hour: folded(times.half_hour),
            one_hour: folded(times.one_hour),
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
        self.marked(tokens, &self.times.by, &self.times.by_after, |t| self.clock(t)).map(clock).or_else(
            || {
                self.marked(tokens, &self.times.within, &self.times.within_after, |t| self.duration(t))
                    .map(within)
            },
        )
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

    /// A time of day, minutes since midnight: `6 pm`, `18:30`, `下午6点半`, `noon`.
    fn clock(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        if let Some(length) = begins(tokens, &self.times.noon) {
            return Some((length, 12 * 60));
        }
        let before = self.half_of_day(tokens);
        let mut at = before.map_or(0, |(length, _)| length);
        let (length, hour) = self.number(&tokens[at..])?;
        at += length;
        let mut minutes = 0;
        let mut is_clock = false;
        if let Some(length) = begins(&tokens[at..], &self.times.clock) {
            at += length;
            is_clock = true;
            if let Some(length) = begins(&tokens[at..], &self.times.half) {
                (at, minutes) = (at + length, 30);
            } else if let Some((length, value)) = glued_minutes(&tokens[at..]) {
                (at, minutes) = (at + length, value);
                at += begins(&tokens[at..], &self.times.minutes).unwrap_or(0);
            }
        } else if tokens.get(at).is_some_and(|t| t.glued && matches!(t.text.as_str(), ":" | "."))
            && let Some((length, value)) = glued_minutes(&tokens[at + 1..])
        {
            (at, minutes, is_clock) = (at + 1 + length, value, true);
            at += begins(&tokens[at..], &self.times.clock).unwrap_or(0);
        }
        let after = self.half_of_day(&tokens[at..]);
        at += after.map_or(0, |(length, _)| length);
        let half = before.or(after).map(|(_, is_afternoon)| is_afternoon);
        let hour = match half {
            Some(true) if hour < 12 => hour + 12,
            Some(false) if hour == 12 => 0,
            _ => hour,
        };
        ((is_clock || half.is_some()) && hour <= 24).then_some((at, hour * 60 + minutes))
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
            return Some((length, 3600));
        }
        let (at, value) = self.number(tokens)?;
        let units = [(&self.times.minutes, 60), (&self.times.hours, 3600)];
        let unit =
            units.into_iter().find_map(|(unit, seconds)| Some((begins(&tokens[at..], unit)?, seconds)));
        unit.map(|(length, seconds)| (at + length, value * seconds))
    }

    /// A number in digits or words, no ordinal, below a thousand.
    fn number(&self, tokens: &[Token]) -> Option<(usize, u32)> {
        let first = tokens.first()?;
        if first.kind == Kind::Digits {
            return first.text.parse().ok().filter(|n| *n < 1000).map(|n| (1, n));
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

/// Two digits that are minutes, with no blank before them.
fn glued_minutes(tokens: &[Token]) -> Option<(usize, u32)> {
    let token = tokens.first().filter(|t| t.glued && t.kind == Kind::Digits && t.text.len() == 2)?;
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
