//! Which mentions are meant: not those after `not`, those that a correction replaces or that were cancelled, origins and landmarks, floors.

mod corrections;
mod denial;
mod exceptions;

use self::corrections::{correct, correct_numbers};
use self::denial::denial;
use self::exceptions::{all_but, except, except_lists, take_back};
use super::lexicon::Class;
use super::mentions::{Level, Mention, Target};
use super::pairing::{is_of_the_same, owners};
use super::reading::Reading;
use super::words::Lex;

/// Why a mention is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    Denied,
    Elsewhere,
}

/// How many words may stand between a place and the word that says what it is to the robot: `not`, `sender`, `pick up`, `if`.
const REACH: usize = 7;
/// How many words without weight may stand between a place and what says that it is not meant: `was already cancelled`.
const TAIL: usize = 4;

/// The mentions that the robot shall go to.
pub(crate) fn meant(reading: &Reading<'_>, mut mentions: Vec<Mention>) -> Vec<Mention> {
    let mut left_out: Vec<Option<Why>> = mentions.iter().map(|m| denial(reading, m)).collect();
    allow_where_to_begin(reading, &mentions, &mut left_out);
    allow_what_is_put_in_order(reading, &mentions, &mut left_out);
    spread(reading, &mentions, &mut left_out);
    except_lists(reading, &mentions, &mut left_out);
    pass_hints(reading, &mentions, &mut left_out);
    together(reading, &mentions, &mut left_out);
    take_back(reading, &mut mentions, &mut left_out);
    together(reading, &mentions, &mut left_out);
    correct(reading, &mentions, &mut left_out);
    correct_numbers(reading, &mut mentions, &mut left_out);
    take_back(reading, &mut mentions, &mut left_out);
    all_but(reading, &mut mentions, &mut left_out);
    except(reading, &mut mentions, &mut left_out);
    let strong = |i: usize, out: &[Option<Why>]| {
        out[i].is_none() && !mentions[i].weak && mentions[i].level == Level::Building
    };
    return_to_units(reading, &mentions, &mut left_out);
    if !(0..mentions.len()).any(|i| left_out[i].is_none() && mentions[i].level == Level::Building) {
        // `Leave it behind building 3`: the landmark is the place after all.
        left_out.iter_mut().filter(|why| **why == Some(Why::Elsewhere)).for_each(|why| *why = None);
    }
    let any_strong = (0..mentions.len()).any(|i| strong(i, &left_out));
    let kept = mentions.into_iter().zip(left_out);
    kept.filter(|(m, why)| why.is_none() && !(m.weak && any_strong)).map(|(m, _)| m).collect()
}

fn names(mention: &Mention, target: &Target) -> bool {
    mention.targets.iter().any(|other| is_same_target(other, target))
}

fn is_same_target(a: &Target, b: &Target) -> bool {
    match (a, b) {
        (Target::Label { label: a, .. }, Target::Label { label: b, .. }) => a == b,
        (Target::Name(a), Target::Name(b)) => a == b,
        _ => false,
    }
}

/// Words that change nothing of what is denied.
fn is_light(class: Class) -> bool {
    matches!(
        class,
        Class::Article
            | Class::Link
            | Class::Toward
            | Class::TowardOrAfter
            | Class::Verb
            | Class::Filler
            | Class::Also
            | Class::Each
            | Class::All
            | Class::Same
            | Class::Determiner
    )
}

/// The first word with weight from a place on, and how many without stand before it.
fn after(reading: &Reading<'_>, end: usize) -> Option<(Class, usize)> {
    let mut skipped = 0;
    loop {
        let class = reading.class(end + skipped)?;
        // An article begins something else: `building 3 the cancelled parcel`.
        let is_passed = is_light(class) && !matches!(class, Class::Article | Class::Determiner | Class::Link);
        if !is_passed || skipped == TAIL {
            return Some((class, skipped));
        }
        skipped += 1;
    }
}

