//! What is said of an address above the building and below the unit: the words around each door,
//! among which its street or quarter may be found, floors, and flats behind a unit.

use std::ops::Range;

use openbench_core::{AddressLevel, Level as AddressKind};

use super::door::Door;
use super::mentions::mention::{Level, Mention, Target};
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::marks;
use crate::lexicon::tokens::spelt;

/// What is said besides building and unit of a door.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Beside {
    /// The words between the doors before and behind it, [`spelt`].
    pub around: String,
    /// Floor and flat.
    pub below: Vec<AddressLevel>,
}

/// What is said besides each door; `rooms` are the flats and rooms that are meant.
pub(crate) fn beside(reading: &Reading<'_>, doors: &[Door], rooms: &[Mention]) -> Vec<Beside> {
    doors
        .iter()
        .map(|door| beside_door(reading, doors, rooms, door))
        .collect()
}

fn beside_door(reading: &Reading<'_>, doors: &[Door], rooms: &[Mention], door: &Door) -> Beside {
    let around = around(reading, doors, door);
    let sentence = own_sentence(reading, door, &around);
    // Of several floors the last: it corrects the others.
    let floor = sentence
        .clone()
        .rev()
        .find_map(|at| floor(reading, at, doors))
        .map(|label| level(AddressKind::Floor, &label));
    let flat = flat(rooms, door, &sentence);
    Beside {
        around: said(reading, around),
        below: floor.into_iter().chain(flat).collect(),
    }
}

/// The lexemes around a door that are said of it.
fn around(reading: &Reading<'_>, doors: &[Door], door: &Door) -> Range<usize> {
    let before = doors
        .iter()
        .map(|other| other.last)
        .filter(|last| *last <= door.first)
        .max();
    let behind = doors
        .iter()
        .map(|other| other.first)
        .filter(|first| *first >= door.last)
        .min();
    // What stands between two doors is of one of them; the border says where the second one's
    // begins.
    let from = before.map_or(0, |last| border(reading, last..door.first));
    let to = behind.map_or(reading.lexemes.len(), |first| {
        border(reading, door.last..first)
    });
    from..to
}

/// Of the lexemes around a door those of its own sentence, where what is below it is said.
fn own_sentence(reading: &Reading<'_>, door: &Door, around: &Range<usize>) -> Range<usize> {
    let begin = (around.start..door.first)
        .rev()
        .find(|at| ends_a_sentence(reading, *at))
        .unwrap_or(around.start);
    let end = (door.last..around.end)
        .find(|at| ends_a_sentence(reading, *at))
        .unwrap_or(around.end);
    begin..end
}

/// The last room in a sentence that is not the door's own unit.
fn flat(rooms: &[Mention], door: &Door, sentence: &Range<usize>) -> Option<AddressLevel> {
    let flat = rooms.iter().rev().find(|room| {
        let is_here = room.at.start >= sentence.start && room.at.end <= sentence.end;
        // A room that stands for the unit is the door itself.
        is_here && door.unit.as_ref() != room.targets.first()
    })?;
    match &flat.targets[..] {
        [Target::Label { label, .. }] => Some(level(AddressKind::Flat, label)),
        _ => None,
    }
}

/// What is said before all doors and of all of them: `In Rose Estate: …`.
pub(crate) fn of_all(reading: &Reading<'_>, doors: &[Door]) -> String {
    let first = doors
        .iter()
        .map(|door| door.first)
        .min()
        .unwrap_or_default();
    (0..first)
        .rev()
        .find(|at| matches!(reading.lex(*at), Some(Lex::Comma | Lex::Mark | Lex::Stop)))
        .map(|end| said(reading, 0..end))
        .unwrap_or_default()
}

/// The words of some lexemes, [`spelt`], without what is denied, is where something comes from, or
/// is corrected.
fn said(reading: &Reading<'_>, at: Range<usize>) -> String {
    // What stands before the last correction was taken back.
    let start = at
        .clone()
        .rev()
        .find(|at| reading.class(*at) == Some(Class::Correct))
        .map_or(at.start, |correct| correct + 1);
    let lexemes: Vec<usize> = (start..at.end).collect();
    let clauses = lexemes.split(|at| ends_a_clause(reading, *at));
    clauses
        .filter_map(|clause| said_in_clause(reading, clause))
        .collect()
}

fn ends_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.lex(at),
        Some(Lex::Comma | Lex::Stop | Lex::Word(Class::And | Class::Then, _))
    )
}

