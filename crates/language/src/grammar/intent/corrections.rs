//! Places and numbers that replace those named before: `no wait`, `I mean`, `instead`.

use std::ops::Range;

use super::selection::{Selection, Why};
use crate::grammar::mentions::mention::{Level, Mention, Target};
use crate::grammar::ownership::owners;
use crate::grammar::reading::Reading;
use crate::grammar::weight::{REACH, is_light};
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::tokens::Kind;

/// The most words between a correction and the place in one sentence: `no, wait, that was the old
/// address, now …`.
const FAR_REACH: usize = 14;

/// Behind `no wait` and the like each level named replaces the last one of its level.
pub(super) fn correct(reading: &Reading<'_>, selection: &mut Selection) {
    // Once, since corrections change what is meant, but not the mentions.
    let owners = owners(reading, &selection.mentions);
    for at in 0..reading.lexemes.len() {
        if let Some(next) = corrected(reading, &selection.mentions, at) {
            replace(reading, selection, &owners, next);
        }
    }
}

/// Leaves out what the mentions from `next` on, up to the end of the correction, replace.
fn replace(
    reading: &Reading<'_>,
    selection: &mut Selection,
    owners: &[Option<usize>],
    next: usize,
) {
    // `building 5 unit 1 and building 6 unit 1, sorry, building 5 unit 2`
    let named_before = (0..next).rev().find(|old| {
        selection.is_meant(*old)
            && selection.is_building(*old)
            && are_same(&selection.mentions, *old, next)
    });
    let mut replaced = Vec::new();
    for i in next..selection.count() {
        if i > next && ends_between(reading, &selection.mentions[i - 1], &selection.mentions[i]) {
            break;
        }
        let level = selection.mentions[i].level;
        // One correction replaces one place of each level.
        if !selection.is_meant(i) || replaced.contains(&level) {
            continue;
        }
        let old = (0..next).rev().find(|old| {
            let is_there = named_before.is_none_or(|building| owners[*old] == Some(building));
            selection.is_meant(*old) && selection.mentions[*old].level == level && is_there
        });
        let Some(old) = old else { continue };
        // What is said again is confirmed. Units with one number may be of several buildings.
        let is_kept = (level == Level::Building || named_before.is_some())
            && are_same(&selection.mentions, old, i);
        if !is_kept {
            selection.left_out[old] = Some(Why::Denied);
            replaced.push(level);
        }
    }
}

/// Whether a correction ends between two mentions.
fn ends_between(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    (a.at.end..b.at.start).any(|at| {
        use Class::{And, Correct, Finally, Then};
        matches!(
            reading.lex(at),
            Some(Lex::Stop | Lex::Word(Then | Finally | And | Correct, _))
        )
    })
}

/// Whether `a` is of the level of `b` and names all that `b` names.
fn are_same(mentions: &[Mention], a: usize, b: usize) -> bool {
    mentions[a].level == mentions[b].level && mentions[a].names_all_of(&mentions[b])
}

