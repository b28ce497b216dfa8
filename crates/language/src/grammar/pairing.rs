//! Which unit belongs to which building: the one that fewer and lighter words part it from. Ties go the way of the pair before
//! (`unit 1 building 3 unit 2 building 5`).

use super::lexicon::Class;
use super::mentions::{Level, Mention, Reading, Target};
use super::words::Lex;
use crate::gazetteer::Gazetteer;

/// A door as the instruction names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Door {
    /// `None`: the instruction names a unit only.
    pub building: Option<Target>,
    pub unit: Option<Target>,
    /// First and last lexeme.
    pub first: usize,
    pub last: usize,
}

/// A gap that only the lack of anything nearer bridges.
const FAR: i32 = 100;
/// Up to here a building is beside its unit.
const BESIDE: i32 = 3;

/// The doors that the mentions make, in the order of the text.
pub(crate) fn doors(reading: &Reading<'_>, mut mentions: Vec<Mention>, gazetteer: &Gazetteer) -> Vec<Door> {
    name_the_unknown(reading, &mut mentions, gazetteer);
    let owners = owners(reading, &mentions);
    let mut doors = Vec::new();
    let shares = shared_units(reading, &mentions, &owners);
    let respectively = (0..reading.lexemes.len()).any(|at| reading.class(at) == Some(Class::Respectively));
    for (b, building) in mentions.iter().enumerate().filter(|(_, m)| m.level == Level::Building) {
        let owned = |level: Level| -> Vec<&Mention> {
            let all = mentions.iter().zip(&owners);
            all.filter(|(m, owner)| m.level == level && **owner == Some(b)).map(|(m, _)| m).collect()
        };
        let mut units = owned(Level::Unit);
        if units.is_empty() {
            units = owned(Level::Room);
        }
        if let Some(shared) = shares.iter().find(|(bare, _)| *bare == b) {
            units = shared.1.iter().map(|i| &mentions[*i]).collect();
        }
        doors.extend(combine(building, &units, respectively));
    }
    let homeless = |i: &usize| mentions[*i].level != Level::Building && owners[*i].is_none();
    for unit in (0..mentions.len()).filter(homeless).map(|i| &mentions[i]) {
        let door = |t: &Target| Door {
            building: None,
            unit: Some(t.clone()),
            first: unit.at.start,
            last: unit.at.end,
        };
        doors.extend(unit.targets.iter().map(door));
    }
    doors.sort_by_key(|door| door.first);
    doors
}

fn combine(building: &Mention, units: &[&Mention], respectively: bool) -> Vec<Door> {
    let door = |b: &Target, u: Option<(&Target, &Mention)>| Door {
        building: Some(b.clone()),
        unit: u.map(|(target, _)| target.clone()),
        first: u.map_or(building.at.start, |(_, m)| m.at.start.min(building.at.start)),
        last: u.map_or(building.at.end, |(_, m)| m.at.end.max(building.at.end)),
    };
    let targets: Vec<(&Target, &Mention)> =
        units.iter().flat_map(|m| m.targets.iter().map(move |t| (t, *m))).collect();
    if targets.is_empty() {
        return building.targets.iter().map(|b| door(b, None)).collect();
    }
    if respectively && targets.len() == building.targets.len() {
        return building.targets.iter().zip(targets).map(|(b, u)| door(b, Some(u))).collect();
    }
    let pairs = building.targets.iter().flat_map(|b| targets.iter().map(move |u| (b, *u)));
    pairs.map(|(b, u)| door(b, Some(u))).collect()
}

