//! Units and flats of a building, by the map's names.

use openbench_core::Address;
use openbench_osm::names::fold_unit;
use openbench_osm::{Location, OsmMap, locate};

use super::building::{building, generic};
use crate::gazetteer::{Gazetteer, label};
use crate::wish::{Named, Wish};

/// The lowest number of a flat, if nothing else tells flats from entrances: 101 is on a floor.
const LEAST_FLAT: usize = 100;

/// A wish for all units of a building as one wish for each unit that the map has. If the map has
/// none, another number than the instruction says, or more than `most`, it is one for the building.
pub(super) fn single(wish: Wish, most: usize, map: &OsmMap, gazetteer: &Gazetteer) -> Vec<Wish> {
    let Some(Named::All { but, count, parity }) = &wish.unit else {
        return vec![wish];
    };
    let name = building(wish.building.clone(), map, gazetteer).name;
    let is_excepted = |unit: &String| {
        but.iter()
            .any(|label| fold_unit(&generic("unit", label)) == fold_unit(unit))
    };
    let all = units_of(&name, map);
    // The map and the instruction differ, so which units are meant is not known.
    let is_other = count.is_some_and(|count| count != all.len());
    let is_of_parity = |unit: &String| parity.is_none_or(|parity| has_parity(unit, parity));
    let units: Vec<String> = all
        .into_iter()
        .filter(|unit| !is_excepted(unit) && is_of_parity(unit))
        .collect();
    if is_other || units.is_empty() || units.len() > most {
        return vec![Wish { unit: None, ..wish }];
    }
    let one = |unit: String| Wish {
        unit: Some(Named::Words(unit)),
        ..wish.clone()
    };
    units.into_iter().map(one).collect()
}

/// Whether the number of a unit has a remainder divided by two.
fn has_parity(unit: &str, parity: usize) -> bool {
    let digits = unit.trim_start_matches(|c: char| !c.is_ascii_digit());
    digits
        .parse::<usize>()
        .is_ok_and(|number| number % 2 == parity)
}

/// The units of a building, each once, in the order of their names.
fn units_of(building: &str, map: &OsmMap) -> Vec<String> {
    let Location::Building(building) = locate(
        map,
        &Address {
            building: building.to_owned(),
            unit: None,
        },
    ) else {
        return Vec::new();
    };
    // Parts of one multipolygon are one building.
    let element = map.buildings[building].element;
    let is_here = |own: usize| map.buildings[own].element == element;
    let here = map
        .entrances
        .iter()
        .filter(|entrance| entrance.building.is_some_and(is_here));
    let mut units: Vec<String> = here
        .filter_map(|entrance| entrance.units.first().cloned())
        .collect();
    // By length first, so that `unit10` comes behind `unit9`.
    units.sort_by_key(|unit| (unit.len(), unit.clone()));
    units.dedup_by_key(|unit| fold_unit(unit));
    units
}

/// Whether a flat is behind an entrance: the map does not know it as a door of its building, and
/// knows other doors, or the number is one that flats have.
pub(super) fn is_behind_a_unit(building: &str, flat: &str, map: &OsmMap) -> bool {
    if matches!(
        locate(map, &Address::new(building, flat)),
        Location::Unit { .. }
    ) {
        return false;
    }
    let number: usize = flat.trim_start_matches("unit").parse().unwrap_or_default();
    number >= LEAST_FLAT || !units_of(building, map).is_empty()
}

/// The map's name of a unit, else `unit<N>`.
pub(super) fn unit_name(unit: &Named, building: &str, map: &OsmMap) -> String {
    let name = match unit {
        Named::Label { label, .. } => generic("unit", label),
        Named::Words(words) => match label(words) {
            // A bare number is written as plans write units; other words may be a name.
            short if !short.is_empty() && short.chars().all(|c| c.is_ascii_digit()) => {
                generic("unit", &short)
            }
            _ => words.clone(),
        },
        Named::Places { .. } | Named::All { .. } => String::new(),
    };
    let address = Address::new(building, name.clone());
    let Location::Unit { entrance, .. } = locate(map, &address) else {
        return name;
    };
    let own = map.entrances[entrance]
        .units
        .iter()
        .find(|own| fold_unit(own) == fold_unit(&name));
    own.cloned().unwrap_or(name)
}
