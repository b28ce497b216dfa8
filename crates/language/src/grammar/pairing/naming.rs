//! Buildings without a word for their level beside a unit: a number of the map, or a name that the
//! map does not have.

use std::ops::Range;

use crate::gazetteer::Gazetteer;
use crate::grammar::mentions::mention::{Level, Mention, Target};
use crate::grammar::ownership::{gap, is_of_the_same};
use crate::grammar::reading::Reading;
use crate::grammar::rule::{Example, Rule};
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// Up to this gap a building is beside its unit.
const BESIDE: i32 = 3;

/// A rule of [`NAMINGS`]: the building beside a unit, whose lexemes are given.
pub(crate) type Naming = Rule<fn(&Reading<'_>, &Range<usize>, &Gazetteer) -> Option<Mention>>;

/// The building of a unit that has none beside it. The first rule that finds one decides.
pub(crate) const NAMINGS: &[Naming] = &[
    Naming {
        name: "a number of the map behind a unit is its building",
        examples: &[Example("Take it to unit 2 of 5", "building5/unit2")],
        apply: number_behind,
    },
    Naming {
        name: "a number of the map before a unit is its building",
        examples: &[Example(
            "One for building 2, unit 3; another for 6, unit 1",
            "building2/unit3 building6/unit1",
        )],
        apply: number_before,
    },
    Naming {
        name: "unknown capitalized words behind a unit are its building",
        examples: &[Example(
            "The box to unit 2 of Wonder Hall",
            "Wonder Hall/unit2",
        )],
        apply: name_behind,
    },
    Naming {
        name: "unknown capitalized words before a unit are its building",
        examples: &[Example("Wonder Hall, unit 2", "Wonder Hall/unit2")],
        apply: name_before,
    },
];

/// Adds the buildings that the rules find, in the order of the text.
pub(super) fn name_buildings(
    rules: &[Naming],
    reading: &Reading<'_>,
    mentions: &mut Vec<Mention>,
    gazetteer: &Gazetteer,
) {
    let mut named = Vec::new();
    for (i, unit) in mentions
        .iter()
        .enumerate()
        .filter(|(_, m)| !m.is_building())
    {
        if has_neighbour(reading, mentions, i) || is_of_the_same(reading, unit.at.end) {
            continue;
        }
        named.extend(
            rules
                .iter()
                .find_map(|rule| (rule.apply)(reading, &unit.at, gazetteer)),
        );
    }
    // Two units may find the same building between them.
    named.dedup_by(|a, b| a.at == b.at);
    mentions.extend(named);
    // Ownership looks at neighbours in the order of the text.
    mentions.sort_by_key(|mention| mention.at.start);
}

/// Whether a mention, no room, is beside a unit.
fn has_neighbour(reading: &Reading<'_>, mentions: &[Mention], unit: usize) -> bool {
    let is_near = |a: usize, b: usize| gap(reading, &mentions[a], &mentions[b]) <= BESIDE;
    let counts = |i: usize| mentions[i].level != Level::Room;
    let is_behind_one = unit > 0 && counts(unit - 1) && is_near(unit - 1, unit);
    let next = unit + 1;
    is_behind_one || next < mentions.len() && counts(next) && is_near(unit, next)
}

/// `unit 2 of 105`, `unit 2, 105.`
fn number_behind(
    reading: &Reading<'_>,
    unit: &Range<usize>,
    gazetteer: &Gazetteer,
) -> Option<Mention> {
    let end = unit.end;
    // `unit 2, 3 boxes`
    let ends = matches!(reading.lex(end + 2), None | Some(Lex::Stop | Lex::Mark));
    let belongs = match reading.lex(end)? {
        Lex::Comma => ends,
        Lex::Word(class, _) => *class == Class::Link,
        _ => false,
    };
    if belongs {
        numbered_building(reading, end + 1, gazetteer)
    } else {
        None
    }
}

/// `one for building 2, unit 3; another for 6, unit 1`
fn number_before(
    reading: &Reading<'_>,
    unit: &Range<usize>,
    gazetteer: &Gazetteer,
) -> Option<Mention> {
    // `el 9 (entrada 1)`, but `building 3 unit 1 then 4 unit 2`
    let is_apart =
        unit.start > 0 && matches!(reading.lex(unit.start - 1), Some(Lex::Comma | Lex::Mark));
    let at = unit.start.checked_sub(1 + usize::from(is_apart))?;
    let head = at.checked_sub(1).and_then(|head| reading.class(head));
    let is_destination = {
        use Class::{After, And, Article, Before, Then, Toward, TowardOrAfter};
        matches!(
            head,
            Some(Toward | TowardOrAfter | Article | And | Then | Before | After)
        )
    };
    if is_destination {
        numbered_building(reading, at, gazetteer)
    } else {
        None
    }
}

/// The number at a place, if it is a building of the map.
fn numbered_building(reading: &Reading<'_>, at: usize, gazetteer: &Gazetteer) -> Option<Mention> {
    let Some(Lex::Number {
        label,
        ordinal: false,
    }) = reading.lex(at)
    else {
        return None;
    };
    let is_known = !gazetteer.labelled(label).is_empty();
    is_known.then(|| Mention::one(Level::Building, Target::bare(label), at..at + 1))
}

/// `unit 2 of Wonder Hall`
fn name_behind(reading: &Reading<'_>, unit: &Range<usize>, _: &Gazetteer) -> Option<Mention> {
    let mut at = unit.end;
    while matches!(
        reading.lex(at),
        Some(Lex::Comma | Lex::Word(Class::Link | Class::Article, _))
    ) {
        at += 1;
    }
    let length = (at..reading.lexemes.len())
        .take_while(|i| is_name(reading, *i))
        .count();
    let name = at..at + length;
    // `unit 2, Wonder Hall.`, but `Einheit 2, Brot für Einheit 4`
    let has_comma = (unit.end..at).any(|i| reading.lex(i) == Some(&Lex::Comma));
    let ends = matches!(
        reading.lex(name.end),
        None | Some(Lex::Stop | Lex::Comma | Lex::Dash | Lex::Word(Class::And, _))
    );
    let is_building = has_unknown(reading, &name) && (ends || !has_comma);
    is_building.then(|| unknown_building(reading, name))
}

/// `Wonder Hall, unit 2`
fn name_before(reading: &Reading<'_>, unit: &Range<usize>, _: &Gazetteer) -> Option<Mention> {
    let mut end = unit.start;
    // But `den Schlüssel bei Einheit 2`
    while end > 0
        && matches!(
            reading.lex(end - 1),
            Some(Lex::Comma | Lex::Word(Class::Article, _))
        )
    {
        end -= 1;
    }
    let length = (0..end).rev().take_while(|i| is_name(reading, *i)).count();
    let name = end - length..end;
    let before = name
        .start
        .checked_sub(1)
        .and_then(|before| reading.class(before));
    let is_person = before == Some(Class::Title);
    let is_building = has_unknown(reading, &name) && !is_person;
    is_building.then(|| unknown_building(reading, name))
}

/// Whether a word may be of a name: capitalized, and of no class that names cannot have.
fn is_name(reading: &Reading<'_>, at: usize) -> bool {
    use Class::{Building, Item, Unit};
    let lex = reading.lex(at);
    reading.token(at).is_some_and(|token| token.capital)
        && matches!(
            lex,
            Some(Lex::Unknown | Lex::Word(Building | Unit | Item, _))
        )
}

fn has_unknown(reading: &Reading<'_>, name: &Range<usize>) -> bool {
    name.clone()
        .any(|at| reading.lex(at) == Some(&Lex::Unknown))
}

fn unknown_building(reading: &Reading<'_>, name: Range<usize>) -> Mention {
    let words = Target::Words(reading.words(name.clone()).to_owned());
    Mention::one(Level::Building, words, name)
}
