//! The true pose as a localizer.

use openbench_core::{Observation, Pose2, SimTime};
use openbench_localization::Localizer;

use crate::run::PosesOnMap;

/// A localizer that returns the true pose.
#[derive(Debug, Clone)]
pub struct TruthLocalizer {
    poses: PosesOnMap,
    now: SimTime,
}

impl TruthLocalizer {
    /// A localizer that reads the true poses.
    pub fn new(poses: PosesOnMap) -> Self {
        Self {
            poses,
            now: SimTime::ZERO,
        }
    }
}

impl Localizer for TruthLocalizer {
    fn name(&self) -> &str {
        "truth"
    }

    fn reset(&mut self, _start: Pose2) {
        self.now = SimTime::ZERO;
    }

    fn update(&mut self, observation: &Observation<'_>) {
        self.now = observation.time;
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.poses.pose_at(time)
    }

    fn pose(&self) -> Pose2 {
        self.poses.pose_at(self.now)
    }

    fn ready(&self) -> bool {
        true
    }
}
