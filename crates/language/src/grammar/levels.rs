//! What is said of an address above the building and below the unit: the words around each door, among which its street or quarter may be found, floors, and flats behind a unit.

use std::ops::Range;

use openbench_core::{AddressLevel, Level as AddressKind};

use super::lexicon::Class;
use super::mentions::{Level, Mention, Reading, Target};
use super::pairing::Door;
use super::text::condensed;
use super::words::Lex;

/// What is said besides building and unit of a door.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Beside {
    /// The letters of the words between the doors before and after it.
    pub around: String,
    /// Floor and flat.
    pub below: Vec<AddressLevel>,
}

/// What is said besides each door; `rooms` are the mentions of flats and rooms in the instruction.
pub(crate) fn beside(reading: &Reading<'_>, doors: &[Door], rooms: &[Mention]) -> Vec<Beside> {
    let of = |door: &Door| {
        let before = doors.iter().map(|other| other.last).filter(|last| *last <= door.first).max();
        let after = doors.iter().map(|other| other.first).filter(|first| *first >= door.last).min();
        let from = before.map_or(0, |last| border(reading, last..door.first));
        let to = after.map_or(reading.lexemes.len(), |first| border(reading, door.last..first));
        // What is below a door is said in its own sentence.
        let begin = (from..door.first).rev().find(|at| ends(reading, *at)).unwrap_or(from);
        let end = (door.last..to).find(|at| ends(reading, *at)).unwrap_or(to);
        let floor = (begin..end).find_map(|at| floor(reading, at)).map(|n| named(AddressKind::Floor, &n));
        let is_unit = |room: &Mention| door.unit.as_ref() == room.targets.first();
        let flat = rooms.iter().find(|room| room.at.start >= begin && room.at.end <= end && !is_unit(room));
        let flat = flat.and_then(|room| match &room.targets[..] {
            [Target::Label { label, .. }] => Some(named(AddressKind::Flat, label)),
            _ => None,
        });
        let around = condensed(reading.words(from..to));
        Beside { around, below: floor.into_iter().chain(flat).collect() }
    };
    doors.iter().map(of).collect()
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

/// The number of the floor whose word stands at a place: `3rd floor`, `floor 3`, `3. Stock`, `5层`.
fn floor(reading: &Reading<'_>, at: usize) -> Option<String> {
    let Some(Lex::Word(Class::Floor, number_first)) = reading.lex(at) else { return None };
    let number = |at: usize| match reading.lex(at)? {
        Lex::Number { label, ordinal } => Some((label.clone(), *ordinal)),
        _ => None,
    };
    let behind = number(at + 1).filter(|(_, ordinal)| !ordinal).map(|(label, _)| label);
    // `3. Stock` has a mark between.
    let skipped = usize::from(at > 0 && matches!(reading.lex(at - 1), Some(Lex::Stop | Lex::Mark)));
    let before = at.checked_sub(1 + skipped).and_then(number);
    let before =
        before.filter(|(_, ordinal)| *ordinal || *number_first || skipped == 1).map(|(label, _)| label);
    before.or(behind)
}
