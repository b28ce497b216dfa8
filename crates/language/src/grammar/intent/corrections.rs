//! Places and numbers that replace those named before: `no wait`, `I mean`, `instead`.

use std::ops::Range;

use super::super::lexicon::Class;
use super::super::mentions::{Level, Mention, Target};
use super::super::pairing::owners;
use super::super::reading::Reading;
use super::super::text::Kind;
use super::super::words::Lex;
use super::{REACH, Why, is_light, names};

/// How many words may stand between a correction and the place in one sentence: `no, wait, that was the old address, now …`.
const FAR_REACH: usize = 14;

/// After `no wait` and the like each level named replaces the last one of its level.
pub(super) fn correct(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    let owners = owners(reading, mentions);
    for next in (0..reading.lexemes.len()).filter_map(|at| corrected(reading, mentions, at)) {
        let named_before = (0..next).rev().find(|old| {
            left_out[*old].is_none()
                && mentions[*old].level == Level::Building
                && are_same(mentions, *old, next)
        });
        let mut replaced = Vec::new();
        for i in next..mentions.len() {
            if i > next
                && (mentions[i - 1].at.end..mentions[i].at.start).any(|at| ends_a_correction(reading, at))
            {
                break;
            }
            let level = mentions[i].level;
            // `building 5 unit 1 and building 6 unit 1, sorry, building 5 unit 2`
            let is_replaced = |old: &usize| {
                let is_there = named_before.is_none_or(|building| owners[*old] == Some(building));
                left_out[*old].is_none() && mentions[*old].level == level && is_there
            };
            let is_kept = |old: &usize| {
                (level == Level::Building || named_before.is_some()) && are_same(mentions, *old, i)
            };
            let old = (0..next).rev().find(is_replaced).filter(|old| !is_kept(old));
            if let Some(old) = old.filter(|_| left_out[i].is_none() && !replaced.contains(&level)) {
                left_out[old] = Some(Why::Denied);
                replaced.push(level);
            }
        }
    }
}

