//! The truth as a localizer, for comparisons only: made here, handed to an agent from outside, named in the results.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::{Observation, Pose2, SimTime};
use openbench_localization::Localizer;

/// Where the runner writes the true pose of each instant.
#[derive(Debug, Clone, Default)]
pub struct TruthHandle(Arc<Mutex<VecDeque<(SimTime, Pose2)>>>);

/// Poses that are remembered: one second at 20 Hz.
const MEMORY: usize = 20;

impl TruthHandle {
    /// Notes where the robot is now.
    pub fn set(&self, time: SimTime, pose: Pose2) {
        let mut poses = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        poses.push_back((time, pose));
        if poses.len() > MEMORY {
            poses.pop_front();
        }
    }

    fn nearest(&self, time: SimTime) -> Pose2 {
        let poses = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let away = |t: SimTime| t.0.abs_diff(time.0);
        poses.iter().min_by_key(|(t, _)| away(*t)).map(|(_, pose)| *pose).unwrap_or_default()
    }
}

/// A localizer that is never wrong.
#[derive(Debug, Clone)]
pub struct TruthLocalizer {
    handle: TruthHandle,
    now: SimTime,
}

impl TruthLocalizer {
    /// A localizer that reads from `handle`.
    pub fn new(handle: TruthHandle) -> Self {
        Self { handle, now: SimTime::ZERO }
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
        self.handle.nearest(time)
    }

    fn pose(&self) -> Pose2 {
        self.handle.nearest(self.now)
    }

    fn ready(&self) -> bool {
        true
    }
}
