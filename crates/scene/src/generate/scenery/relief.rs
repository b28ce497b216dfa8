//! What changes the height of the ground, planned before anything is built: doors must know their
//! steps, and the ground its holes.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Bounds, Segment};
use openbench_osm::OsmMap;

use super::kinds::Footprint;
use super::steps::{self, Entry};
use super::wells::{self, Well};
use crate::generate::doors::doorway::Doorway;
use crate::generate::ground::pitted::pieces;
use crate::generate::layout::clearance::{BARRIER, Clearance};
use crate::generate::layout::features::Feature;
use crate::generate::layout::occupied::Occupied;
use crate::generate::options::SceneryOptions;

/// What relief is planned from.
pub(in crate::generate) struct Site<'a> {
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

/// Steps, ramps and light wells of a world.
#[derive(Debug, Default)]
pub(in crate::generate) struct Relief {
    /// Entries that are not level.
    pub entries: Vec<Entry>,
    pub wells: Vec<Well>,
    /// Triangles of the ground between the wells; none without wells.
    pub ground: Vec<[MapPoint; 3]>,
}

impl Relief {
    /// Draws the relief of a site. Each thing leaves the ways open that those before it left.
    pub fn plan(site: &Site) -> Self {
        if site.options.amounts.relief <= 0.0 {
            return Self::default();
        }
        let mut occupied = Occupied::new(site.clearance);
        let entries = steps::plan(site, &mut occupied);
        let wells = wells::plan(site, &mut occupied);
        let holes: Vec<Vec<MapPoint>> = wells.iter().map(Well::hole).collect();
        // Without a ground that adds up there are no wells: neither pits nor counts may have them.
        let ground = pieces(site.ground, &holes).filter(|_| !holes.is_empty());
        let wells = if ground.is_some() { wells } else { Vec::new() };
        Self {
            entries,
            wells,
            ground: ground.unwrap_or_default(),
        }
    }

    /// Height of a door above the ground, metres.
    pub fn lift(&self, door: &Doorway) -> f64 {
        let entry = self
            .entries
            .iter()
            .find(|e| e.door.point() == door.position);
        entry.map_or(0.0, |entry| entry.lift)
    }

    fn footprints(&self) -> impl Iterator<Item = Footprint> {
        let entries = self.entries.iter().map(Entry::footprint);
        entries.chain(self.wells.iter().map(Well::footprint))
    }

    /// Keeps its ground free of what avoids barriers: shrubs avoid no objects.
    pub fn keep_free(&self, clearance: &mut Clearance) {
        for ground in self.footprints() {
            clearance.add(ground.axis, ground.radius, BARRIER);
        }
    }

    /// Records its ground for what avoids objects.
    pub fn occupy(&self, occupied: &mut Occupied) {
        for ground in self.footprints() {
            occupied.add(ground.axis, ground.radius);
        }
    }

    /// Outlines of the places without ground, clockwise.
    pub fn holes(&self) -> Vec<Vec<MapPoint>> {
        self.wells.iter().map(Well::hole).collect()
    }
}

/// Nothing stands as near to a gate, metres.
const GATE_ROOM_M: f64 = 1.6;
/// Half the width that stays free in front of every door, metres: twice the robot's.
pub(super) const DOOR_LANE_M: f64 = 0.5;
/// Depth of that lane, metres.
const DOOR_LANE_DEPTH_M: f64 = 3.5;

/// The gates of a map.
pub(in crate::generate) fn gates(map: &OsmMap) -> Vec<MapPoint> {
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