/// The first mention of those that the word at a place says are meant after all.
fn corrected(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> Option<usize> {
    // `3号棟へ、じゃなくて4号棟へ`: what denies the place before takes it back where it begins a clause.
    let begins = at > 0
        && matches!(reading.lex(at - 1), Some(Lex::Comma | Lex::Dash | Lex::Mark | Lex::Word(Class::And, _)));
    let corrects = match reading.class(at)? {
        Class::Correct | Class::Instead => true,
        Class::NotBefore => begins,
        _ => false,
    };
    if !corrects {
        return None;
    }
    let is_instead = reading.class(at) == Some(Class::Instead);
    let next = mentions.iter().position(|m| m.at.start > at).filter(|next| {
        let from = mentions[*next].at.start;
        let is_parted = (at..from).any(|at| reading.lex(at) == Some(&Lex::Stop));
        // `Sorry. Building 8`, but not `sorry to be late. Building 8`
        let begins = (at + 1..from).take_while(|at| reading.lex(*at) != Some(&Lex::Stop)).all(|at| {
            matches!(
                reading.lex(at),
                Some(Lex::Comma | Lex::Mark | Lex::Dash | Lex::Word(Class::Correct | Class::Filler, _))
            )
        });
        let is_near = from - at <= REACH && (begins || !is_parted)
            || !is_instead && !is_parted && from - at <= FAR_REACH;
        // Of its building and unit the last.
        let is_same_place =
            |i: &usize| mentions.get(*i).is_some_and(|m| m.at.start == mentions[*next].at.end);
        let last = Some(next + 1).filter(is_same_place).unwrap_or(*next);
        is_near && !comes_on_top(reading, at + 1..from, mentions[last].at.end)
    });
    if next.is_some() || !is_instead {
        return next;
    }
    // `but go to unit 2 of building 8 instead`
    let last = mentions.iter().rposition(|mention| mention.at.end <= at)?;
    let is_parted =
        (mentions[last].at.end..at).any(|at| matches!(reading.lex(at), Some(Lex::Stop | Lex::Comma)));
    let building = owners(reading, mentions)[last];
    (!is_parted).then(|| building.map_or(last, |building| building.min(last)))
}

/// `building 3, sorry for the noise, and building 4`, `実は4号棟も`: whether a place comes on top of those before it.
fn comes_on_top(reading: &Reading<'_>, mut gap: Range<usize>, end: usize) -> bool {
    let adds =
        |at: usize| matches!(reading.class(at), Some(Class::And | Class::Also)) && !is_comma(reading, at);
    gap.any(adds) || reading.class(end) == Some(Class::Also)
}

/// `、` is a comma and an `and`.
fn is_comma(reading: &Reading<'_>, at: usize) -> bool {
    reading.token(at).is_some_and(|token| token.kind == Kind::Mark || token.text == "、")
}

fn ends_a_correction(reading: &Reading<'_>, at: usize) -> bool {
    matches!(
        reading.lex(at),
        Some(Lex::Stop | Lex::Word(Class::Then | Class::Finally | Class::And | Class::Correct, _))
    )
}

fn are_same(mentions: &[Mention], a: usize, b: usize) -> bool {
    mentions[a].level == mentions[b].level
        && mentions[b].targets.iter().all(|target| names(&mentions[a], target))
}

/// `building 6 unit 1, sorry, 2`, `2番じゃなくて4番`: a number alone replaces the last one, or that of the level that is named with it.
pub(super) fn correct_numbers(
    reading: &Reading<'_>,
    mentions: &mut Vec<Mention>,
    left_out: &mut Vec<Option<Why>>,
) {
    for at in 0..reading.lexemes.len() {
        let Some(number) = corrected_number(reading, mentions, at) else { continue };
        let Some(Lex::Number { label, .. }) = reading.lex(number) else { continue };
        let before = || (0..mentions.len()).rev().filter(|i| mentions[*i].at.end <= at);
        // `not to building 3 but to 4`
        let denied = || before().next().filter(|i| left_out[*i] == Some(Why::Denied));
        let last = before().find(|i| left_out[*i].is_none()).or_else(denied);
        let Some(mut old) = last else { continue };
        // `al 8, misma unidad`
        let is_of_building = matches!(reading.class(number + 2), Some(Class::Same | Class::SameUnit));
        // `la unidad no es la 4, sino la 2`
        let said = (mentions[old].at.end..number).rev().find_map(|at| match reading.class(at)? {
            Class::Building => Some(Level::Building),
            Class::Unit | Class::Room => Some(Level::Unit),
            _ => None,
        });
        let target = Target::Label { label: label.clone(), said: label.clone() };
        if said == Some(Level::Building) || is_of_building {
            let is_building = |i: &usize| mentions[*i].level == Level::Building && left_out[*i].is_none();
            old = (0..=old).rev().find(is_building).unwrap_or(old);
        } else if said == Some(Level::Unit) && mentions[old].level == Level::Building {
            let place = mentions.partition_point(|mention| mention.at.start < number);
            let unit =
                Mention { level: Level::Unit, targets: vec![target], at: number..number + 1, weak: false };
            mentions.insert(place, unit);
            left_out.insert(place, None);
            continue;
        }
        if mentions[old].targets.len() == 1 {
            mentions[old].targets = vec![target];
            left_out[old] = None;
        }
    }
}

/// Where the number stands that a word at a place puts for another.
fn corrected_number(reading: &Reading<'_>, mentions: &[Mention], at: usize) -> Option<usize> {
    let is_number = |at: usize| matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }));
    let corrects = match reading.class(at)? {
        Class::Correct | Class::Instead => true,
        // `2番じゃなくて4番`
        Class::NotBefore => {
            let sign = usize::from(at > 0 && reading.class(at - 1) == Some(Class::Sign));
            at > sign && is_number(at - sign - 1)
        }
        _ => false,
    };
    let is_passed = |at: &usize| {
        // `las unidades, o sea, las cuatro`: so many, not the one of that number.
        let is_of_many =
            reading.token(*at).is_some_and(|token| matches!(token.text.as_str(), "los" | "las" | "les"));
        let is_word = |class: Class| {
            use Class::{Building, Correct, Room, Toward, TowardOrAfter, Unit};
            is_light(class) || matches!(class, Building | Correct | Room | Toward | TowardOrAfter | Unit)
        };
        !is_of_many
            && (matches!(reading.lex(*at), Some(Lex::Comma | Lex::Mark))
                || reading.class(*at).is_some_and(is_word))
    };
    let number = at + 1 + (at + 1..reading.lexemes.len()).take_while(is_passed).count();
    let ends = matches!(
        reading.lex(number + 1),
        None | Some(Lex::Stop | Lex::Comma | Lex::Word(Class::Filler | Class::Sign, _))
    );
    let is_not = reading.class(at) == Some(Class::NotBefore);
    let is_level = |at: usize| {
        let class = reading.class(at);
        matches!(
            class,
            Some(
                Class::Building
                    | Class::WeakBuilding
                    | Class::Unit
                    | Class::Room
                    | Class::Item
                    | Class::Measure
            )
        )
    };
    let ends = ends || is_not && !is_level(number + 1);
    let is_free = mentions.iter().all(|mention| {
        // `no, 8, building 8`
        let is_next = (number + 1..number + 3).contains(&mention.at.start);
        !mention.at.contains(&number) && !is_next
    });
    (corrects && ends && is_free && is_number(number)).then_some(number)
}
