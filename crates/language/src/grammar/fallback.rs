//! Destinations without a word for a level: `take it to 105`, `deliver to Wonder Hall`, `送到12-3`;
//! and parts of the map's names (`to Paldal` for Paldal Hall).

use super::door::Door;
use super::mentions::mention::{Level, Mention, Target};
use super::reading::Reading;
use crate::gazetteer::Gazetteer;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::tokens::condensed;

/// The longest name that is taken for a destination, in words.
const LONGEST_NAME: usize = 6;
/// The shortest part of a name that stands for the name, in letters.
const SHORTEST_PART: usize = 4;
/// The same behind `in` or in a list, where anything may stand.
const SHORTEST_INSIDE: usize = 8;

/// Doors behind words that say where to.
pub(crate) fn doors(reading: &Reading<'_>) -> Vec<Door> {
    let pairs = pairs(reading);
    // Several pairs, or one that begins a clause, are addresses. A single one elsewhere may be an
    // amount.
    if pairs.len() > 1
        || pairs
            .first()
            .is_some_and(|pair| begins_a_clause(reading, pair.first))
    {
        return pairs;
    }
    let mut found = Vec::new();
    let mut at = 0;
    while at < reading.lexemes.len() {
        let door = if is_where_to(reading, at) {
            door_at(reading, at + 1)
        } else {
            None
        };
        // Always forward, so that the loop ends, and behind the door, whose words may hold an `of`.
        at = door.as_ref().map_or(at + 1, |door| door.last.max(at + 1));
        found.extend(door);
    }
    found
}

/// `地址8-3-601`, but `2-3 boxes to 105`
fn begins_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    let before = at.checked_sub(1).map(|before| reading.lex(before));
    before.is_none_or(|lex| {
        matches!(
            lex,
            Some(Lex::Comma | Lex::Stop | Lex::Mark | Lex::Word(Class::Filler, _))
        )
    })
}

fn is_where_to(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.class(at),
        Some(Class::Toward | Class::TowardOrAfter | Class::Link)
    )
}

fn door_at(reading: &Reading<'_>, at: usize) -> Option<Door> {
    numbered(reading, at).or_else(|| named(reading, at))
}

/// `4-1, 4-3 and 9-2`: building and unit each.
fn pairs(reading: &Reading<'_>) -> Vec<Door> {
    (0..reading.lexemes.len())
        .filter_map(|at| pair(reading, at))
        .collect()
}

fn pair(reading: &Reading<'_>, at: usize) -> Option<Door> {
    let before = at.checked_sub(1).and_then(|before| reading.lex(before));
    let is_of_before = matches!(
        before,
        Some(Lex::Unknown | Lex::Dash | Lex::Word(Class::Reference, _))
    );
    if is_of_before || !reading.is_glued(at + 1) || !reading.is_glued(at + 2) {
        return None;
    }
    let door = numbered(reading, at).filter(|door| door.unit.is_some())?;
    let counts = matches!(
        reading.class(door.last),
        Some(Class::Item | Class::Measure | Class::Unit)
    );
    (!counts).then_some(door)
}

/// Adds destinations named by a part of a name on the map, beside the mentions that are there
/// already, in the order of the text.
pub(crate) fn add_partial_names(
    reading: &Reading<'_>,
    gazetteer: &Gazetteer,
    mentions: &mut Vec<Mention>,
) {
    let partial: Vec<Mention> = (0..reading.lexemes.len())
        .filter(|at| is_head(reading, mentions, *at))
        .filter_map(|at| partial_name(reading, gazetteer, mentions, at))
        .collect();
    mentions.extend(partial);
    mentions.sort_by_key(|mention| mention.at.start);
}

/// Whether a destination may stand behind a word.
fn is_head(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> bool {
    match reading.lex(at) {
        Some(Lex::Word(class, number_first)) => {
            use Class::{And, Link, Toward, TowardOrAfter, Verb};
            // `送医疗中心`
            matches!(class, Toward | TowardOrAfter | And | Link) || *class == Verb && *number_first
        }
        _ => is_behind_another(reading, mentions, at),
    }
}

/// `Rathaus, Grundschule und …`: whether a comma or `and` stands right behind a mention.
fn is_behind_another(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> bool {
    matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::And, _)))
        && mentions.iter().any(|mention| mention.at.end == at)
}

