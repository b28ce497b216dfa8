//! The three worlds that the crate carries, so that nothing has to be downloaded for a first run.

use openbench_core::{Georeference, Pose2};
use openbench_osm::OsmData;

use super::{Alterations, GenerateError, GenerateOptions, generate};
use crate::world::World;

/// A map that the crate carries.
struct BuiltInMap {
    name: &'static str,
    xml: &'static str,
}

const MAPS: [BuiltInMap; 3] = [
    BuiltInMap {
        name: "small",
        xml: include_str!("../../assets/small.osm"),
    },
    BuiltInMap {
        name: "medium",
        xml: include_str!("../../assets/medium.osm"),
    },
    BuiltInMap {
        name: "large",
        xml: include_str!("../../assets/large.osm"),
    },
];

/// Names of the built-in worlds.
pub fn builtin_names() -> [&'static str; 3] {
    MAPS.map(|map| map.name)
}

/// Georeference of the built-in maps: the origin is the robot's start.
pub fn builtin_georeference() -> Georeference {
    Georeference::Utm {
        zone: 50,
        north: true,
        // UTM gives the central meridian the easting of 500 km.
        offset_x: -500_000.0,
        offset_y: -4_483_000.0,
    }
}

/// The map of a built-in world, doors included; `None` if there is no such world.
pub(crate) fn builtin_map(name: &str) -> Option<Result<OsmData, GenerateError>> {
    let map = MAPS.into_iter().find(|map| map.name == name)?;
    let data = OsmData::from_xml(map.xml.as_bytes());
    Some(data.map_err(|source| GenerateError::Builtin {
        name: map.name.to_owned(),
        source,
    }))
}

/// A built-in world; `None` if there is none of that name.
pub fn builtin(name: &str, seed: u64) -> Option<Result<World, GenerateError>> {
    builtin_with(name, seed, Alterations::default())
}

/// A built-in world that is altered; `None` if there is none of that name.
pub fn builtin_with(
    name: &str,
    seed: u64,
    by: Alterations,
) -> Option<Result<World, GenerateError>> {
    let options = GenerateOptions {
        name: name.to_owned(),
        start: Some(Pose2::default()),
        attribution: vec![format!("Built-in map `{name}`: a made-up place, CC0")],
        ..GenerateOptions::default()
    }
    .altered(by);
    let map = builtin_map(name)?;
    Some(map.and_then(|data| generate(&data, builtin_georeference(), seed, &options)))
}
