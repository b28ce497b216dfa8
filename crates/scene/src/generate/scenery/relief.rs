//! What changes the height of the ground, planned before anything is built: doors must know their
//! steps, and the ground its holes.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::Segment;

use super::kinds::Footprint;
use crate::generate::doors::doorway::Doorway;
use crate::generate::layout::clearance::{BARRIER, Clearance};
use crate::generate::layout::occupied::Occupied;

/// Height of a step, metres.
pub(super) const RISE_M: f64 = 0.15;
/// Depth of a step, metres.
pub(super) const TREAD_M: f64 = 0.3;
/// Depth of the platform before a door, metres.
pub(super) const PLATFORM_M: f64 = 1.0;
/// Half the width of steps and ramps, metres.
pub(super) const HALF_WIDTH_M: f64 = 0.75;
/// Length of a ramp: one in eight, metres.
pub(super) const RAMP_M: f64 = 8.0 * RISE_M;
/// The axis of the ground of steps ends this far from its ends, metres.
const ENDS_M: f64 = 0.4;
/// Thickness of a rim, metres.
pub(super) const RIM_M: f64 = 0.12;

/// Steps, ramps and light wells of a world.
#[derive(Debug, Default)]
pub(crate) struct Relief {
    /// Entries that are not level.
    pub entries: Vec<Entry>,
    pub wells: Vec<Well>,
    /// Triangles of the ground between the wells; none without wells.
    pub ground: Vec<[MapPoint; 3]>,
}

impl Relief {
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

/// What leads up to a door.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Steps(u8),
    Ramp,
}

/// A door with steps or a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Entry {
    /// Faces out of the wall.
    pub door: Pose2,
    /// Height of the door above the ground, metres.
    pub lift: f64,
    pub(super) form: Form,
    /// Metres out of the wall.
    pub(super) depth: f64,
}

impl Entry {
    pub(super) fn new(door: Pose2, form: Form) -> Self {
        let (lift, depth) = match form {
            Form::Steps(count) => {
                let count = f64::from(count);
                (RISE_M * count, PLATFORM_M + TREAD_M * (count - 1.0))
            }
            Form::Ramp => (RISE_M, PLATFORM_M + RAMP_M),
        };
        Self {
            door,
            lift,
            form,
            depth,
        }
    }

    /// The ground that it takes.
    pub fn footprint(&self) -> Footprint {
        Footprint {
            axis: Segment::new(
                self.door.transform(ENDS_M, 0.0),
                self.door.transform(self.depth - ENDS_M, 0.0),
            ),
            // Up to the corners.
            radius: libm::hypot(ENDS_M, HALF_WIDTH_M) + 1e-6,
        }
    }
}

/// A place without ground at a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Well {
    /// At the middle of its side at the wall, facing out of that.
    pub(super) pose: Pose2,
    /// Half its length along the wall, metres.
    pub(super) half: f64,
    /// Its width out of the wall, metres.
    pub(super) width: f64,
    /// Metres.
    pub(super) depth: f64,
    /// Height of its rim, metres; 0 without one.
    pub(super) rim: f64,
}

impl Well {
    /// Its corners, counter-clockwise.
    pub fn ring(&self) -> [MapPoint; 4] {
        let point = |forward, left| self.pose.transform(forward, left);
        [
            point(0.0, -self.half),
            point(self.width, -self.half),
            point(self.width, self.half),
            point(0.0, self.half),
        ]
    }

    /// Its outline as a hole in the ground: clockwise.
    pub fn hole(&self) -> Vec<MapPoint> {
        self.ring().into_iter().rev().collect()
    }

    /// The ground that it takes.
    pub fn footprint(&self) -> Footprint {
        // Up to the corners of the rim.
        let radius = libm::hypot(self.width / 2.0 + RIM_M, RIM_M) + 1e-6;
        Footprint {
            axis: Segment::new(
                self.pose.transform(self.width / 2.0, -self.half),
                self.pose.transform(self.width / 2.0, self.half),
            ),
            radius,
        }
    }
}
