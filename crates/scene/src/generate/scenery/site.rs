//! What things are placed in: the ground of a world as it is before any of them is built.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Bounds, Segment};
use openbench_osm::OsmMap;

use crate::generate::doors::doorway::Doorway;
use crate::generate::layout::clearance::Clearance;
use crate::generate::layout::features::Feature;
use crate::generate::options::SceneryOptions;

/// What relief is planned from.
pub(crate) struct Site<'a> {
    pub map: &'a OsmMap,
    pub clearance: &'a Clearance,
    pub doorways: &'a [Doorway],
    /// What the ground covers.
    pub ground: Bounds,
    /// Gates in barriers.
    pub gates: &'a [MapPoint],
    /// Where the map has lamps, benches and trees.
    pub features: &'a [Feature],
    pub options: &'a SceneryOptions,
    /// Whether the sea is cut out of the ground: then it has no other holes.
    pub has_sea: bool,
}

/// Nothing stands as near to a gate, metres.
const GATE_ROOM_M: f64 = 1.6;
/// Half the width that stays free in front of every door, metres: twice the robot's.
pub(super) const DOOR_LANE_M: f64 = 0.5;
/// Depth of that lane, metres.
const DOOR_LANE_DEPTH_M: f64 = 3.5;

/// The gates of a map.
pub(crate) fn gates(map: &OsmMap) -> Vec<MapPoint> {
    let barriers = map.barriers.iter();
    barriers.flat_map(|barrier| barrier.gates.clone()).collect()
}

/// Whether what lies within `radius` metres of an axis leaves all gates open.
pub(super) fn keeps_off_gates(gates: &[MapPoint], axis: Segment, radius: f64) -> bool {
    let mut gates = gates.iter();
    gates.all(|gate| axis.distance_to_point(*gate) > radius + GATE_ROOM_M)
}

/// Whether a robot can stand before a door that something lies beside, within `radius` metres of an
/// axis.
pub(super) fn leaves_door(door: &Doorway, axis: Segment, radius: f64) -> bool {
    let front = door.position.offset(door.facing, DOOR_LANE_DEPTH_M);
    let lane = Segment::new(door.position, front);
    axis.distance_to(lane) > radius + DOOR_LANE_M - 1e-9
}

/// A pose with another origin in its frame: so far forward and to the left, metres.
pub(super) fn shifted(pose: Pose2, forward: f64, left: f64) -> Pose2 {
    let p = pose.transform(forward, left);
    Pose2::new(p.x, p.y, pose.yaw)
}
