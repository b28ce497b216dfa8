//! What is said of an address above the building and below the unit: the words around each door, among which its street or quarter may be found, floors, and flats behind a unit.

use std::ops::Range;

use openbench_core::{AddressLevel, Level as AddressKind};

use super::lexicon::Class;
use super::mentions::{Level, Mention, Target};
use super::pairing::Door;
use super::reading::Reading;
use super::text::spelt;
use super::words::Lex;

/// What is said besides building and unit of a door.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Beside {
    /// The words between the doors before and after it, [`spelt`].
    pub around: String,
    /// Floor and flat.
    pub below: Vec<AddressLevel>,
}

/// What is said besides each door; `rooms` are the flats and rooms that are meant.
pub(crate) fn beside(reading: &Reading<'_>, doors: &[Door], rooms: &[Mention]) -> Vec<Beside> {
    let of = |door: &Door| {
        let before = doors.iter().map(|other| other.last).filter(|last| *last <= door.first).max();
        let after = doors.iter().map(|other| other.first).filter(|first| *first >= door.last).min();
        let from = before.map_or(0, |last| border(reading, last..door.first));
        let to = after.map_or(reading.lexemes.len(), |first| border(reading, door.last..first));
        // What is below a door is said in its own sentence.
        let begin = (from..door.first).rev().find(|at| ends(reading, *at)).unwrap_or(from);
        let end = (door.last..to).find(|at| ends(reading, *at)).unwrap_or(to);
        // Of several the last: it corrects the others.
        let floor = (begin..end).rev().find_map(|at| floor(reading, at, doors));
        let floor = floor.map(|label| named(AddressKind::Floor, &label));
        let is_unit = |room: &Mention| door.unit.as_ref() == room.targets.first();
        let is_here = |room: &&Mention| room.at.start >= begin && room.at.end <= end && !is_unit(room);
        let flat = rooms.iter().rev().find(is_here).and_then(|room| match &room.targets[..] {
            [Target::Label { label, .. }] => Some(named(AddressKind::Flat, label)),
            _ => None,
        });
        Beside { around: said(reading, from..to), below: floor.into_iter().chain(flat).collect() }
    };
    doors.iter().map(of).collect()
}

/// What is said before all doors and of all of them: `In Rose Estate: …`.
pub(crate) fn of_all(reading: &Reading<'_>, doors: &[Door]) -> String {
    let first = doors.iter().map(|door| door.first).min().unwrap_or_default();
    let parts = |at: &usize| matches!(reading.lex(*at), Some(Lex::Comma | Lex::Mark | Lex::Stop));
    (0..first).rev().find(parts).map(|end| said(reading, 0..end)).unwrap_or_default()
}

/// The words of some lexemes, [`spelt`], without what is denied, is where something comes from, or is corrected.
fn said(reading: &Reading<'_>, at: Range<usize>) -> String {
    let corrects = |at: &usize| reading.class(*at) == Some(Class::Correct);
    let start = at.clone().rev().find(corrects).map_or(at.start, |correct| correct + 1);
    let ends = |at: usize| {
        matches!(reading.lex(at), Some(Lex::Comma | Lex::Stop | Lex::Word(Class::And | Class::Then, _)))
    };
    let clauses = (start..at.end).collect::<Vec<usize>>();
    let of_clause = |clause: &[usize]| {
        let (first, last) = (*clause.first()?, *clause.last()?);
        let class = |at: &&usize| reading.class(**at);
        if clause.iter().any(|at| matches!(class(&at), Some(Class::NotBefore | Class::Dropped))) {
            return None;
        }
        let denial = clause.iter().find(|at| {
            matches!(class(at), Some(Class::Not | Class::Except | Class::Elsewhere | Class::Sender))
        });
        Some(spelt(reading.words(first..denial.map_or(last + 1, |denial| *denial))))
    };
    clauses.split(|at| ends(*at)).filter_map(of_clause).collect()
}

/// Where, between two doors, what is said of the second one begins: after the first end of a sentence or `and`, else after the last comma.
fn border(reading: &Reading<'_>, gap: Range<usize>) -> usize {
    let parts = |at: &usize| {
        ends(reading, *at) || matches!(reading.class(*at), Some(Class::And | Class::Then | Class::Finally))
    };
    let comma = |at: &usize| reading.lex(*at) == Some(&Lex::Comma);
    gap.clone().find(parts).or_else(|| gap.clone().rev().find(comma)).unwrap_or(gap.start)
}

/// Whether a sentence ends here: not at the point of `4. Stock`.
fn ends(reading: &Reading<'_>, at: usize) -> bool {
    let is_ordinal = reading.class(at + 1) == Some(Class::Floor)
        && !matches!(reading.lex(at + 2), Some(Lex::Number { .. }))
        && at > 0
        && matches!(reading.lex(at - 1), Some(Lex::Number { .. }));
    reading.lex(at) == Some(&Lex::Stop) && !is_ordinal
}

/// The mentions of flats and rooms.
pub(crate) fn rooms(mentions: &[Mention]) -> Vec<Mention> {
    mentions.iter().filter(|mention| mention.level == Level::Room).cloned().collect()
}

fn named(level: AddressKind, label: &str) -> AddressLevel {
    let word = if level == AddressKind::Floor { "floor" } else { "flat" };
    AddressLevel { level, name: format!("{word}{}", label.to_uppercase()) }
}

/// The number of the floor whose word stands at a place: `3rd floor`, `floor 3`, `3. Stock`, `5层`. What is a building's or a unit's is no floor's.
fn floor(reading: &Reading<'_>, at: usize, doors: &[Door]) -> Option<String> {
    let Some(Lex::Word(Class::Floor, number_first)) = reading.lex(at) else { return None };
    let number = |at: usize| match reading.lex(at)? {
        Lex::Number { label, ordinal } => Some((label.clone(), *ordinal)),
        _ => None,
    };
    let is_free = |at: &usize| !doors.iter().any(|door| (door.first..door.last).contains(at));
    let beside = at.checked_sub(1).filter(is_free).and_then(number);
    let before = beside.filter(|(_, ordinal)| *ordinal || *number_first).map(|(label, _)| label);
    let behind = || number(at + 1).filter(|(_, ordinal)| !ordinal).map(|(label, _)| label);
    let is_point = at > 0 && is_point(reading, at - 1);
    let pointed = || at.checked_sub(2).filter(|at| is_point && is_free(at)).and_then(number);
    before.or_else(behind).or_else(|| pointed().map(|(label, _)| label))
}

fn is_point(reading: &Reading<'_>, at: usize) -> bool {
    reading.lex(at) == Some(&Lex::Stop) && reading.token(at).is_some_and(|token| token.text == ".")
}
