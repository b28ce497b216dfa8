//! Motion by wheels and gyroscope alone, beside the filter.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use openbench_core::Pose3;

/// A motion of the robot's frame by wheels and gyroscope.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reckoned {
    /// Pose of the robot's frame at the end in that at the beginning.
    pub(super) motion: Pose3,
    /// Distance driven, metres.
    pub(super) metres: f64,
    /// Angle turned in all directions together, radians.
    pub(super) radians: f64,
    /// Velocity at the end in the robot's frame, m/s.
    pub(super) velocity: Vector3<f64>,
}

impl Reckoned {
    /// Goes on for some seconds with a velocity, m/s, and a turn rate, rad/s, in the robot's frame.
    pub(super) fn advance(&mut self, velocity: Vector3<f64>, rate: Vector3<f64>, seconds: f64) {
        let turn = UnitQuaternion::from_scaled_axis(rate * seconds);
        // The chord of an arc points along the heading of half the arc.
        let half_turn = UnitQuaternion::from_scaled_axis(rate * (0.5 * seconds));
        self.motion *= Isometry3::from_parts((half_turn * velocity * seconds).into(), turn);
        self.metres += velocity.norm() * seconds;
        self.radians += rate.norm() * seconds;
        self.velocity = velocity;
    }
}
