//! From the mentions that are meant to doors: buildings and their units.

pub(crate) mod naming;
pub(crate) mod sharing;

use self::naming::{Naming, name_buildings};
use self::sharing::{Pairing, Sharing, shares};
use super::door::Door;
use super::mentions::mention::{Level, Mention, Target};
use super::ownership::owners;
use super::reading::Reading;
use crate::gazetteer::Gazetteer;
use crate::lexicon::class::Class;

/// The doors that the mentions make, in the order of the text.
pub(crate) fn doors(
    namings: &[Naming],
    sharings: &[Sharing],
    reading: &Reading<'_>,
    mut mentions: Vec<Mention>,
    gazetteer: &Gazetteer,
) -> Vec<Door> {
    // Before ownership, so that a building without a word for its level is an owner as well.
    name_buildings(namings, reading, &mut mentions, gazetteer);
    let owners = owners(reading, &mentions);
    let pairing = Pairing {
        reading,
        mentions: &mentions,
        owners: &owners,
    };
    let shares = shares(sharings, &pairing);
    let respectively =
        (0..reading.lexemes.len()).any(|at| reading.class(at) == Some(Class::Respectively));
    let mut doors = Vec::new();
    for (b, building) in mentions.iter().enumerate().filter(|(_, m)| m.is_building()) {
        let share = shares.iter().find(|share| share.building == b);
        let units = match share {
            Some(share) => share.units.iter().map(|unit| &mentions[*unit]).collect(),
            None => own_units(&pairing, b),
        };
        doors.extend(combine(building, &units, respectively));
    }
    doors.extend(doors_without_building(&pairing));
    // Stages behind this one look for what stands between one door and the next.
    doors.sort_by_key(|door| door.first);
    doors
}

/// The units of a building; its rooms if it has none.
fn own_units<'a>(pairing: &Pairing<'a>, building: usize) -> Vec<&'a Mention> {
    let of_level = |level: Level| -> Vec<&'a Mention> {
        let all = pairing.mentions.iter().zip(pairing.owners);
        let own = all.filter(|(m, owner)| m.level == level && **owner == Some(building));
        own.map(|(mention, _)| mention).collect()
    };
    let units = of_level(Level::Unit);
    if units.is_empty() {
        of_level(Level::Room)
    } else {
        units
    }
}

/// Doors of units that belong to no building. `flat 3` alone is a door, but none beside a building
/// that it is not of.
fn doors_without_building(pairing: &Pairing<'_>) -> Vec<Door> {
    let has_building = pairing.owners.iter().any(Option::is_some);
    let mut doors = Vec::new();
    for (unit, owner) in pairing.mentions.iter().zip(pairing.owners) {
        let is_door = unit.level == Level::Unit || unit.level == Level::Room && !has_building;
        if !is_door || owner.is_some() {
            continue;
        }
        doors.extend(unit.targets.iter().map(|target| Door {
            building: None,
            unit: Some(target.clone()),
            is_room: unit.level == Level::Room,
            first: unit.at.start,
            last: unit.at.end,
        }));
    }
    doors
}

/// A unit of a building, and the mention that names it.
#[derive(Clone, Copy)]
struct Unit<'a> {
    target: &'a Target,
    mention: &'a Mention,
}

/// The doors of a building: each of its targets with each unit, or one with one if `respectively`.
fn combine(building: &Mention, units: &[&Mention], respectively: bool) -> Vec<Door> {
    let targets: Vec<Unit<'_>> = units
        .iter()
        .flat_map(|mention| {
            mention
                .targets
                .iter()
                .map(move |target| Unit { target, mention })
        })
        .collect();
    let buildings = building.targets.iter();
    if targets.is_empty() {
        return buildings
            .map(|target| door_without_unit(building, target))
            .collect();
    }
    let door = |target: &Target, unit: Unit<'_>| door(building, target, unit, units);
    // With other numbers `respectively` cannot be one to one, and each building gets all units.
    if respectively && targets.len() == building.targets.len() {
        return buildings
            .zip(targets)
            .map(|(target, unit)| door(target, unit))
            .collect();
    }
    buildings
        .flat_map(|target| targets.iter().map(move |unit| door(target, *unit)))
        .collect()
}

fn door_without_unit(building: &Mention, target: &Target) -> Door {
    Door {
        building: Some(target.clone()),
        unit: None,
        is_room: false,
        first: building.at.start,
        last: building.at.end,
    }
}

/// The door of one unit among all `units` of a building.
fn door(building: &Mention, target: &Target, unit: Unit<'_>, units: &[&Mention]) -> Door {
    let at = &unit.mention.at;
    // Of several units behind a building the first one stands with it.
    let has_earlier = units.first().is_some_and(|first| first.at.start < at.start);
    let is_later = at.start > building.at.end && has_earlier;
    Door {
        building: Some(target.clone()),
        unit: Some(unit.target.clone()),
        is_room: unit.mention.level == Level::Room,
        first: if is_later {
            at.start
        } else {
            at.start.min(building.at.start)
        },
        last: at.end.max(building.at.end),
    }
}
