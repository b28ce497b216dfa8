//! Where the robot was a moment ago.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{Pose2, SimTime};

/// Poses of this long are remembered.
pub(crate) const MEMORY: Duration = Duration::from_millis(1000);

/// The newest poses, one at least.
#[derive(Debug, Clone)]
pub(crate) struct History(VecDeque<(SimTime, Pose2)>);

impl History {
    pub(crate) fn from(start: Pose2) -> Self {
        Self(VecDeque::from([(SimTime::ZERO, start)]))
    }

    pub(crate) fn newest(&self) -> (SimTime, Pose2) {
        self.0.back().copied().unwrap_or_default()
    }

    /// Takes a pose in; one that is not later than the newest takes its place.
    pub(crate) fn push(&mut self, stamp: SimTime, pose: Pose2) {
        if stamp <= self.newest().0 {
            self.0.pop_back();
        }
        self.0.push_back((stamp, pose));
        while self.0.len() > 2 && stamp.since(self.0[1].0) > MEMORY {
            self.0.pop_front();
        }
    }

    /// The pose at an instant, between two along a straight line; outside them the nearest.
    pub(crate) fn at(&self, time: SimTime) -> Pose2 {
        let after = self.0.partition_point(|(t, _)| *t < time);
        let Some(&(t1, b)) = self.0.get(after) else {
            return self.newest().1;
        };
        let Some(&(t0, a)) = after.checked_sub(1).and_then(|i| self.0.get(i)) else {
            return b;
        };
        let s = time.since(t0).as_secs_f64() / t1.since(t0).as_secs_f64().max(1e-9);
        Pose2::new(
            a.x + s * (b.x - a.x),
            a.y + s * (b.y - a.y),
            a.yaw + s * wrap_angle(b.yaw - a.yaw),
        )
    }
}
