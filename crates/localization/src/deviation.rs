//! How far a pose may be off.

/// One standard deviation of a pose's position and rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseDeviation {
    /// Of the position along each axis, metres.
    pub metres: f64,
    /// Of the rotation, radians.
    pub radians: f64,
}