/// The words of a clause up to a denial; none if it denies what stands before it.
fn said_in_clause(reading: &Reading<'_>, clause: &[usize]) -> Option<String> {
    let first = *clause.first()?;
    let end = *clause.last()? + 1;
    if (first..end).any(|at| denies_what_is_before(reading, at)) {
        return None;
    }
    let denial = (first..end).find(|at| denies_what_is_behind(reading, *at));
    Some(spelt(reading.words(first..denial.unwrap_or(end))))
}

fn denies_what_is_before(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::NotBefore | Class::Dropped))
}

fn denies_what_is_behind(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Elsewhere, Except, Not, Sender};
    matches!(reading.class(at), Some(Not | Except | Elsewhere | Sender))
}

/// Where, between two doors, what is said of the second one begins: at the first end of a sentence
/// or `and`, else at the last comma.
fn border(reading: &Reading<'_>, gap: Range<usize>) -> usize {
    use Class::{And, Finally, Then};
    let first = gap.clone().find(|at| {
        ends_a_sentence(reading, *at) || matches!(reading.class(*at), Some(And | Then | Finally))
    });
    // `building 3, Rose Street, building 5`: what stands between commas is said of the door before.
    let last_comma = || {
        gap.clone()
            .rev()
            .find(|at| reading.lex(*at) == Some(&Lex::Comma))
    };
    first.or_else(last_comma).unwrap_or(gap.start)
}

/// Whether a sentence ends at a place: not at the point of `4. Stock`.
fn ends_a_sentence(reading: &Reading<'_>, at: usize) -> bool {
    // `building 4. Floor 3` has a number behind the word too, so its point ends a sentence.
    let is_ordinal = reading.class(at + 1) == Some(Class::Floor)
        && !is_number(reading, at + 2)
        && at > 0
        && is_number(reading, at - 1);
    reading.is_stop(at) && !is_ordinal
}

fn is_number(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.lex(at), Some(Lex::Number { .. }))
}

/// The mentions of flats and rooms.
pub(crate) fn rooms(mentions: &[Mention]) -> Vec<Mention> {
    mentions
        .iter()
        .filter(|mention| mention.level == Level::Room)
        .cloned()
        .collect()
}

/// A floor or flat as plans name it: `floor3`.
fn level(level: AddressKind, label: &str) -> AddressLevel {
    let word = if level == AddressKind::Floor {
        "floor"
    } else {
        "flat"
    };
    AddressLevel {
        level,
        name: format!("{word}{}", label.to_uppercase()),
    }
}

/// The number of the floor whose word stands at a place: `3rd floor`, `floor 3`, `3. Stock`, `5层`.
/// A building's or a unit's number is no floor's.
fn floor(reading: &Reading<'_>, at: usize, doors: &[Door]) -> Option<String> {
    let Some(Lex::Word(Class::Floor, number_first)) = reading.lex(at) else {
        return None;
    };
    if let Some(before) = number_before(reading, at, 1, doors)
        && (before.is_ordinal || *number_first)
    {
        return Some(before.label.to_owned());
    }
    if let Some(behind) = number(reading, at + 1).filter(|behind| !behind.is_ordinal) {
        return Some(behind.label.to_owned());
    }
    if at == 0 || !is_point(reading, at - 1) {
        return None;
    }
    number_before(reading, at, 2, doors).map(|number| number.label.to_owned())
}

/// The number `distance` lexemes before a place, unless it is of a door.
fn number_before<'a>(
    reading: &'a Reading<'_>,
    at: usize,
    distance: usize,
    doors: &[Door],
) -> Option<Numeric<'a>> {
    let before = at.checked_sub(distance)?;
    let is_of_door = doors
        .iter()
        .any(|door| (door.first..door.last).contains(&before));
    if is_of_door {
        return None;
    }
    number(reading, before)
}

/// A number in an instruction.
struct Numeric<'a> {
    label: &'a str,
    is_ordinal: bool,
}

fn number<'a>(reading: &'a Reading<'_>, at: usize) -> Option<Numeric<'a>> {
    match reading.lex(at)? {
        Lex::Number { label, ordinal } => Some(Numeric {
            label,
            is_ordinal: *ordinal,
        }),
        _ => None,
    }
}

fn is_point(reading: &Reading<'_>, at: usize) -> bool {
    reading.is_stop(at) && reading.begins_with(at, marks::POINT)
}
