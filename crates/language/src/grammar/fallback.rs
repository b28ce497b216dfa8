//! Destinations without a word for a level: `take it to 105`, `deliver to Wonder Hall`, `送到12-3`; and parts of the map's names
//! (`to Paldal` for Paldal Hall).

use super::lexicon::Class;
use super::mentions::{Level, Mention, Target};
use super::pairing::Door;
use super::reading::Reading;
use super::text::condensed;
use super::words::Lex;
use crate::gazetteer::Gazetteer;

/// Longest name, in words, that is taken for a destination.
const LONGEST_NAME: usize = 6;
/// Shortest part of a name, in letters, that stands for the name.
const SHORTEST_PART: usize = 4;
/// The same behind `in` or in a list, where anything may stand.
const SHORTEST_INSIDE: usize = 8;

/// Doors after words that say where to.
pub(crate) fn doors(reading: &Reading<'_>) -> Vec<Door> {
    let pairs = pairs(reading);
    // `地址8-3-601`, but `2-3 boxes to 105`
    let begins = |door: &Door| {
        door.first == 0
            || matches!(
                reading.lex(door.first - 1),
                Some(Lex::Comma | Lex::Stop | Lex::Mark | Lex::Word(Class::Filler, _))
            )
    };
    if pairs.len() > 1 || pairs.first().is_some_and(begins) {
        return pairs;
    }
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

/// `4-1, 4-3 and 9-2`: building and unit each.
fn pairs(reading: &Reading<'_>) -> Vec<Door> {
    let is_glued = |at: usize| reading.token(at).is_some_and(|token| token.glued);
    let begins = |at: usize| {
        at == 0
            || !matches!(reading.lex(at - 1), Some(Lex::Unknown | Lex::Dash | Lex::Word(Class::Reference, _)))
    };
    let is_counted =
        |door: &Door| matches!(reading.class(door.last), Some(Class::Item | Class::Measure | Class::Unit));
    let pair = |at: usize| {
        let is_pair = begins(at) && is_glued(at + 1) && is_glued(at + 2);
        is_pair.then(|| numbered(reading, at)).flatten()
    };
    let found = (0..reading.lexemes.len()).filter_map(pair);
    found.filter(|door| door.unit.is_some() && !is_counted(door)).collect()
}

/// Destinations named by a part of a name on the map, beside the mentions that are there already.
pub(crate) fn partial(reading: &Reading<'_>, gazetteer: &Gazetteer, mentions: &[Mention]) -> Vec<Mention> {
    // `Rathaus, Grundschule und …`
    let is_behind_another = |at: usize| {
        matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::And, _)))
            && mentions.iter().any(|m| m.at.end == at)
    };
    let heads = (0..reading.lexemes.len())
        // `送医疗中心`
        .filter(|at| {
            matches!(
                reading.lex(*at),
                Some(
                    Lex::Word(Class::Toward | Class::TowardOrAfter | Class::And | Class::Link, _)
                        | Lex::Word(Class::Verb, true)
                )
            ) || is_behind_another(*at)
        });
    let free = |door: &Door| mentions.iter().all(|m| m.at.end <= door.first || door.last <= m.at.start);
    // `the City Library and the primary school`: of one word alone it may be anything.
    let is_listed = |at: usize, door: &Door| {
        let is_long = reading.words(door.first..door.last).chars().count() >= SHORTEST_INSIDE;
        let is_linked = reading.class(at) == Some(Class::Link);
        !matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::And | Class::Link, _)))
            || is_long && (is_linked || is_behind_another(at))
            || door.last > door.first + 1 && reading.class(at + 1) == Some(Class::Article)
    };
    let found = heads.filter_map(|at| named(reading, at + 1).filter(|door| is_listed(at, door)));
    let found = found.filter(free).filter_map(|door| {
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
    let is_glued = reading.token(last).is_some_and(|token| token.glued);
    if unit.is_some() && reading.lex(last) == Some(&Lex::Dash) && is_glued && label(last + 1).is_some() {
        last += 2;
    }
    // `3/1 – building and unit`
    let is_apart = |at: usize| reading.token(at).is_some_and(|token| !token.glued);
    let ends = reading.lex(last) == Some(&Lex::Dash) && is_apart(last)
        || matches!(reading.lex(last), None | Some(Lex::Stop | Lex::Comma | Lex::Mark | Lex::Word(..)));
    ends.then_some(Door { building: Some(building), unit, is_room: false, first: at, last })
}

/// `to the Wonder Hall`, `to 12 Oak Street`.
fn named(reading: &Reading<'_>, mut at: usize) -> Option<Door> {
    while matches!(reading.class(at), Some(Class::Article | Class::Determiner | Class::All)) {
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
    unknown.then_some(Door {
        building: Some(words),
        unit: None,
        is_room: false,
        first: at,
        last: at + length,
    })
}
