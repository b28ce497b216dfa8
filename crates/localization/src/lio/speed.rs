//! A velocity as wheels report it.

use nalgebra::Vector3;
use openbench_core::SimTime;

/// Nothing drives faster, m/s or rad/s.
const MAX_SPEED: f64 = 1e4;
/// No velocity is known better, m/s.
const MIN_DEVIATION_M_S: f64 = 1e-6;

/// A velocity of the frame whose pose is estimated, such as `base_link`, in that frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed {
    /// When.
    pub stamp: SimTime,
    /// m/s.
    pub velocity: Vector3<f64>,
    /// Standard deviations along the frame's axes, m/s.
    pub deviation: Vector3<f64>,
    /// Turn rate of the frame about its z axis, rad/s. Skidding wheels know it roughly.
    pub turn: f64,
}

impl Speed {
    /// Whether it can be used.
    pub(super) fn is_sound(&self) -> bool {
        self.velocity.iter().all(|x| x.abs() <= MAX_SPEED)
            && self
                .deviation
                .iter()
                .all(|x| (MIN_DEVIATION_M_S..=MAX_SPEED).contains(x))
            && self.turn.abs() <= MAX_SPEED
    }
}
