//! Where the robot was while a scan was taken.

use nalgebra::Matrix3;
use openbench_core::{Pose3, SimTime};

/// Poses of `base_link` in a frame that has no jumps.
pub trait Track {
    /// The pose at an instant of the last second.
    fn pose3_at(&self, time: SimTime) -> Pose3;

    /// Covariance of the newest pose as of the last scan, in the same frame: x and y, then yaw; m²
    /// and rad². `None` if the poses come without one.
    fn pose_covariance(&self) -> Option<Matrix3<f64>> {
        None
    }
}