/// The first mention of those that the word at a place says are meant after all.
fn corrected(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> Option<usize> {
    let class = reading.class(at)?;
    let corrects = match class {
        Class::Correct | Class::Instead => true,
        Class::NotBefore => begins_a_clause(reading, at),
        _ => false,
    };
    if !corrects {
        return None;
    }
    let is_instead = class == Class::Instead;
    let next = mentions.iter().position(|mention| mention.at.start > at);
    let next = next.filter(|next| is_of_correction(reading, mentions, at, *next, is_instead));
    next.or_else(|| {
        if is_instead {
            replacing_before(reading, mentions, at)
        } else {
            None
        }
    })
}

/// `3号棟へ、じゃなくて4号棟へ`: what denies the place before it takes that back at the beginning of a
/// clause.
fn begins_a_clause(reading: &Reading<'_>, at: usize) -> bool {
    let before = at.checked_sub(1).and_then(|before| reading.lex(before));
    matches!(
        before,
        Some(Lex::Comma | Lex::Dash | Lex::Mark | Lex::Word(Class::And, _))
    )
}

/// Whether the mention `next` is near enough to the correction at a place, and does not come on top
/// of the rest.
fn is_of_correction(
    reading: &Reading<'_>,
    mentions: &[Mention],
    at: usize,
    next: usize,
    is_instead: bool,
) -> bool {
    let from = mentions[next].at.start;
    let distance = from - at;
    let is_parted = (at..from).any(|at| reading.is_stop(at));
    let is_beside = distance <= REACH && (!is_parted || stands_alone(reading, at + 1..from));
    // `instead` may as well stand behind its place, so it does not reach as far forward.
    let is_near = is_beside || !is_instead && !is_parted && distance <= FAR_REACH;
    // Of its building and unit the last.
    let last = mentions
        .get(next + 1)
        .filter(|behind| behind.at.start == mentions[next].at.end)
        .unwrap_or(&mentions[next]);
    is_near && !comes_on_top(reading, at + 1..from, last.at.end)
}

/// `Sorry. Building 8`, but not `sorry to be late. Building 8`: whether the correction's sentence
/// says nothing else.
fn stands_alone(reading: &Reading<'_>, behind: Range<usize>) -> bool {
    use Class::{Correct, Filler};
    behind.take_while(|at| !reading.is_stop(*at)).all(|at| {
        matches!(
            reading.lex(at),
            Some(Lex::Comma | Lex::Mark | Lex::Dash | Lex::Word(Correct | Filler, _))
        )
    })
}

/// `but go to unit 2 of building 8 instead`: the place before the word replaces those before it.
fn replacing_before(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> Option<usize> {
    let last = mentions.iter().rposition(|mention| mention.at.end <= at)?;
    let mut gap = mentions[last].at.end..at;
    if gap.any(|at| matches!(reading.lex(at), Some(Lex::Stop | Lex::Comma))) {
        return None;
    }
    let building = owners(reading, mentions)[last];
    Some(building.map_or(last, |building| building.min(last)))
}

/// `building 3, sorry for the noise, and building 4`, `実は4号棟も`: whether a place comes on top of
/// those before it.
fn comes_on_top(reading: &Reading<'_>, mut gap: Range<usize>, end: usize) -> bool {
    gap.any(|at| is_word_that_adds(reading, at)) || reading.class(end) == Some(Class::Also)
}

/// `and` and `also`, but not `&` or `、`, which also part a correction from its place.
fn is_word_that_adds(reading: &Reading<'_>, at: usize) -> bool {
    let is_mark = reading
        .token(at)
        .is_some_and(|token| token.kind == Kind::Mark);
    matches!(reading.class(at), Some(Class::And | Class::Also)) && !is_mark
}

/// `building 6 unit 1, sorry, 2`, `2番じゃなくて4番`: a number alone replaces the last one, or that of
/// the level that is named with it.
pub(super) fn correct_numbers(reading: &Reading<'_>, selection: &mut Selection) {
    for at in 0..reading.lexemes.len() {
        let Some(number) = corrected_number(reading, &selection.mentions, at) else {
            continue;
        };
        let Some(Lex::Number { label, .. }) = reading.lex(number) else {
            continue;
        };
        if let Some(old) = replaced(selection, at) {
            replace_number(reading, selection, old, number, Target::bare(label));
        }
    }
}

/// The mention that a number behind a correction at a place replaces.
fn replaced(selection: &Selection, at: usize) -> Option<usize> {
    let before: Vec<usize> = (0..selection.count())
        .filter(|i| selection.mentions[*i].at.end <= at)
        .collect();
    let meant = before.iter().rev().find(|i| selection.is_meant(**i));
    // `not to building 3 but to 4`
    let denied = before
        .last()
        .filter(|i| selection.left_out[**i] == Some(Why::Denied));
    meant.or(denied).copied()
}

/// Puts `target`, which stands at `number`, for what `old` names, or for its building, or adds it
/// as a unit of that.
fn replace_number(
    reading: &Reading<'_>,
    selection: &mut Selection,
    mut old: usize,
    number: usize,
    target: Target,
) {
    // `al 8, misma unidad`
    let keeps_unit = matches!(
        reading.class(number + 2),
        Some(Class::Same | Class::SameUnit)
    );
    // `la unidad no es la 4, sino la 2`
    let said = said_level(reading, selection.mentions[old].at.end..number);
    if said == Some(Level::Building) || keeps_unit {
        let building = (0..=old)
            .rev()
            .find(|i| selection.is_building(*i) && selection.is_meant(*i));
        old = building.unwrap_or(old);
    } else if said == Some(Level::Unit) && selection.is_building(old) {
        let place = selection
            .mentions
            .partition_point(|mention| mention.at.start < number);
        selection.insert(place, Mention::one(Level::Unit, target, number..number + 1));
        return;
    }
    // Of a list it is unknown which number the correction replaces.
    if selection.mentions[old].targets.len() == 1 {
        selection.mentions[old].targets = vec![target];
        selection.left_out[old] = None;
    }
}

/// The level whose word comes last in a gap, rooms as units.
fn said_level(reading: &Reading<'_>, gap: Range<usize>) -> Option<Level> {
    gap.rev().find_map(|at| match reading.class(at)? {
        Class::Building => Some(Level::Building),
        Class::Unit | Class::Room => Some(Level::Unit),
        _ => None,
    })
}

/// Where the number stands that a word at a place puts for another.
fn corrected_number(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> Option<usize> {
    let class = reading.class(at)?;
    let corrects = match class {
        Class::Correct | Class::Instead => true,
        Class::NotBefore => is_behind_a_number(reading, at),
        _ => false,
    };
    let passed = (at + 1..reading.lexemes.len())
        .take_while(|at| is_passed(reading, *at))
        .count();
    let number = at + 1 + passed;
    let is_alone =
        ends_behind(reading, number) || class == Class::NotBefore && !is_counted(reading, number);
    let is_found = corrects && reading.is_cardinal(number) && is_alone;
    (is_found && is_free(mentions, number)).then_some(number)
}

/// `2番じゃなくて4番`
fn is_behind_a_number(reading: &Reading<'_>, at: usize) -> bool {
    let sign = usize::from(at > 0 && reading.class(at - 1) == Some(Class::Sign));
    at > sign && reading.is_cardinal(at - sign - 1)
}

/// Whether what stands at a place may stand between a correction and its number.
fn is_passed(reading: &Reading<'_>, at: usize) -> bool {
    // `las unidades, o sea, las cuatro`: so many, not the one of that number.
    if reading.has(at, Feature::PluralArticle) {
        return false;
    }
    match reading.lex(at) {
        Some(Lex::Comma | Lex::Mark) => true,
        Some(Lex::Word(class, _)) => {
            use Class::{Building, Correct, Room, Unit};
            is_light(*class) || matches!(class, Building | Correct | Room | Unit)
        }
        _ => false,
    }
}

/// Whether nothing that it counts follows a number.
fn ends_behind(reading: &Reading<'_>, number: usize) -> bool {
    use Class::{Filler, Sign};
    let lex = reading.lex(number + 1);
    matches!(
        lex,
        None | Some(Lex::Stop | Lex::Comma | Lex::Word(Filler | Sign, _))
    )
}

/// Whether a level, a thing or a measure follows a number.
fn is_counted(reading: &Reading<'_>, number: usize) -> bool {
    use Class::{Building, Item, Measure, Room, Unit, WeakBuilding};
    let class = reading.class(number + 1);
    matches!(
        class,
        Some(Building | WeakBuilding | Unit | Room | Item | Measure)
    )
}

/// Whether a number is of no mention, and none begins right behind it: `no, 8, building 8`.
fn is_free(mentions: &[Mention], number: usize) -> bool {
    mentions.iter().all(|mention| {
        let is_next = (number + 1..number + 3).contains(&mention.at.start);
        !mention.at.contains(&number) && !is_next
    })
}