/// Whether the `before` at a place puts two stops in order the other way round: `Don't go to building 3 before building 4`. One stop is named
/// between the `not` and the `before`, and the other right after it; where the place comes before its word, the `not` follows, before or after the other stop.
pub(crate) fn is_order_after_not(reading: &Reading<'_>, at: usize) -> bool {
    let Some(Lex::Word(Class::Before, postfix)) = reading.lex(at) else { return false };
    let stops = |i: &usize| reading.lex(*i) == Some(&Lex::Stop);
    let is_building = |i: usize| {
        matches!(reading.lex(i), Some(Lex::Name(_) | Lex::Word(Class::Building | Class::WeakBuilding, _)))
    };
    let (mut buildings, mut others) = (0, 0);
    if *postfix {
        for i in (at + 1..reading.lexemes.len()).take_while(|i| !stops(i)) {
            match reading.class(i) {
                Some(Class::Not) => return buildings == 0,
                Some(Class::Dropped) => return buildings == 1,
                _ => buildings += usize::from(is_building(i)),
            }
        }
        return false;
    }
    let goes_on = |i: usize| {
        reading.lex(i).is_some_and(|lex| match lex {
            Lex::Word(class, _) => is_light(*class),
            Lex::Number { .. } | Lex::Name(_) => true,
            _ => false,
        })
    };
    let next = (at + 1..reading.lexemes.len()).find(|i| is_building(*i) || !goes_on(*i));
    let is_before_a_place = next.is_some_and(|i| is_building(i) || is_level(reading, i));
    for i in (0..at).rev().take_while(|i| !stops(i)) {
        match reading.class(i) {
            Some(Class::Not) => return is_before_a_place && buildings == 1 && others == 0,
            Some(Class::And | Class::Then) => others += 1,
            _ => buildings += usize::from(is_building(i)),
        }
    }
    false
}

fn is_level(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Unit | Class::Room))
}

fn allow_what_is_put_in_order(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    let sentences = sentences(reading);
    for at in (0..reading.lexemes.len()).filter(|at| is_order_after_not(reading, *at)) {
        let is_beside = |m: &Mention| sentences.get(m.at.start) == sentences.get(at);
        let split = mentions.partition_point(|m| m.at.end <= at);
        // A building and its unit on each side.
        let before = (split.saturating_sub(2)..split).filter(|i| is_beside(&mentions[*i]));
        let behind = (split..mentions.len().min(split + 2)).filter(|i| is_beside(&mentions[*i]));
        let (before, behind): (Vec<usize>, Vec<usize>) = (before.collect(), behind.collect());
        if !before.is_empty() && !behind.is_empty() {
            before.into_iter().chain(behind).for_each(|i| left_out[i] = None);
        }
    }
}

/// The number of each lexeme's sentence.
fn sentences(reading: &Reading<'_>) -> Vec<usize> {
    let mut sentence = 0;
    let count = |lexeme: &super::words::Lexeme| {
        sentence += usize::from(lexeme.lex == Lex::Stop);
        sentence
    };
    reading.lexemes.iter().map(count).collect()
}

/// `从3号楼2单元开始`: not where it comes from, but where to begin.
fn allow_where_to_begin(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    for i in 0..mentions.len() {
        let mut end = mentions[i].at.end;
        let next = mentions.get(i + 1).filter(|next| next.at.start == end && next.level != mentions[i].level);
        end = next.map_or(end, |next| next.at.end);
        if left_out[i] == Some(Why::Elsewhere) && reading.class(end) == Some(Class::First) {
            left_out[i] = None;
        }
    }
}

/// `unit 2, first door on the left`: an ordinal of another word right behind a unit says how to find it.
fn pass_hints(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    let word = |mention: &Mention| {
        mention.at.clone().find(|at| matches!(reading.class(*at), Some(Class::Unit | Class::Room)))
    };
    let text = |at: Option<usize>| at.and_then(|at| reading.token(at)).map(|token| token.text.as_str());
    for i in 1..mentions.len() {
        let (unit, hint) = (&mentions[i - 1], &mentions[i]);
        let are_units = unit.level != Level::Building && hint.level != Level::Building;
        let is_ordinal =
            reading.is_ordinal(hint.at.start) || reading.ordinal_determiner(hint.at.start).is_some();
        let is_other = text(word(unit)) != text(word(hint)) && !reading.is_ordinal(unit.at.start);
        let mut gap = unit.at.end..hint.at.start;
        let adds = |at: usize| {
            matches!(reading.class(at), Some(Class::And | Class::Also | Class::Then | Class::Toward))
                && reading.token(at).is_none_or(|t| t.text != "、")
        };
        if are_units && is_ordinal && is_other && !gap.any(adds) {
            left_out[i] = Some(Why::Elsewhere);
        }
    }
}

