//! Which unit belongs to which building: the one that fewer and lighter words part it from. Ties go the way of the pair before
//! (`unit 1 building 3 unit 2 building 5`).

use super::lexicon::Class;
use super::mentions::{Level, Mention, Target};
use super::reading::Reading;
use super::words::Lex;
use crate::gazetteer::Gazetteer;

/// A door as the instruction names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Door {
    /// `None`: the instruction names a unit only.
    pub building: Option<Target>,
    pub unit: Option<Target>,
    /// Whether the unit is said as a flat or a room.
    pub is_room: bool,
    /// First and last lexeme.
    pub first: usize,
    pub last: usize,
}

/// A gap that only the lack of anything nearer bridges.
const FAR: i32 = 100;
/// So many words at most part a building from `same unit`.
const SAME_BESIDE: usize = 4;
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
    // `flat 3` alone is a door, but none beside a building that it is not of.
    let has_building = owners.iter().any(Option::is_some);
    let homeless = |i: &usize| {
        let is_door = mentions[*i].level == Level::Unit || mentions[*i].level == Level::Room && !has_building;
        is_door && owners[*i].is_none()
    };
    for unit in (0..mentions.len()).filter(homeless).map(|i| &mentions[i]) {
        let door = |t: &Target| Door {
            building: None,
            unit: Some(t.clone()),
            is_room: unit.level == Level::Room,
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
        is_room: u.is_some_and(|(_, m)| m.level == Level::Room),
        // Of several units behind a building the first one stands with it.
        first: u.map_or(building.at.start, |(_, m)| {
            let is_later = m.at.start > building.at.end
                && units.first().is_some_and(|first| first.at.start < m.at.start);
            if is_later { m.at.start } else { m.at.start.min(building.at.start) }
        }),
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
    shared.extend(said_of_all(reading, mentions, owners, &shared));
    shared.extend(of_the_same_number(reading, mentions, owners));
    shared
}

/// `unit 2 in building 7 and the same unit in building 8`
fn of_the_same_number(
    reading: &Reading<'_>,
    mentions: &[Mention],
    owners: &[Option<usize>],
) -> Vec<(usize, Vec<usize>)> {
    let is_building = |i: &usize| mentions[*i].level == Level::Building;
    let units = |b: usize| -> Vec<usize> {
        (0..mentions.len()).filter(|i| !is_building(i) && owners[*i] == Some(b)).collect()
    };
    let mut shared = Vec::new();
    for at in (0..reading.lexemes.len()).filter(|at| reading.class(*at) == Some(Class::SameUnit)) {
        let distance = |b: &usize| {
            let range = &mentions[*b].at;
            if range.start > at { range.start - at } else { at.saturating_sub(range.end) }
        };
        let bare =
            (0..mentions.len()).filter(|b| is_building(b) && units(*b).is_empty()).min_by_key(distance);
        let Some(bare) = bare.filter(|b| distance(b) <= SAME_BESIDE) else { continue };
        let others = (0..mentions.len()).filter(|b| is_building(b) && !units(*b).is_empty());
        if let Some(other) = others.min_by_key(|b| b.abs_diff(bare)) {
            shared.push((bare, units(other)));
        }
    }
    shared
}

/// `one bag to building 3, one to building 5, always unit 2`
fn said_of_all(
    reading: &Reading<'_>,
    mentions: &[Mention],
    owners: &[Option<usize>],
    shared: &[(usize, Vec<usize>)],
) -> Vec<(usize, Vec<usize>)> {
    let is_building = |i: usize| mentions[i].level == Level::Building;
    let is_bare = |b: usize| {
        !shared.iter().any(|(other, _)| *other == b)
            && !(0..mentions.len()).any(|i| i != b && owners[i] == Some(b))
    };
    let is_said_of_all = |unit: &usize| {
        let before = (0..mentions[*unit].at.start).rev();
        let mut before =
            before.skip_while(|at| matches!(reading.class(*at), Some(Class::Link | Class::Article)));
        !is_building(*unit) && before.next().is_some_and(|at| reading.class(at) == Some(Class::Shared))
    };
    let Some(unit) = (0..mentions.len()).find(is_said_of_all) else { return Vec::new() };
    (0..unit).filter(|b| is_building(*b) && is_bare(*b)).map(|b| (b, vec![unit])).collect()
}

/// For each mention the building that it belongs to; buildings own themselves.
pub(crate) fn owners(reading: &Reading<'_>, mentions: &[Mention]) -> Vec<Option<usize>> {
    if let Some(owners) = by_turns(reading, mentions) {
        return owners;
    }
    let gaps: Vec<i32> = mentions.windows(2).map(|pair| gap(reading, &pair[0], &pair[1])).collect();
    let is_building = |i: &usize| mentions[*i].level == Level::Building;
    let mut building_first = true;
    let mut buildings = (0..mentions.len()).filter(is_building);
    let only = buildings.next().filter(|_| buildings.next().is_none());
    let mut owners = Vec::new();
    for i in 0..mentions.len() {
        if is_building(&i) {
            owners.push(Some(i));
            continue;
        }
        // Where the number stands before its word a unit comes behind its building.
        let is_number_first = mentions[i]
            .at
            .clone()
            .any(|at| matches!(reading.lex(at), Some(Lex::Word(Class::Unit | Class::Room, true))));
        let before =
            (0..i).rev().find(is_building).map(|b| (b, gaps[b..i].iter().copied().max().unwrap_or(0)));
        let after = (i + 1..mentions.len())
            .find(is_building)
            .map(|b| (b, gaps[i..b].iter().copied().max().unwrap_or(0)))
            .filter(|(_, gap)| *gap < FAR)
            .filter(|_| !(is_number_first && before.is_some_and(|(_, gap)| gap < FAR)));
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
            // `To unit 2. The building is number 3.`
            (None, None) => {
                owners.push(only);
                continue;
            }
        };
        building_first = owner < i;
        owners.push(Some(owner));
    }
    owners
}

