//! What is taken back of what was named before, and all units of a building but some.

use super::super::lexicon::Class;
use super::super::mentions::{Level, Mention, Target};
use super::super::pairing::owners;
use super::super::reading::Reading;
use super::super::words::Lex;
use super::{REACH, Why, after, is_light, is_same_target, names};

/// `Units 2 and 4 of building 7 …, but unit 4 has just cancelled`: what is denied is taken back where it was named before.
pub(super) fn take_back(reading: &Reading<'_>, mentions: &mut [Mention], left_out: &mut [Option<Why>]) {
    let owners = owners(reading, mentions);
    let is_whole = |i: usize| !(0..mentions.len()).any(|unit| unit != i && owners[unit] == Some(i));
    let mut taken: Vec<(usize, Target)> = Vec::new();
    for denied in (0..mentions.len()).filter(|i| left_out[*i] == Some(Why::Denied)) {
        let is_building = mentions[denied].level == Level::Building;
        if is_building && !is_whole(denied) {
            continue;
        }
        for earlier in (0..denied).filter(|i| left_out[*i].is_none()) {
            let is_same = mentions[earlier].level == mentions[denied].level
                && (is_building || are_of_one_building(mentions, owners[earlier], owners[denied]));
            let targets =
                mentions[denied].targets.iter().filter(|target| is_same && names(&mentions[earlier], target));
            taken.extend(targets.map(|target| (earlier, target.clone())));
        }
    }
    taken.extend(by_number(reading, mentions, left_out));
    for (i, target) in taken {
        if mentions[i].targets.iter().all(|other| is_same_target(other, &target)) {
            left_out[i] = Some(Why::Denied);
        } else {
            mentions[i].targets.retain(|other| !is_same_target(other, &target));
        }
    }
}

/// `Buildings 1, 6 and 11 …. The 6 has cancelled`: places taken back by their numbers alone.
fn by_number(reading: &Reading<'_>, mentions: &[Mention], left_out: &[Option<Why>]) -> Vec<(usize, Target)> {
    let is_free = |at: usize| mentions.iter().all(|mention| !mention.at.contains(&at));
    let is_headed = |at: usize| {
        at > 0 && matches!(reading.class(at - 1), Some(Class::Article | Class::Link | Class::Determiner))
    };
    let mut taken = Vec::new();
    for at in (0..reading.lexemes.len()).filter(|at| is_free(*at) && is_headed(*at)) {
        let Some(Lex::Number { label, ordinal: false }) = reading.lex(at) else { continue };
        // `en el 6 no, que …`
        let is_not = reading.class(at + 1) == Some(Class::Not)
            && matches!(reading.lex(at + 2), None | Some(Lex::Comma | Lex::Stop));
        if !is_not && !matches!(after(reading, at + 1), Some((Class::Dropped, _))) {
            continue;
        }
        let target = Target::Label { label: label.clone(), said: label.clone() };
        let is_named =
            |i: &usize| left_out[*i].is_none() && mentions[*i].at.end <= at && names(&mentions[*i], &target);
        let is_building = |i: &usize| mentions[*i].level == Level::Building;
        let named: Vec<usize> = (0..mentions.len()).filter(is_named).collect();
        let chosen = named.iter().find(|i| is_building(i)).or(named.first());
        taken.extend(chosen.map(|i| (*i, target)));
    }
    taken
}

fn are_of_one_building(mentions: &[Mention], a: Option<usize>, b: Option<usize>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a == b || mentions[b].targets.iter().all(|target| names(&mentions[a], target)),
        _ => a == b,
    }
}

/// `Everyone in building 3 apart from unit 2`: who excepts some of the units means all others.
pub(super) fn all_but(reading: &Reading<'_>, mentions: &mut Vec<Mention>, left_out: &mut Vec<Option<Why>>) {
    let owners = owners(reading, mentions);
    let is_unit_of = |i: usize, b: usize| mentions[i].level != Level::Building && owners[i] == Some(b);
    let is_bare = |b: &usize| {
        mentions[*b].level == Level::Building
            && left_out[*b].is_none()
            && !(0..mentions.len()).any(|i| is_unit_of(i, *b) && left_out[i].is_none())
    };
    let is_excepted = |i: usize| left_out[i].is_some() && is_excepted(reading, &mentions[i]);
    let excepting = |b: &usize| (0..mentions.len()).any(|i| is_unit_of(i, *b) && is_excepted(i));
    let found: Vec<usize> = (0..mentions.len()).filter(|b| is_bare(b) && excepting(b)).collect();
    for building in found.into_iter().rev() {
        let at = mentions[building].at.end..mentions[building].at.end;
        mentions.insert(
            building + 1,
            Mention {
                level: Level::Unit,
                targets: vec![Target::All { but: Vec::new(), count: None, parity: None }],
                at,
                weak: false,
            },
        );
        left_out.insert(building + 1, None);
    }
}

