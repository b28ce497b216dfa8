//! What an agent finds when it compares what it sees with its map.

use crate::frames::{MapPoint, Pose2};

/// A pose that an agent may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// Pose of `base_link` in `map`.
    pub pose: Pose2,
    /// Its probability, 0 to 1.
    pub probability: f64,
}

/// A pose that an agent takes for its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AcceptedPose {
    /// Pose of `base_link` in `map`.
    pub pose: Pose2,
    /// Covariance of x and y in `map`, and yaw; m² and rad².
    pub covariance: [[f64; 3]; 3],
}

/// What an agent found when it compared what it saw with its map, to find out where it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MapComparison {
    /// Poses that it may have, the most probable one first; not all of them.
    pub hypotheses: Vec<Hypothesis>,
    /// The pose that it goes by; `None` if none is certain enough.
    pub accepted: Option<AcceptedPose>,
    /// Some of the facades that it saw, where they are in `map` if it has the accepted pose, or
    /// else the most probable one.
    pub facades: Vec<MapPoint>,
}