/// `Building 3 gets a box at unit 1, building 5 one at unit 2`: where buildings and units come by turns, each building has the unit beside it.
fn by_turns(reading: &Reading<'_>, mentions: &[Mention]) -> Option<Vec<Option<usize>>> {
    let is_building = |i: usize| mentions[i].level == Level::Building;
    let count = mentions.len();
    let alternate = (1..count).all(|i| is_building(i) != is_building(i - 1));
    if count < 4 || !count.is_multiple_of(2) || !alternate {
        return None;
    }
    let building_first = is_building(0);
    // `building 3, unit 2 of building 5, …`
    let is_tied = |i: usize| {
        let mut gap = mentions[i].at.end..mentions[i + 1].at.start;
        gap.clone().any(|at| reading.class(at) == Some(Class::Link))
            && gap.all(|at| matches!(reading.class(at), Some(Class::Link | Class::Article)))
    };
    if (1..count - 1).step_by(2).any(is_tied) {
        return None;
    }
    Some((0..count).map(|i| Some(if building_first { i & !1 } else { i | 1 })).collect())
}

/// How far apart two mentions are that follow each other.
fn gap(reading: &Reading<'_>, a: &Mention, b: &Mention) -> i32 {
    let weight = |at: usize| match reading.lex(at) {
        Some(
            Lex::Stop
            | Lex::Word(Class::Then | Class::Finally | Class::Before | Class::After | Class::Wait, _),
        ) => FAR,
        Some(Lex::Dash | Lex::Word(Class::Link | Class::Article | Class::Sign | Class::First, _)) => 0,
        Some(
            Lex::Mark
            | Lex::Word(Class::Filler | Class::Also | Class::Each | Class::Same | Class::Respectively, _),
        ) => 1,
        Some(Lex::Comma) => 2,
        Some(Lex::Word(
            Class::And | Class::Toward | Class::TowardOrAfter | Class::Determiner | Class::Range | Class::All,
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
        let number = number_after(reading, unit.at.end, gazetteer)
            .or_else(|| number_before(reading, unit.at.start, gazetteer));
        if let Some(building) = number {
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
pub(crate) fn is_of_the_same(reading: &Reading<'_>, mut at: usize) -> bool {
    while matches!(reading.class(at), Some(Class::Link | Class::Article)) {
        at += 1;
    }
    reading.class(at) == Some(Class::Same)
}

/// `unit 2 of 105`, `unit 2, 105.`, where the map has a building 105.
fn number_after(reading: &Reading<'_>, unit: usize, gazetteer: &Gazetteer) -> Option<Mention> {
    // `unit 2, 3 boxes`
    let ends = matches!(reading.lex(unit + 2), None | Some(Lex::Stop | Lex::Mark));
    let belongs = match reading.lex(unit) {
        Some(Lex::Comma) => ends,
        _ => reading.class(unit) == Some(Class::Link),
    };
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(unit + 1).filter(|_| belongs) else {
        return None;
    };
    numbered_building(label, unit + 1, gazetteer)
}

/// `one for building 2, unit 3; another for 6, unit 1`, where the map has a building 6.
fn number_before(reading: &Reading<'_>, unit: usize, gazetteer: &Gazetteer) -> Option<Mention> {
    // `el 9 (entrada 1)`
    let is_between = |at: usize| matches!(reading.lex(at), Some(Lex::Comma | Lex::Mark));
    // `building 3 unit 1 then 4 unit 2`
    let gap = 1 + usize::from(unit > 0 && is_between(unit - 1));
    let at = unit.checked_sub(gap)?;
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(at) else { return None };
    let is_destination = at.checked_sub(1).is_some_and(|at| {
        use Class::{After, And, Article, Before, Then, Toward, TowardOrAfter};
        matches!(reading.class(at), Some(Toward | TowardOrAfter | Article | And | Then | Before | After))
    });
    if is_destination { numbered_building(label, at, gazetteer) } else { None }
}

/// A number that is a building of the map.
fn numbered_building(label: &str, at: usize, gazetteer: &Gazetteer) -> Option<Mention> {
    let target = Target::Label { label: label.to_owned(), said: label.to_owned() };
    let known = !gazetteer.labelled(label).is_empty();
    known.then(|| Mention { level: Level::Building, targets: vec![target], at: at..at + 1, weak: false })
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
    let unit = at;
    while matches!(reading.lex(at), Some(Lex::Comma | Lex::Word(Class::Link | Class::Article, _))) {
        at += 1;
    }
    let length = (at..reading.lexemes.len()).take_while(|i| is_name(reading, *i)).count();
    let unknown = (at..at + length).any(|i| reading.lex(i) == Some(&Lex::Unknown));
    // `unit 2, Wonder Hall.`, but `Einheit 2, Brot für Einheit 4`
    let is_behind_comma = (unit..at).any(|i| reading.lex(i) == Some(&Lex::Comma));
    let ends = matches!(
        reading.lex(at + length),
        None | Some(Lex::Stop | Lex::Comma | Lex::Dash | Lex::Word(Class::And, _))
    );
    (unknown && (ends || !is_behind_comma)).then_some(at..at + length)
}

fn name_before(reading: &Reading<'_>, unit: usize) -> Option<std::ops::Range<usize>> {
    let mut end = unit;
    // `Wonder Hall, unit 2`, but `den Schlüssel bei Einheit 2`
    while end > 0 && matches!(reading.lex(end - 1), Some(Lex::Comma | Lex::Word(Class::Article, _))) {
        end -= 1;
    }
    let length = (0..end).rev().take_while(|i| is_name(reading, *i)).count();
    let unknown = (end - length..end).any(|i| reading.lex(i) == Some(&Lex::Unknown));
    let is_person = (end - length).checked_sub(1).is_some_and(|i| reading.class(i) == Some(Class::Title));
    (unknown && !is_person).then_some(end - length..end)
}
