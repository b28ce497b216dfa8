//! The paper's *location query* as steps: the lowest level that the map knows is navigated to, the levels below are explored for.

use openbench_core::{Address, AddressLevel, Level, MapPoint, Step, StepMode};
use openbench_osm::hierarchy::all_above;
use openbench_osm::{Location, OsmMap, locate};

/// How to get to a door, and on behind it, given what the map knows. `levels` are those that are said above the building and below the unit. A building that the map lacks, or has several
/// times, must itself be looked for: in its street or quarter, where the map knows that.
///
/// The target of a step is the level's name.
pub fn steps(map: &OsmMap, address: &Address, levels: &[AddressLevel]) -> Vec<Step> {
    let navigate = |target: &String| Step { mode: StepMode::Navigate, target: target.clone() };
    let explore = |target: &String| Step { mode: StepMode::Explore, target: target.clone() };
    let unit = || address.unit.iter();
    let mut steps: Vec<Step> = match locate(map, address) {
        Location::Unit { .. } => unit().map(navigate).collect(),
        Location::Building(_) => {
            std::iter::once(navigate(&address.building)).chain(unit().map(explore)).collect()
        }
        Location::Unknown | Location::Ambiguous(_) => {
            let is_above = levels.iter().any(|level| level.level <= Level::Street);
            let all = if is_above { all_above(map) } else { Vec::new() };
            let is_known = |level: &&AddressLevel| {
                all.iter().any(|above| above.level == **level && above.place(map).is_some())
            };
            let known = levels.iter().rev().find(is_known);
            let inside = std::iter::once(&address.building).filter(|name| !name.is_empty()).chain(unit());
            known.map(|level| navigate(&level.name)).into_iter().chain(inside.map(explore)).collect()
        }
    };
    let below = levels.iter().filter(|level| matches!(level.level, Level::Floor | Level::Flat));
    steps.extend(below.map(|level| explore(&level.name)));
    steps
}

/// Where a delivery leads: the door, else the middle of the building; `None` where the map knows neither, though it may know the street.
pub fn destination(map: &OsmMap, address: &Address) -> Option<MapPoint> {
    match locate(map, address) {
        Location::Unit { entrance, .. } => map.entrances.get(entrance).map(|e| e.position),
        Location::Building(building) => map.buildings.get(building).map(|b| b.polygon.centroid()),
        Location::Unknown | Location::Ambiguous(_) => None,
    }
}
