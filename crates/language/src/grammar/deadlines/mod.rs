//! Until when a door is to be reached: `by 6 pm`, `within ten minutes`, `下午6点前`, `18時までに`.
//!
//! A deadline belongs to the door before it in its sentence, and to those that are listed with
//! that. It belongs to the door behind it where no door stands before it, or where a comma or the
//! like stands before it and none behind it. After `both` and the like it belongs to all doors of
//! the sentence. What is denied (`not before 6 pm`), of another day, or the end of a span (`9 to 6
//! pm`) is no deadline.

mod times;

use std::ops::Range;

use openbench_core::Deadline;

use self::times::TimeReader;
use super::door::Door;
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::words::Vocabulary;

/// The deadline of each door; of several the soonest.
pub(super) fn deadlines(
    reading: &Reading<'_>,
    vocabulary: Vocabulary<'_>,
    doors: &[Door],
) -> Vec<Option<Deadline>> {
    let readers: Vec<TimeReader<'_>> = vocabulary
        .times()
        .map(|times| TimeReader { times, vocabulary })
        .collect();
    let tokens = reading.tokens;
    let mut due: Vec<Option<Deadline>> = vec![None; doors.len()];
    let mut at = 0;
    while at < tokens.len() {
        // The second half of a span or of a length of time would look like a deadline of its own.
        let mut fresh = readers.iter().filter(|reader| !reader.goes_on(tokens, at));
        let Some(found) = fresh.find_map(|reader| reader.deadline(&tokens[at..])) else {
            at += 1;
            continue;
        };
        let time = at..at + found.length;
        // Behind the time even if it is no deadline: its tokens are not read again as a shorter
        // one.
        at = time.end;
        // In all languages in force, since the day may be said in another than the time.
        let is_today = readers
            .iter()
            .all(|reader| reader.is_today(tokens, time.clone()));
        if !is_today || is_denied(reading, time.clone()) {
            continue;
        }
        let is_of_all = readers
            .iter()
            .any(|reader| reader.is_of_all(tokens, time.start));
        let place = lexeme_of(reading, time.start);
        let meant = if is_of_all {
            all(reading, doors, place)
        } else {
            beside(reading, doors, place)
        };
        for door in meant {
            due[door] = due[door].into_iter().chain([found.value]).min();
        }
    }
    due
}

/// The lexeme that a token is of, or the next.
fn lexeme_of(reading: &Reading<'_>, token: usize) -> usize {
    reading
        .lexemes
        // Lexemes cover all tokens in order, so a binary search finds the one.
        .partition_point(|lexeme| lexeme.tokens.end <= token)
}

/// `not before 6 pm`, `下午6点前不要送`.
fn is_denied(reading: &Reading<'_>, tokens: Range<usize>) -> bool {
    let first = lexeme_of(reading, tokens.start);
    let next = lexeme_of(reading, tokens.end);
    // One word may stand between a `not` and the time.
    (first.saturating_sub(2)..first).any(|at| denies(reading, at)) || denies(reading, next)
}

fn denies(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Dropped, Except, Not, NotBefore};
    matches!(reading.class(at), Some(Not | Except | NotBefore | Dropped))
}

fn has_stop(reading: &Reading<'_>, mut range: Range<usize>) -> bool {
    range.any(|at| reading.is_stop(at))
}

/// All doors of the sentence around a place; if it has none, those of the one before or behind.
fn all(reading: &Reading<'_>, doors: &[Door], at: usize) -> Range<usize> {
    let first_of_sentence = doors
        .iter()
        .position(|door| door.last <= at && !has_stop(reading, door.last..at));
    let last_of_sentence = doors
        .iter()
        .rposition(|door| door.first >= at && !has_stop(reading, at..door.first));
    let first_behind = doors.iter().position(|door| door.first >= at);
    let last_before = doors.iter().rposition(|door| door.last <= at);
    let from = first_of_sentence.or(first_behind).unwrap_or(doors.len());
    let end = last_of_sentence
        .or(last_before)
        .map_or(from, |last| last + 1);
    from..end.max(from)
}

/// The doors that a deadline at a place stands with.
fn beside(reading: &Reading<'_>, doors: &[Door], at: usize) -> Range<usize> {
    if let Some(inside) = doors
        .iter()
        .position(|door| door.first < at && at < door.last)
    {
        return inside..inside + 1;
    }
    let before = doors.iter().rposition(|door| door.last <= at);
    let before = before.filter(|i| !has_stop(reading, doors[*i].last..at));
    let behind = doors.iter().position(|door| door.first >= at);
    let behind = behind.filter(|i| !has_stop(reading, at..doors[*i].first));
    // A comma before the deadline and none behind it ties it to the door that follows.
    let leads = before.zip(behind).is_some_and(|(before, behind)| {
        breaks(reading, doors[before].last..at) && !breaks(reading, at..doors[behind].first)
    });
    // The doors listed with the last one before the time share it.
    if let Some(last) = before.filter(|_| !leads) {
        let first = (1..=last)
            .rev()
            .find(|i| !are_listed(reading, &doors[i - 1], &doors[*i]))
            .unwrap_or(0);
        return first..last + 1;
    }
    let Some(first) = behind else { return 0..0 };
    let end = (first + 1..doors.len())
        .find(|i| !are_listed(reading, &doors[i - 1], &doors[*i]))
        .unwrap_or(doors.len());
    first..end
}

/// Whether a comma or the like stands in a range.
fn breaks(reading: &Reading<'_>, mut range: Range<usize>) -> bool {
    range.any(|at| {
        use Class::{And, Finally, Then};
        matches!(
            reading.lex(at),
            Some(Lex::Comma | Lex::Word(And | Then | Finally, _))
        )
    })
}

/// Whether nothing but commas, `and` and the like stand between two doors.
fn are_listed(reading: &Reading<'_>, a: &Door, b: &Door) -> bool {
    (a.last.min(b.first)..b.first).all(|at| {
        use Class::{And, Article, Link};
        matches!(
            reading.lex(at),
            Some(Lex::Comma | Lex::Word(And | Article | Link, _))
        )
    })
}
