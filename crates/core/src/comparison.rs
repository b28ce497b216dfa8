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

/// How well places fit what an agent saw, each with its best heading.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaceScores {
    /// South-west corner in `map`.
    pub origin: MapPoint,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Columns.
    pub width: usize,
    /// The cells, row by row from the south-west: linear in the log-likelihood, from 0 for the
    /// worst of all to 100 for the best; -1 where the agent cannot be.
    pub cells: Vec<i8>,
}

/// What an agent found when it compared what it saw with its map, to find out where it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MapComparison {
    /// Poses that it may have, the most probable one first; not all of them.
    pub hypotheses: Vec<Hypothesis>,
    /// The pose that it goes by; `None` if none is certain enough.
    pub accepted: Option<AcceptedPose>,
    /// Whether what it saw did not confirm that pose, which it goes by all the same.
    pub is_refused: bool,
    /// Some of the facades that it saw, where they are in `map` if it has the accepted pose, or
    /// else the most probable one.
    pub facades: Vec<MapPoint>,
    /// How well all places fit, while the agent does not know where it is.
    pub places: Option<PlaceScores>,
}
