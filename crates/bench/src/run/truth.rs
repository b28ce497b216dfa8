//! The true pose as a localizer, for comparisons only. It is made here, injected into the agent by
//! name, and named in the results.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use openbench_core::frames::wrap_angle;
use openbench_core::{Observation, Pose2, SimTime, Velocity};
use openbench_localization::Localizer;
use openbench_sim::Simulator;

use super::observer::Observer;
use crate::BenchError;

/// Shared access to the true poses of the last second.
#[derive(Debug, Clone, Default)]
pub struct TruthHandle(Arc<Mutex<VecDeque<TimedPose>>>);

#[derive(Debug, Clone, Copy)]
struct TimedPose {
    time: SimTime,
    pose: Pose2,
}

/// Number of stored poses: one second at 20 Hz. Agents ask for the pose at the time of a scan or an
/// image, which is in the past.
const MAX_POSES: usize = 20;

impl TruthHandle {
    /// Stores the true pose of an instant.
    pub fn set(&self, time: SimTime, pose: Pose2) {
        // A lock that another thread poisoned by a panic is still used: poses are stored whole or
        // not at all.
        let mut poses = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        poses.push_back(TimedPose { time, pose });
        if poses.len() > MAX_POSES {
            poses.pop_front();
        }
    }

    /// The pose at an instant, linearly interpolated between the stored poses; outside their
    /// interval the nearest one.
    pub(crate) fn at(&self, time: SimTime) -> Pose2 {
        let poses = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Times ascend, since each step appends a later one.
        let after = poses.partition_point(|known| known.time < time);
        let before = after.checked_sub(1).and_then(|i| poses.get(i));
        match (before, poses.get(after)) {
            (Some(before), Some(after)) => interpolated(before, after, time),
            (one, other) => one.or(other).map(|known| known.pose).unwrap_or_default(),
        }
    }
}

fn interpolated(before: &TimedPose, after: &TimedPose, time: SimTime) -> Pose2 {
    let (a, b) = (before.pose, after.pose);
    // `at` searches so that `before.time < time <= after.time`: the divisor is positive.
    let elapsed = time.since(before.time).as_secs_f64();
    let s = elapsed / after.time.since(before.time).as_secs_f64();
    // The difference is wrapped first, so the yaw turns along the shorter arc.
    let yaw = wrap_angle(a.yaw + s * wrap_angle(b.yaw - a.yaw));
    Pose2::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), yaw)
}

/// Stores the true pose of each step.
impl Observer for TruthHandle {
    fn begin(&mut self, simulator: &Simulator) -> Result<(), BenchError> {
        self.set(simulator.time(), Pose2::from_pose3(&simulator.base_link()));
        Ok(())
    }

    fn step(&mut self, simulator: &Simulator, _velocity: Velocity) -> Result<(), BenchError> {
        self.begin(simulator)
    }
}

/// A localizer that returns the true pose.
#[derive(Debug, Clone)]
pub struct TruthLocalizer {
    handle: TruthHandle,
    now: SimTime,
}

impl TruthLocalizer {
    /// A localizer that reads the poses of `handle`.
    pub fn new(handle: TruthHandle) -> Self {
        Self {
            handle,
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
        self.handle.at(time)
    }

    fn pose(&self) -> Pose2 {
        self.handle.at(self.now)
    }

    fn ready(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_between_two_steps_are_interpolated_across_the_wrap_of_the_yaw() {
        let handle = TruthHandle::default();
        assert_eq!(handle.at(SimTime::ZERO), Pose2::default());
        handle.set(SimTime::from_millis(0), Pose2::new(0.0, 0.0, 3.1));
        handle.set(SimTime::from_millis(50), Pose2::new(1.0, 2.0, -3.1));
        let middle = handle.at(SimTime::from_millis(25));
        assert!((middle.x - 0.5).abs() < 1e-9 && (middle.y - 1.0).abs() < 1e-9);
        assert!(
            (middle.yaw.abs() - std::f64::consts::PI).abs() < 1e-9,
            "{middle:?}"
        );
        assert_eq!(handle.at(SimTime::from_millis(99)).x, 1.0);
    }
}
