//! A scene with everything that an episode in it needs.

use openbench_core::{Georeference, Pose2};
use openbench_osm::OsmData;

use crate::drawn_doors::DrawnDoors;
use crate::plates::DrawnPlates;
use crate::scene::Scene;
use crate::scenery::DrawnScenery;

/// If the start is farther than this from the origin of its frame, the origin is moved, metres.
/// Triangles are in single precision, which resolves 0.03 mm here, and 0.12 mm four times as far
/// away.
pub(crate) const MAX_FROM_ORIGIN_M: f64 = 500.0;

/// A world: its scene, and the map of it that agents get.
#[derive(Debug, Clone)]
pub struct World {
    /// Name, as in results.
    pub name: String,
    /// Surfaces and doors.
    pub scene: Scene,
    /// The public map: ordinary OSM, in which doors may be missing.
    pub map: OsmData,
    /// How the `map` frame lies on the Earth. Its origin is near the start.
    pub georeference: Georeference,
    /// Start pose of robots.
    pub start: Pose2,
    /// Licences and authors to name beside images and maps of this world.
    pub attribution: Vec<String>,
    /// The doors that were drawn where the map has none; `None` if none were asked for.
    pub doors: Option<DrawnDoors>,
    /// The plates that were drawn as in streets; `None` if all are as in the published worlds.
    pub plates: Option<DrawnPlates>,
    /// What was drawn to make streets differ; `None` if nothing was.
    pub scenery: Option<DrawnScenery>,
    /// What import or generation left out.
    pub warnings: Vec<String>,
}