/// `1号楼和12号楼的3单元`, `Haus 1 und Haus 12, jeweils Eingang 3`: buildings without units that share those of the one they are listed with.
fn shared_units(
    reading: &Reading<'_>,
    mentions: &[Mention],
    owners: &[Option<usize>],
) -> Vec<(usize, Vec<usize>)> {
    let is_building = |i: usize| mentions[i].level == Level::Building;
    let units = |b: usize| -> Vec<usize> {
        (0..mentions.len()).filter(|i| !is_building(*i) && owners[*i] == Some(b)).collect()
    };
    let is_list = |at: usize| matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::And, _)));
    let mut shared: Vec<(usize, Vec<usize>)> = Vec::new();
    for b in (1..mentions.len()).rev() {
        let mut gap = mentions[b - 1].at.end..mentions[b].at.start;
        let is_listed = is_building(b) && is_building(b - 1) && !gap.is_empty() && gap.all(is_list);
        if !is_listed || !units(b - 1).is_empty() {
            continue;
        }
        let theirs =
            shared.iter().find(|(other, _)| *other == b).map_or_else(|| units(b), |(_, units)| units.clone());
        let dealt = |unit: usize| {
            let from = mentions[b].at.end.min(mentions[unit].at.start);
            (from..reading.lexemes.len())
                .take_while(|at| *at < mentions[unit].at.end + 2)
                .any(|at| matches!(reading.class(at), Some(Class::Each | Class::Respectively)))
        };
        let number_first = (mentions[b].at.clone()).any(|at| {
            matches!(reading.lex(at), Some(Lex::Word(Class::Building | Class::WeakBuilding, true)))
        });
        let after = theirs.iter().all(|unit| mentions[*unit].at.start >= mentions[b].at.end);
        if !theirs.is_empty() && after && (number_first || dealt(theirs[0])) {
            shared.push((b - 1, theirs));
        }
    }
    shared
}

/// For each mention the building that it belongs to; buildings own themselves.
pub(crate) fn owners(reading: &Reading<'_>, mentions: &[Mention]) -> Vec<Option<usize>> {
    let gaps: Vec<i32> = mentions.windows(2).map(|pair| gap(reading, &pair[0], &pair[1])).collect();
    let is_building = |i: &usize| mentions[*i].level == Level::Building;
    let mut building_first = true;
    let mut owners = Vec::new();
    for i in 0..mentions.len() {
        if is_building(&i) {
            owners.push(Some(i));
            continue;
        }
        let before =
            (0..i).rev().find(is_building).map(|b| (b, gaps[b..i].iter().copied().max().unwrap_or(0)));
        let after = (i + 1..mentions.len())
            .find(is_building)
            .map(|b| (b, gaps[i..b].iter().copied().max().unwrap_or(0)))
            .filter(|(_, gap)| *gap < FAR);
        let owner = match (before, after) {
            (Some(before), Some(after)) if before.1 == after.1 => {
                if building_first {
                    before.0
                } else {
                    after.0
                }
            }
            (Some(before), Some(after)) => {
                if before.1 < after.1 {
                    before.0
                } else {
                    after.0
                }
            }
            (Some((b, _)), None) | (None, Some((b, _))) => b,
            (None, None) => {
                owners.push(None);
                continue;
            }
        };
        building_first = owner < i;
        owners.push(Some(owner));
    }
    owners
}

/// How far apart two mentions are that follow each other.
fn gap(reading: &Reading<'_>, a: &Mention, b: &Mention) -> i32 {
    let weight = |at: usize| match reading.lex(at) {
        Some(
            Lex::Stop
            | Lex::Word(Class::Then | Class::Finally | Class::Before | Class::After | Class::Wait, _),
        ) => FAR,
        Some(Lex::Dash | Lex::Word(Class::Link | Class::Article | Class::Sign | Class::First, _)) => 0,
        Some(Lex::Mark | Lex::Word(Class::Filler | Class::Each | Class::Same | Class::Respectively, _)) => 1,
        Some(Lex::Comma) => 2,
        Some(Lex::Word(
            Class::And | Class::Toward | Class::TowardOrAfter | Class::Determiner | Class::Range,
            _,
        )) => 3,
        Some(Lex::Word(Class::Verb, _)) => 6,
        Some(Lex::Word(Class::Item, _)) => 8,
        _ => 4,
    };
    let sum: i32 = (a.at.end..b.at.start).map(weight).sum();
    let linked = (a.at.end..b.at.start).any(|at| reading.class(at) == Some(Class::Link));
    sum.min(FAR) - i32::from(linked && sum == 0)
}

