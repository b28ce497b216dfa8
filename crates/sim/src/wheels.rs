//! Speeds of the wheels.

/// Angular speeds of the left and right wheels, rad/s. The two wheels of a side turn alike.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct WheelSpeeds {
    pub(crate) left: f64,
    pub(crate) right: f64,
}

impl WheelSpeeds {
    /// Speed of the faster side, rad/s.
    pub(crate) fn fastest(self) -> f64 {
        self.left.abs().max(self.right.abs())
    }
}