/// `Cancel building 3 unit 1; unit 4 stays`: where a unit is meant its building is, if no other one is.
fn return_to_units(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    let is_building = |i: &usize| mentions[*i].level == Level::Building;
    if (0..mentions.len()).any(|i| is_building(&i) && left_out[i].is_none()) {
        return;
    }
    let owners = owners(reading, mentions);
    let is_meant = |i: &usize| mentions[*i].level == Level::Unit && left_out[*i].is_none();
    let building = (0..mentions.len()).find(is_meant).and_then(|unit| owners[unit]);
    if let Some(building) = building {
        left_out[building] = None;
    }
}

/// `not unit 2 of building 6`: what is tied to a place left out is left out too.
fn spread(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    for i in 1..mentions.len() {
        let gap = mentions[i - 1].at.end..mentions[i].at.start;
        let tie = |at: usize| {
            matches!(reading.class(at), Some(Class::Link | Class::Article))
                || reading.lex(at) == Some(&Lex::Dash)
        };
        let tied = gap.clone().all(tie) && mentions[i].level != mentions[i - 1].level;
        if tied && left_out[i].is_none() {
            left_out[i] = left_out[i - 1];
        }
    }
}

/// `not unit 3, building 5, but …`, `building 5 unit 3 was cancelled`: a building goes with its units, and they with it.
fn together(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    let owners = owners(reading, mentions);
    let is_building = |i: usize| mentions[i].level == Level::Building;
    // `unit 2, not in building 6`: what is denied begins between them.
    let parted = |a: usize, b: usize| {
        let mut gap = mentions[a.min(b)].at.end..mentions[a.max(b)].at.start;
        gap.any(|at| {
            use Class::{Correct, Dropped, Elsewhere, Except, Not, NotBefore};
            matches!(reading.class(at), Some(Not | Except | NotBefore | Dropped | Elsewhere | Correct))
        })
    };
    let has_unit = |b: usize| (0..mentions.len()).any(|i| i != b && owners[i] == Some(b));
    for building in (0..mentions.len()).filter(|i| is_building(*i)) {
        let is_excepted = |i: usize| reading.class(mentions[i].at.end) == Some(Class::ExceptBehind);
        let is_own = |i: &usize| {
            !is_building(*i) && owners[*i] == Some(building) && !parted(*i, building) && !is_excepted(*i)
        };
        let all = (0..mentions.len()).filter(|i| !is_building(*i) && owners[*i] == Some(building)).count();
        let units: Vec<usize> = (0..mentions.len()).filter(is_own).collect();
        let Some(nearest) = units.first() else { continue };
        if left_out[building].is_none() && units.len() == all && units.iter().all(|i| left_out[*i].is_some())
        {
            left_out[building] = left_out[*nearest];
        } else if let Some(why) = left_out[building] {
            // `not unit 1 of building 5 …. Unit 4 of the same building`
            let is_of_the_same =
                |i: &&usize| left_out[**i].is_none() && is_of_the_same(reading, mentions[**i].at.end);
            if units.iter().any(|i| is_of_the_same(&i)) {
                left_out[building] = None;
                continue;
            }
            // `not building 6, unit 2, but building 8`: the unit may belong to a building that is meant, if one has none.
            let is_bare = |b: &usize| is_building(*b) && left_out[*b].is_none() && !has_unit(*b);
            if !(0..mentions.len()).any(|b| is_bare(&b)) {
                units.into_iter().for_each(|i| left_out[i] = left_out[i].or(Some(why)));
            }
        }
    }
}