/// `unit 2 of Wonder Hall`, where the map has no such name: unknown capitalised words beside a unit without a building.
fn name_the_unknown(reading: &Reading<'_>, mentions: &mut Vec<Mention>, gazetteer: &Gazetteer) {
    let mut named = Vec::new();
    for (i, unit) in mentions.iter().enumerate().filter(|(_, m)| m.level != Level::Building) {
        let beside = |j: usize| {
            let (a, b) = if j < i { (&mentions[j], unit) } else { (unit, &mentions[j]) };
            mentions[j].level != Level::Room && gap(reading, a, b) <= BESIDE
        };
        let has_neighbour = (i > 0 && beside(i - 1)) || (i + 1 < mentions.len() && beside(i + 1));
        if has_neighbour || is_of_the_same(reading, unit.at.end) {
            continue;
        }
        if let Some(building) = number_after(reading, unit.at.end, gazetteer) {
            named.push(building);
            continue;
        }
        let after = name_after(reading, unit.at.end);
        if let Some(at) = after.or_else(|| name_before(reading, unit.at.start)) {
            let targets = vec![Target::Words(reading.words(at.clone()).to_owned())];
            named.push(Mention { level: Level::Building, targets, at, weak: false });
        }
    }
    named.dedup_by(|a, b| a.at == b.at);
    mentions.extend(named);
    mentions.sort_by_key(|m| m.at.start);
}

/// `unit 2 of the same building`
fn is_of_the_same(reading: &Reading<'_>, mut at: usize) -> bool {
    while matches!(reading.class(at), Some(Class::Link | Class::Article)) {
        at += 1;
    }
    reading.class(at) == Some(Class::Same)
}

/// `unit 2 of 105`, where the map has a building 105.
fn number_after(reading: &Reading<'_>, unit: usize, gazetteer: &Gazetteer) -> Option<Mention> {
    let linked = reading.class(unit) == Some(Class::Link);
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(unit + 1).filter(|_| linked) else {
        return None;
    };
    let at = unit + 1..unit + 2;
    let target = Target::Label { label: label.clone(), said: label.clone() };
    let known = !gazetteer.labelled(label).is_empty();
    known.then(|| Mention { level: Level::Building, targets: vec![target], at, weak: false })
}

fn is_name(reading: &Reading<'_>, at: usize) -> bool {
    let capital = reading.token(at).is_some_and(|t| t.capital);
    capital
        && matches!(
            reading.lex(at),
            Some(Lex::Unknown | Lex::Word(Class::Building | Class::Unit | Class::Item, _))
        )
}

fn name_after(reading: &Reading<'_>, mut at: usize) -> Option<std::ops::Range<usize>> {
    while matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::Link | Class::Article, _))) {
        at += 1;
    }
    let length = (at..reading.lexemes.len()).take_while(|i| is_name(reading, *i)).count();
    let unknown = (at..at + length).any(|i| reading.lex(i) == Some(&Lex::Unknown));
    unknown.then_some(at..at + length)
}

fn name_before(reading: &Reading<'_>, unit: usize) -> Option<std::ops::Range<usize>> {
    let mut end = unit;
    while end > 0
        && matches!(reading.lex(end - 1), Some(Lex::Comma | Lex::Word(Class::Link | Class::Article, _)))
    {
        end -= 1;
    }
    let length = (0..end).rev().take_while(|i| is_name(reading, *i)).count();
    let unknown = (end - length..end).any(|i| reading.lex(i) == Some(&Lex::Unknown));
    let is_person = (end - length).checked_sub(1).is_some_and(|i| reading.class(i) == Some(Class::Title));
    (unknown && !is_person).then_some(end - length..end)
}
