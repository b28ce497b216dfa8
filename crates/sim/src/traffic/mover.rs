//! A person or a car at an instant, and the robot as they see it.

use openbench_core::{MapPoint, Pose2};

/// Radius of a person, metres: the argument `free` of [`Traffic::new`](super::Traffic::new) tells
/// where a disc of this radius fits.
pub const PERSON_RADIUS_M: f64 = 0.25;

/// The robot as people and cars see it: a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotState {
    /// Its middle in `map`, metres.
    pub position: MapPoint,
    /// Its velocity in `map`, m/s.
    pub velocity: [f64; 2],
    /// Radius of the disc, metres.
    pub radius: f64,
}

impl RobotState {
    /// The same state, or one far away if it contains NaN, infinity or absurd numbers.
    pub(super) fn sanitized(self) -> Self {
        let Self {
            position,
            velocity,
            radius,
        } = self;
        let numbers = [position.x, position.y, velocity[0], velocity[1], radius];
        if numbers.iter().all(|v| v.is_finite() && v.abs() < 1e7) {
            return self;
        }
        Self {
            position: MapPoint::new(1e7, 1e7),
            velocity: [0.0; 2],
            radius: 0.0,
        }
    }
}

/// Kind of a mover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MoverKind {
    /// A person on foot.
    Pedestrian,
    /// A car.
    Car,
}

/// The outline of a mover, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hull {
    /// A person.
    Disc {
        /// Metres.
        radius: f64,
    },
    /// A car: a rectangle about its pose.
    Box {
        /// Half the length, metres.
        half_length: f64,
        /// Half the width, metres.
        half_width: f64,
    },
}

/// A person or a car at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mover {
    /// What it is.
    pub kind: MoverKind,
    /// Whether it is on the map: cars leave and come in again.
    pub present: bool,
    /// Middle of the hull and heading, in `map`.
    pub pose: Pose2,
    /// Velocity in `map`, m/s.
    pub velocity: [f64; 2],
    /// Outline.
    pub hull: Hull,
    /// Phase of the walking cycle, 0 to 1 (left foot in front at 0); 0 for cars.
    pub gait: f64,
    /// Number that selects its figure: any number, the same for the mover's whole life.
    pub look: u32,
}

impl Mover {
    /// A mover that is not on the map yet.
    pub(super) fn absent() -> Self {
        Self {
            kind: MoverKind::Pedestrian,
            present: false,
            pose: Pose2::default(),
            velocity: [0.0; 2],
            hull: Hull::Disc {
                radius: PERSON_RADIUS_M,
            },
            gait: 0.0,
            look: 0,
        }
    }
}
