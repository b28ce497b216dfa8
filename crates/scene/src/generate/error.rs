//! Why no world could be generated: what, where, and what to do.

use openbench_osm::OsmError;

/// Largest extent of a map that is built, metres.
pub(super) const MAX_EXTENT_M: f64 = 20_000.0;
/// Most buildings in a world.
pub(super) const MAX_BUILDINGS: usize = 30_000;

/// Why no world could be generated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// There is no building to deliver to.
    #[error(
        "the map has no usable building ({broken} have broken outlines); give a map with \
         `building=*` outlines"
    )]
    NoBuildings {
        /// Buildings without a closed outline.
        broken: usize,
    },
    /// The map covers more than a neighbourhood.
    #[error(
        "the map is {metres:.0} m across, more than {MAX_EXTENT_M:.0} m; cut out a neighbourhood"
    )]
    TooLarge {
        /// Its longer side, metres.
        metres: f64,
    },
    /// The map has too many buildings.
    #[error(
        "the map has {buildings} buildings, more than {MAX_BUILDINGS}; cut out a neighbourhood"
    )]
    TooMany {
        /// Number of buildings.
        buildings: usize,
    },
    /// The georeference belongs to another place: its projection distorts lengths here.
    #[error(
        "the map lies {metres:.0} m from where `{georeference}` keeps lengths; give the UTM zone \
         of this map, or a tangent plane that touches the Earth near it"
    )]
    Distorted {
        /// Distance of the middle of the map from the central meridian or the point of contact,
        /// metres.
        metres: f64,
        /// The georeference that was given.
        georeference: String,
    },
    /// There is no place for the robot.
    #[error("no clear place to start at was found near a road or path; give a start")]
    NoStart,
    /// A built-in map cannot be read.
    #[error("built-in world `{name}`: {source}")]
    Builtin {
        /// Name of the built-in world.
        name: String,
        /// Why its map cannot be read.
        source: OsmError,
    },
}
