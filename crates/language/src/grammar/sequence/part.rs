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

    /// Whether a sentence ends in a range.
    pub(super) fn has_stop(&self, mut range: Range<usize>) -> bool {
        range.any(|at| self.reading.is_stop(at))
    }

    /// The lexemes of the sentence around a place.
    pub(super) fn sentence(&self, at: usize) -> Range<usize> {
        let is_stop = |at: &usize| self.reading.is_stop(*at);
        let end = self.reading.lexemes.len();
        let begin = (0..at).rev().find(is_stop).map_or(0, |stop| stop + 1);
        begin..(at..end).find(is_stop).unwrap_or(end)
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
        let is_comma = |at: &usize| is_last && reading.lex(*at) == Some(&Lex::Comma);
        let end = (at..end).find(is_comma).unwrap_or(end);
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
