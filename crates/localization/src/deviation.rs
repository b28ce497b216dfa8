//! How far a pose may be off.

/// One standard deviation of a pose's position and rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PoseDeviation {
    pub(crate) metres: f64,
    pub(crate) radians: f64,
}
