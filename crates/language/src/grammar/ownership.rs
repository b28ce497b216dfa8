//! Which unit belongs to which building: the one that fewer and lighter words part it from. Ties go
//! the way of the pair before (`unit 1 building 3 unit 2 building 5`).

use super::mentions::mention::Mention;
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// A gap that only the lack of anything nearer bridges.
const FAR: i32 = 100;

/// For each mention the building that it belongs to; buildings own themselves.
pub(crate) fn owners(reading: &Reading<'_>, mentions: &[Mention]) -> Vec<Option<usize>> {
    by_turns(reading, mentions).unwrap_or_else(|| nearest(reading, mentions))
}

/// `Building 3 gets a box at unit 1, building 5 one at unit 2`: where buildings and units come by
/// turns, each building has the unit beside it.
fn by_turns(reading: &Reading<'_>, mentions: &[Mention]) -> Option<Vec<Option<usize>>> {
    let count = mentions.len();
    let alternate = (1..count).all(|i| mentions[i].is_building() != mentions[i - 1].is_building());
    // Two mentions are one pair anyway, and an odd number leaves one without a partner.
    if count < 4 || !count.is_multiple_of(2) || !alternate {
        return None;
    }
    // `building 3, unit 2 of building 5, …`
    let are_tied = (1..count - 1)
        .step_by(2)
        .any(|i| is_linked(reading, &mentions[i], &mentions[i + 1]));
    if are_tied {
        return None;
    }
    let building_first = mentions[0].is_building();
    let owners = (0..count).map(|i| Some(building_of_pair(i, building_first)));
    Some(owners.collect())
}

/// The building of the pair that a mention is in: the pairs are 0 and 1, 2 and 3, and so on.
fn building_of_pair(mention: usize, building_first: bool) -> usize {
    if building_first {
        // Pairs are 0 and 1, 2 and 3: clearing the lowest bit gives the first of a pair, setting it
        // the second.
        mention & !1
    } else {
        mention | 1
    }
}

/// Whether nothing but `of` and articles stand between two mentions.
fn is_linked(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    let mut gap = a.at.end..b.at.start;
    gap.clone().any(|at| reading.class(at) == Some(Class::Link))
        && gap.all(|at| matches!(reading.class(at), Some(Class::Link | Class::Article)))
}

/// A building before or behind a unit, and the widest gap on the way to it.
#[derive(Clone, Copy)]
struct Neighbour {
    building: usize,
    gap: i32,
}

/// Each unit belongs to the building that the narrowest gap parts it from.
fn nearest(reading: &Reading<'_>, mentions: &[Mention]) -> Vec<Option<usize>> {
    let gaps: Vec<i32> = mentions
        .windows(2)
        // Between neighbours only; a way over several mentions is as wide as its widest gap.
        .map(|pair| gap(reading, &pair[0], &pair[1]))
        .collect();
    // An instruction mostly keeps one order, so ties follow the pair before.
    let mut building_first = true;
    let mut owners = Vec::new();
    for i in 0..mentions.len() {
        if mentions[i].is_building() {
            owners.push(Some(i));
            continue;
        }
        let before = (0..i).rev().find(|b| mentions[*b].is_building());
        let before = before.map(|b| Neighbour {
            building: b,
            gap: widest(&gaps[b..i]),
        });
        let after = (i + 1..mentions.len()).find(|b| mentions[*b].is_building());
        let after = after.map(|b| Neighbour {
            building: b,
            gap: widest(&gaps[i..b]),
        });
        // Where the number stands before its word a unit comes behind its building.
        let has_near_before = before.is_some_and(|before| before.gap < FAR);
        let is_before = is_number_first(reading, &mentions[i]) && has_near_before;
        // A building behind the unit in another sentence is another address; one before it may
        // still be the one that is spoken of.
        let after = after.filter(|after| after.gap < FAR && !is_before);
        let owner = nearer(before, after, building_first).map(|owner| owner.building);
        if let Some(owner) = owner {
            building_first = owner < i;
        }
        // `To unit 2. The building is number 3.`
        owners.push(owner.or_else(|| only_building(mentions)));
    }
    owners
}

/// The widest of some gaps: other units between a unit and its building do not add up.
fn widest(gaps: &[i32]) -> i32 {
    gaps.iter().copied().max().unwrap_or(0)
}

/// The nearer of two neighbours; of two at equal gaps the one before, if `building_first`.
fn nearer(
    before: Option<Neighbour>,
    after: Option<Neighbour>,
    building_first: bool,
) -> Option<Neighbour> {
    match (before, after) {
        (Some(before), Some(after)) => {
            let is_before = before.gap < after.gap || before.gap == after.gap && building_first;
            Some(if is_before { before } else { after })
        }
        (before, after) => before.or(after),
    }
}

/// The only building of all mentions.
fn only_building(mentions: &[Mention]) -> Option<usize> {
    let mut buildings = (0..mentions.len()).filter(|i| mentions[*i].is_building());
    buildings.next().filter(|_| buildings.next().is_none())
}

/// Whether a unit is said in a language that puts the number before the word.
fn is_number_first(reading: &Reading<'_>, unit: &Mention) -> bool {
    unit.at.clone().any(|at| {
        matches!(
            reading.lex(at),
            Some(Lex::Word(Class::Unit | Class::Room, true))
        )
    })
}

/// How far apart two mentions are that follow each other.
pub(crate) fn gap(reading: &Reading<'_>, a: &Mention, b: &Mention) -> i32 {
    let between = a.at.end..b.at.start;
    let sum: i32 = between.clone().map(|at| weight(reading.lex(at))).sum();
    // `of` binds closer than nothing: `building 3 unit 2 of building 5`.
    let is_linked = between
        .clone()
        .any(|at| reading.class(at) == Some(Class::Link));
    sum.min(FAR) - i32::from(is_linked && sum == 0)
}

/// How far a lexeme parts what stands before it from what stands behind it.
///
/// Only the order of sums counts: nothing, then a comma, then `and` or `to`, then unknown words and
/// other classes, then verbs and things, which begin another part of the sentence.
fn weight(lex: Option<&Lex>) -> i32 {
    match lex {
        Some(Lex::Stop) => FAR,
        Some(Lex::Dash) => 0,
        Some(Lex::Mark) => 1,
        Some(Lex::Comma) => 2,
        Some(Lex::Word(class, _)) => weight_of_class(*class),
        _ => 4,
    }
}

fn weight_of_class(class: Class) -> i32 {
    match class {
        Class::Link | Class::Article | Class::Sign | Class::First => 0,
        Class::Filler | Class::Also | Class::Each | Class::Same | Class::Respectively => 1,
        Class::And
        | Class::Toward
        | Class::TowardOrAfter
        | Class::Determiner
        | Class::Range
        | Class::All => 3,
        Class::Verb => 6,
        Class::Item => 8,
        Class::Then | Class::Finally | Class::Before | Class::After | Class::Wait => FAR,
        _ => 4,
    }
}

/// `unit 2 of the same building`: whether the building named before is meant behind a place.
pub(crate) fn is_of_the_same(reading: &Reading<'_>, mut at: usize) -> bool {
    while matches!(reading.class(at), Some(Class::Link | Class::Article)) {
        at += 1;
    }
    reading.class(at) == Some(Class::Same)
}
