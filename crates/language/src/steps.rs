//! The paper's *location query* as steps: the lowest level that the map knows is navigated to, the
//! levels below it are explored for.

use openbench_core::{Address, AddressLevel, Level, MapPoint, Step, StepMode};
use openbench_osm::hierarchy::{EnclosingPlace, enclosing_places};
use openbench_osm::{Location, OsmMap, locate};

/// The steps to a door, and on behind it, given what the map knows.
///
/// `levels` are those of the address above the building and below the unit. A building that the map
/// lacks, or has more than once, must itself be explored for: in its street or quarter, if the map
/// knows that. The target of a step is the level's name.
///
/// # Examples
/// ```
/// # use openbench_core::{Address, Georeference, LonLat, StepMode};
/// # use openbench_osm::{OsmData, OsmMap};
/// let xml = r#"<osm version="0.6">
///     <node id="1" lat="48.1500" lon="11.5800"/><node id="2" lat="48.1500" lon="11.5804"/>
///     <node id="3" lat="48.1503" lon="11.5804"/>
///     <way id="4"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="1"/>
///         <tag k="building" v="yes"/><tag k="name" v="building3"/></way></osm>"#;
/// let data = OsmData::from_xml(xml.as_bytes())?;
/// let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(11.58, 48.15)));
///
/// let steps = openbench_language::steps(&map, &Address::new("building3", "unit1"), &[]);
/// assert_eq!((steps[0].mode, steps[0].target.as_str()), (StepMode::Navigate, "building3"));
/// assert_eq!((steps[1].mode, steps[1].target.as_str()), (StepMode::Explore, "unit1"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn steps(map: &OsmMap, address: &Address, levels: &[AddressLevel]) -> Vec<Step> {
    let mut steps = match locate(map, address) {
        Location::Unit { .. } => address.unit.iter().map(|unit| navigate(unit)).collect(),
        Location::Building(_) => {
            let building = std::iter::once(navigate(&address.building));
            building
                .chain(address.unit.iter().map(|unit| explore(unit)))
                .collect()
        }
        Location::Unknown | Location::Ambiguous(_) => steps_from_above(map, address, levels),
    };
    let is_below = |level: &&AddressLevel| matches!(level.level, Level::Floor | Level::Flat);
    steps.extend(
        levels
            .iter()
            .filter(is_below)
            .map(|level| explore(&level.name)),
    );
    steps
}

/// The steps to a building that the map cannot locate.
fn steps_from_above(map: &OsmMap, address: &Address, levels: &[AddressLevel]) -> Vec<Step> {
    let is_above = levels.iter().any(|level| level.level <= Level::Street);
    // Listing them takes time proportional to the map.
    let places = if is_above {
        enclosing_places(map)
    } else {
        Vec::new()
    };
    let known = levels
        .iter()
        // From the lowest level upwards: the robot navigates as near as the map allows.
        .rev()
        .find(|level| is_located(map, &places, level))
        .map(|level| navigate(&level.name));
    let building = std::iter::once(&address.building).filter(|name| !name.is_empty());
    let inside = building.chain(&address.unit).map(|name| explore(name));
    known.into_iter().chain(inside).collect()
}

/// Whether the map has a place for a street, quarter or town.
fn is_located(map: &OsmMap, places: &[EnclosingPlace], level: &AddressLevel) -> bool {
    places
        .iter()
        .any(|place| place.level == *level && place.place(map).is_some())
}

fn navigate(target: &str) -> Step {
    Step {
        mode: StepMode::Navigate,
        target: target.to_owned(),
    }
}

fn explore(target: &str) -> Step {
    Step {
        mode: StepMode::Explore,
        target: target.to_owned(),
    }
}

/// Where a delivery leads, in map coordinates (metres): the door, else the centroid of the
/// building. `None` if the map knows neither, though it may know the street.
///
/// # Examples
/// ```
/// # use openbench_core::{Address, Georeference, LonLat, MapPoint};
/// # use openbench_osm::{OsmData, OsmMap};
/// // A house of 30 m by 33 m, cut along its diagonal.
/// let xml = r#"<osm version="0.6">
///     <node id="1" lat="48.1500" lon="11.5800"/><node id="2" lat="48.1500" lon="11.5804"/>
///     <node id="3" lat="48.1503" lon="11.5804"/>
///     <way id="4"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="1"/>
///         <tag k="building" v="yes"/><tag k="name" v="building3"/></way></osm>"#;
/// let data = OsmData::from_xml(xml.as_bytes())?;
/// let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(11.58, 48.15)));
///
/// let at = openbench_language::destination(&map, &Address::new("building3", "unit1"));
/// assert!(at.is_some_and(|at| at.distance(MapPoint::new(19.8, 11.1)) < 0.5));
/// let unknown = Address::new("building4", "unit1");
/// assert_eq!(openbench_language::destination(&map, &unknown), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn destination(map: &OsmMap, address: &Address) -> Option<MapPoint> {
    match locate(map, address) {
        Location::Unit { entrance, .. } => map.entrances.get(entrance).map(|e| e.position),
        Location::Building(building) => map.buildings.get(building).map(|b| b.polygon.centroid()),
        Location::Unknown | Location::Ambiguous(_) => None,
    }
}
