//! Where the robot was while a scan was taken.

use openbench_core::{Pose3, SimTime};

/// Poses of `base_link` in a frame that has no jumps.
pub trait Track {
    /// The pose at an instant of the last second.
    fn pose3_at(&self, time: SimTime) -> Pose3;
}
