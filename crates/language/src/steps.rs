//! The paper's *location query* as steps: the lowest level that the map knows is navigated to, the levels below are explored for.

use openbench_core::{Address, MapPoint, Step, StepMode};
use openbench_osm::{Location, OsmMap, locate};

/// How to get to a door, given what the map knows. A building that the map lacks, or has several times, must itself be looked
/// for.
///
/// The target of a step is the unit's or building's name.
pub fn steps(map: &OsmMap, address: &Address) -> Vec<Step> {
    let step = |mode, target: &String| Step { mode, target: target.clone() };
    let explore_unit = || address.unit.iter().map(|unit| step(StepMode::Explore, unit));
    match locate(map, address) {
        Location::Unit { .. } => address.unit.iter().map(|unit| step(StepMode::Navigate, unit)).collect(),
        Location::Building(_) => {
            std::iter::once(step(StepMode::Navigate, &address.building)).chain(explore_unit()).collect()
        }
        Location::Unknown | Location::Ambiguous(_) => {
            std::iter::once(step(StepMode::Explore, &address.building)).chain(explore_unit()).collect()
        }
    }
}

/// Where the first step leads: the door, else the middle of the building; `None` where the map knows neither.
pub fn destination(map: &OsmMap, address: &Address) -> Option<MapPoint> {
    match locate(map, address) {
        Location::Unit { entrance, .. } => map.entrances.get(entrance).map(|e| e.position),
        Location::Building(building) => map.buildings.get(building).map(|b| b.polygon.centroid()),
        Location::Unknown | Location::Ambiguous(_) => None,
    }
}