/// `but unit 1 and unit 3`
pub(super) fn except_lists(reading: &Reading<'_>, mentions: &[Mention], left_out: &mut [Option<Why>]) {
    for i in 1..mentions.len() {
        let is_next = left_out[i].is_none() && left_out[i - 1].is_some();
        if is_next
            && is_joined(reading, &mentions[i - 1], &mentions[i])
            && is_excepted(reading, &mentions[i - 1])
        {
            left_out[i] = left_out[i - 1];
        }
    }
}

/// Whether a word for an exception stands before a place, or before one that it is listed with.
fn is_excepted(reading: &Reading<'_>, mention: &Mention) -> bool {
    if reading.class(mention.at.end) == Some(Class::ExceptBehind) {
        return true;
    }
    let mut before = (0..mention.at.start).rev().take(REACH);
    let is_passed = |at: usize| {
        matches!(
            reading.lex(at),
            Some(Lex::Number { .. } | Lex::Word(Class::Unit | Class::Room | Class::And, _))
        ) || reading.class(at).is_some_and(is_light)
    };
    let weighty = before.find(|at| !is_passed(*at));
    weighty.is_some_and(|at| matches!(reading.class(at), Some(Class::Except | Class::Between)))
}

/// `all units of building 3 but unit 2`
pub(super) fn except(reading: &Reading<'_>, mentions: &mut [Mention], left_out: &mut [Option<Why>]) {
    let owners = owners(reading, mentions);
    for all in 0..mentions.len() {
        if left_out[all].is_some() || !matches!(mentions[all].targets[..], [Target::All { .. }]) {
            continue;
        }
        // `units 1 to 3, one for each unit`
        let is_list = |i: usize| {
            left_out[i].is_none()
                && mentions[i].level != Level::Building
                && mentions[i].targets.len() > 1
                && are_of_one_building(mentions, owners[all], owners[i])
        };
        if (0..mentions.len()).any(is_list) {
            left_out[all] = Some(Why::Denied);
            continue;
        }
        let is_of_it = |i: usize| {
            mentions[i].level != Level::Building && are_of_one_building(mentions, owners[all], owners[i])
        };
        for i in (0..mentions.len().saturating_sub(1)).rev() {
            if i != all
                && is_of_it(i)
                && left_out[i].is_none()
                && left_out[i + 1].is_some()
                && is_joined(reading, &mentions[i], &mentions[i + 1])
            {
                left_out[i] = left_out[i + 1];
            }
        }
        let excepted = (0..mentions.len())
            .filter(|i| left_out[*i].is_some() && is_of_it(*i))
            .flat_map(|i| &mentions[i].targets);
        let labels = excepted.filter_map(|target| match target {
            Target::Label { label, .. } => Some(label.clone()),
            _ => None,
        });
        let excepted: Vec<String> = labels.chain(bare_exceptions(reading, mentions[all].at.end)).collect();
        if let [Target::All { but, .. }] = &mut mentions[all].targets[..] {
            *but = excepted;
        }
    }
}

/// `units 2 and 3 have theirs already`: places of one level with `and` between them.
fn is_joined(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    let gap = a.at.end..b.at.start;
    a.level == b.level && !gap.is_empty() && gap.into_iter().all(|at| reading.class(at) == Some(Class::And))
}

/// `all units of building 4 but 3 and 4`: numbers without a word for their level.
fn bare_exceptions(reading: &Reading<'_>, from: usize) -> Vec<String> {
    let end = (from..reading.lexemes.len()).find(|at| reading.lex(*at) == Some(&Lex::Stop));
    let sentence = from..end.unwrap_or(reading.lexemes.len());
    let excepts = |at: &usize| matches!(reading.class(*at), Some(Class::Not | Class::Except));
    let Some(not) = sentence.clone().find(excepts) else {
        return Vec::new();
    };
    let is_listed = |at: &usize| {
        matches!(
            reading.lex(*at),
            Some(
                Lex::Number { ordinal: false, .. }
                    | Lex::Comma
                    | Lex::Word(Class::Article | Class::And | Class::Sign | Class::Toward | Class::Link, _)
            )
        )
    };
    let label = |at: usize| match reading.lex(at) {
        Some(Lex::Number { label, .. }) => Some(label.clone()),
        _ => None,
    };
    (not + 1..sentence.end).take_while(is_listed).filter_map(label).collect()
}
