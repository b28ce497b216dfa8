//! Destinations without a word for a level: `take it to 105`, `deliver to Wonder Hall`, `送到12-3`; and parts of the map's names
//! (`to Paldal` for Paldal Hall).

use super::lexicon::Class;
use super::mentions::{Level, Mention, Reading, Target};
use super::pairing::Door;
use super::text::condensed;
use super::words::Lex;
use crate::gazetteer::Gazetteer;

/// Longest name, in words, that is taken for a destination.
const LONGEST_NAME: usize = 6;
/// Shortest part of a name, in letters, that stands for the name.
const SHORTEST_PART: usize = 4;

/// Doors after words that say where to.
pub(crate) fn doors(reading: &Reading<'_>) -> Vec<Door> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < reading.lexemes.len() {
        let heads = matches!(reading.class(at), Some(Class::Toward | Class::TowardOrAfter | Class::Link));
        let door = heads.then(|| numbered(reading, at + 1).or_else(|| named(reading, at + 1))).flatten();
        at = door.as_ref().map_or(at + 1, |d| d.last.max(at + 1));
        found.extend(door);
    }
    found
}

/// Destinations named by a part of a name on the map, beside the mentions that are there already.
pub(crate) fn partial(reading: &Reading<'_>, gazetteer: &Gazetteer, mentions: &[Mention]) -> Vec<Mention> {
    let heads = (0..reading.lexemes.len())
        .filter(|at| matches!(reading.class(*at), Some(Class::Toward | Class::TowardOrAfter)));
    let free = |door: &Door| mentions.iter().all(|m| m.at.end <= door.first || door.last <= m.at.start);
    let found = heads.filter_map(|at| named(reading, at + 1)).filter(free).filter_map(|door| {
        let Some(Target::Words(words)) = door.building else { return None };
        let parts: Vec<String> = words.split_whitespace().map(condensed).collect();
        let long = parts.iter().any(|part| part.chars().count() >= SHORTEST_PART);
        let known = long && !gazetteer.containing(&parts).is_empty();
        let at = door.first..door.last;
        known.then(|| Mention {
            level: Level::Building,
            targets: vec![Target::Words(words)],
            at,
            weak: false,
        })
    });
    found.collect()
}

/// `to 105`, `to 12-3`.
fn numbered(reading: &Reading<'_>, at: usize) -> Option<Door> {
    let label = |at: usize| match reading.lex(at)? {
        Lex::Number { label, ordinal: false } => {
            Some(Target::Label { label: label.clone(), said: label.clone() })
        }
        _ => None,
    };
    let building = label(at)?;
    let unit = (reading.lex(at + 1) == Some(&Lex::Dash)).then(|| label(at + 2)).flatten();
    let mut last = if unit.is_some() { at + 3 } else { at + 1 };
    // `3-1-502`: the room is no part of the address.
    if unit.is_some() && reading.lex(last) == Some(&Lex::Dash) && label(last + 1).is_some() {
        last += 2;
    }
    let ends = matches!(reading.lex(last), None | Some(Lex::Stop | Lex::Comma | Lex::Word(..)));
    ends.then_some(Door { building: Some(building), unit, first: at, last })
}

/// `to the Wonder Hall`, `to 12 Oak Street`.
fn named(reading: &Reading<'_>, mut at: usize) -> Option<Door> {
    while matches!(reading.class(at), Some(Class::Article | Class::Determiner)) {
        at += 1;
    }
    let part = |i: &usize| {
        let noun = matches!(
            reading.lex(*i),
            Some(Lex::Word(Class::Building | Class::Unit | Class::Room | Class::Item, _))
        );
        let inner = *i > at && matches!(reading.lex(*i), Some(Lex::Dash | Lex::Word(Class::Link, _)));
        reading.lex(*i) == Some(&Lex::Unknown) || noun || inner
    };
    let is_numbered = matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }))
        && reading.lex(at + 1) == Some(&Lex::Unknown);
    let number = usize::from(is_numbered);
    let length =
        number + (at + number..reading.lexemes.len()).take_while(part).take(LONGEST_NAME - number).count();
    let unknown = (at..at + length).any(|i| reading.lex(i) == Some(&Lex::Unknown));
    let words = Target::Words(reading.words(at..at + length).to_owned());
    unknown.then_some(Door { building: Some(words), unit: None, first: at, last: at + length })
}