/// The destination behind the word at `head`, if its words are a part of a name on the map.
fn partial_name(
    reading: &Reading<'_>,
    gazetteer: &Gazetteer,
    mentions: &[Mention],
    head: usize,
) -> Option<Mention> {
    let door = named(reading, head + 1)?;
    // Words of a mention are understood already.
    let is_free = |mention: &Mention| mention.at.end <= door.first || door.last <= mention.at.start;
    if !is_destination(reading, mentions, head, &door) || !mentions.iter().all(is_free) {
        return None;
    }
    let Some(Target::Words(words)) = door.building else {
        return None;
    };
    let parts: Vec<String> = words.split_whitespace().map(condensed).collect();
    let is_long = parts
        .iter()
        .any(|part| part.chars().count() >= SHORTEST_PART);
    if !is_long || gazetteer.with_parts(&parts).places.is_empty() {
        return None;
    }
    Some(Mention::one(
        Level::Building,
        Target::Words(words),
        door.first..door.last,
    ))
}

/// Whether words behind a head are enough to be a destination. In a list and behind `in` a single
/// word may be anything: `the City Library and the primary school`.
fn is_destination(reading: &Reading<'_>, mentions: &[Mention], head: usize, door: &Door) -> bool {
    let is_listed = matches!(
        reading.lex(head),
        Some(Lex::Comma | Lex::Word(Class::And | Class::Link, _))
    );
    if !is_listed {
        return true;
    }
    let letters = reading.words(door.first..door.last).chars().count();
    let is_inside =
        reading.class(head) == Some(Class::Link) || is_behind_another(reading, mentions, head);
    let has_article = door.last > door.first + 1 && reading.class(head + 1) == Some(Class::Article);
    letters >= SHORTEST_INSIDE && is_inside || has_article
}

/// `to 105`, `to 12-3`.
fn numbered(reading: &Reading<'_>, at: usize) -> Option<Door> {
    let building = cardinal(reading, at)?;
    let is_dash = |at: usize| reading.lex(at) == Some(&Lex::Dash);
    let unit = if is_dash(at + 1) {
        cardinal(reading, at + 2)
    } else {
        None
    };
    let mut last = if unit.is_some() { at + 3 } else { at + 1 };
    // `3-1-502`: the room is no part of the address.
    let has_room = is_dash(last) && reading.is_glued(last) && cardinal(reading, last + 1).is_some();
    if unit.is_some() && has_room {
        last += 2;
    }
    // `3/1 – building and unit`
    let is_apart = reading.token(last).is_some_and(|token| !token.glued);
    let ends = is_dash(last) && is_apart
        || matches!(
            reading.lex(last),
            None | Some(Lex::Stop | Lex::Comma | Lex::Mark | Lex::Word(..))
        );
    ends.then_some(Door {
        building: Some(building),
        unit,
        is_room: false,
        first: at,
        last,
    })
}

/// The number at a place, which counts.
fn cardinal(reading: &Reading<'_>, at: usize) -> Option<Target> {
    match reading.lex(at)? {
        Lex::Number {
            label,
            ordinal: false,
        } => Some(Target::bare(label)),
        _ => None,
    }
}

/// `to the Wonder Hall`, `to 12 Oak Street`.
fn named(reading: &Reading<'_>, mut at: usize) -> Option<Door> {
    while matches!(
        reading.class(at),
        Some(Class::Article | Class::Determiner | Class::All)
    ) {
        at += 1;
    }
    let is_unknown = |at: usize| reading.lex(at) == Some(&Lex::Unknown);
    // A house number before its street.
    let number = usize::from(reading.is_cardinal(at) && is_unknown(at + 1));
    let name = (at + number..reading.lexemes.len()).take(LONGEST_NAME - number);
    let length = number + name.take_while(|i| is_part(reading, *i, at)).count();
    if !(at..at + length).any(is_unknown) {
        return None;
    }
    let words = Target::Words(reading.words(at..at + length).to_owned());
    Some(Door {
        building: Some(words),
        unit: None,
        is_room: false,
        first: at,
        last: at + length,
    })
}

/// Whether what stands at a place may be of a name that begins at `first`.
fn is_part(reading: &Reading<'_>, at: usize, first: usize) -> bool {
    match reading.lex(at) {
        Some(Lex::Unknown) => true,
        Some(Lex::Word(Class::Building | Class::Unit | Class::Room | Class::Item, _)) => true,
        Some(Lex::Dash | Lex::Word(Class::Link, _)) => at > first,
        _ => false,
    }
}
