//! A door in a wall: where it is, and how much of the wall it takes.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use openbench_core::{Address, MapPoint, Pose2};
use openbench_geometry::Segment;

use crate::plate::PLATE_WIDTH_M;

/// Width of a door leaf, metres.
pub(super) const LEAF_WIDTH_M: f64 = 1.0;
/// What the frame takes of the wall on each side of the leaf, metres.
const FRAME_WIDTH_M: f64 = 0.15;
/// A door farther from a wall's line than this is in another wall, metres.
const OFF_WALL_M: f64 = 0.1;

/// A door in a wall.
#[derive(Debug, Clone)]
pub(crate) struct Doorway {
    /// Building and unit.
    pub address: Address,
    /// Text on the plate.
    pub text: String,
    /// Index of the building.
    pub building: usize,
    /// Foot of the door, in the wall.
    pub position: MapPoint,
    /// Direction out of the wall, radians.
    pub facing: f64,
    /// The wall, the building on its left.
    pub wall: Segment,
    /// Position of the plate along the wall from the middle of the door, metres; 0 is on the leaf.
    pub plate_offset: f64,
}

impl Doorway {
    /// Facing out of the wall; left is along the wall.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.position.x, self.position.y, self.facing)
    }

    /// Foot of the plate, in the wall.
    pub fn plate_point(&self) -> MapPoint {
        self.pose().transform(0.0, self.plate_offset)
    }

    /// What door and plate take of a wall, metres from where the wall begins; `None` if they are in
    /// another.
    pub fn span_on(&self, wall: Segment) -> Option<Range<f64>> {
        let direction = wall.bearing();
        let in_wall = Pose2::new(wall.start.x, wall.start.y, direction);
        let (along, aside) = in_wall.inverse_transform(self.position);
        // A wall has its building on the left, so a door faces to its right.
        let parallel = libm::cos(self.facing + FRAC_PI_2 - direction) > 0.99;
        if !parallel || aside.abs() > OFF_WALL_M || along < 0.0 || along > wall.length() {
            return None;
        }
        let plate = along + self.plate_offset;
        let half = PLATE_WIDTH_M / 2.0;
        let from = (along - LEAF_WIDTH_M / 2.0 - FRAME_WIDTH_M).min(plate - half);
        let to = (along + LEAF_WIDTH_M / 2.0 + FRAME_WIDTH_M).max(plate + half);
        Some(from..to)
    }
}
