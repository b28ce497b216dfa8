//! A part of an instruction whose words order doors.

use std::ops::Range;

use crate::grammar::door::Door;
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::wish::Precedes;

/// What the rules for orders see.
pub(crate) struct Part<'a> {
    pub reading: &'a Reading<'a>,
    /// Of the whole instruction.
    pub doors: &'a [Door],
    /// Whether words such as `then` part the doors into stages already.
    pub is_staged: bool,
}

impl Part<'_> {
    /// The last door that ends before a place.
    pub(super) fn door_before(&self, at: usize) -> Option<usize> {
        self.doors.iter().rposition(|door| door.last <= at)
    }

    /// The first door that begins behind a place.
    pub(super) fn door_behind(&self, at: usize) -> Option<usize> {
        self.doors.iter().position(|door| door.first > at)
    }

    /// The last door that ends before a place in the same sentence.
    pub(super) fn door_before_in_sentence(&self, at: usize) -> Option<usize> {
        self.doors
            .iter()
            .rposition(|door| door.last <= at && !self.has_stop(door.last..at))
    }

    /// The doors that begin behind a place in the same sentence.
    pub(super) fn doors_behind_in_sentence(&self, at: usize) -> impl Iterator<Item = usize> {
        (0..self.doors.len()).filter(move |i| {
            let first = self.doors[*i].first;
            first > at && !self.has_stop(at..first)
        })
    }

    /// Whether a sentence ends in a range.
    pub(super) fn has_stop(&self, mut range: Range<usize>) -> bool {
        range.any(|at| self.reading.is_stop(at))
    }

    /// The lexemes of the sentence around a place.
    pub(super) fn sentence(&self, at: usize) -> Range<usize> {
        let reading = self.reading;
        let stop_before = (0..at).rev().find(|at| reading.is_stop(*at));
        let stop_behind = (at..reading.lexemes.len()).find(|at| reading.is_stop(*at));
        stop_before.map_or(0, |stop| stop + 1)..stop_behind.unwrap_or(reading.lexemes.len())
    }

    /// Whether a `then` or `last` ends its sentence and so is of a door before it: `building 3
    /// comes last.`
    pub(super) fn is_behind(&self, at: usize) -> bool {
        let reading = self.reading;
        let Range { start, end } = self.sentence(at);
        let is_before_comma = reading.lex(at + 1) == Some(&Lex::Comma);
        // `3号楼的随后再送，…`
        let ends = matches!(reading.lex(at), Some(Lex::Word(_, true))) && is_before_comma;
        // `Haus 5 kommt als Letztes dran, vorher …`, but `and finally, building 5`
        let is_last = reading.class(at) == Some(Class::Finally) && !is_before_comma;
        let end = (at..end)
            .find(|at| is_last && reading.lex(*at) == Some(&Lex::Comma))
            .unwrap_or(end);
        let has_door_behind = self
            .doors
            .iter()
            .any(|door| door.first > at && door.first < end);
        let has_door_before = self
            .doors
            .iter()
            .any(|door| door.first >= start && door.last <= at);
        (ends || !has_door_behind) && has_door_before
    }

    /// One door before all others.
    pub(super) fn first(&self, door: usize) -> Vec<Precedes> {
        self.others(door)
            .map(|later| Precedes {
                earlier: door,
                later,
            })
            .collect()
    }

    /// One door behind all others.
    pub(super) fn last(&self, door: usize) -> Vec<Precedes> {
        self.others(door)
            .map(|earlier| Precedes {
                earlier,
                later: door,
            })
            .collect()
    }

    fn others(&self, door: usize) -> impl Iterator<Item = usize> {
        (0..self.doors.len()).filter(move |i| *i != door)
    }
}
