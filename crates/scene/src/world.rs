//! A scene with all that an episode in it needs.

use openbench_core::{Georeference, Pose2};
use openbench_osm::OsmData;

use crate::scene::Scene;

/// A start farther than this from its frame's origin moves the origin, metres. Single precision, in which the triangles
/// are, resolves 0.03 mm here, and 0.12 mm four times as far away.
pub(crate) const MAX_FROM_ORIGIN_M: f64 = 500.0;

/// A world: what is there, and the map of it that agents get.
#[derive(Debug, Clone)]
pub struct World {
    /// Name, as in results.
    pub name: String,
    /// What is there.
    pub scene: Scene,
    /// The public map: ordinary OSM, in which doors may be missing.
    pub map: OsmData,
    /// How the `map` frame lies on the Earth. Its origin is near the start.
    pub georeference: Georeference,
    /// Where robots start.
    pub start: Pose2,
    /// Licences and authors to be named beside pictures and maps of this world.
    pub attribution: Vec<String>,
    /// What import or generation had to skip, in words.
    pub warnings: Vec<String>,
}
