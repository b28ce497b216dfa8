//! Poses of the last second.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{Pose2, SimTime};

/// Poses are kept for this time.
pub(crate) const MEMORY: Duration = Duration::from_millis(1000);

/// A pose at an instant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StampedPose {
    pub(crate) stamp: SimTime,
    pub(crate) pose: Pose2,
}

/// The newest poses, at least one.
#[derive(Debug, Clone)]
pub(crate) struct History(VecDeque<StampedPose>);

impl History {
    pub(crate) fn from(start: Pose2) -> Self {
        Self(VecDeque::from([StampedPose {
            stamp: SimTime::ZERO,
            pose: start,
        }]))
    }

    pub(crate) fn newest(&self) -> StampedPose {
        self.0.back().copied().unwrap_or_default()
    }

    /// Takes in a pose. One that is not later than the newest replaces it.
    pub(crate) fn push(&mut self, stamp: SimTime, pose: Pose2) {
        if stamp <= self.newest().stamp {
            self.0.pop_back();
        }
        self.0.push_back(StampedPose { stamp, pose });
        // The second entry decides: the oldest is needed to interpolate up to it.
        while self.0.len() > 2 && stamp.since(self.0[1].stamp) > MEMORY {
            self.0.pop_front();
        }
    }

    /// The pose at an instant, interpolated between two; outside of all the nearest in time.
    pub(crate) fn at(&self, time: SimTime) -> Pose2 {
        let after = self.0.partition_point(|entry| entry.stamp < time);
        let Some(&to) = self.0.get(after) else {
            return self.newest().pose;
        };
        let before = after.checked_sub(1).and_then(|i| self.0.get(i));
        let Some(&from) = before else { return to.pose };
        interpolated(from, to, time)
    }
}

/// The pose between two along a straight line.
fn interpolated(from: StampedPose, to: StampedPose, time: SimTime) -> Pose2 {
    let interval = to.stamp.since(from.stamp).as_secs_f64().max(1e-9);
    let share = time.since(from.stamp).as_secs_f64() / interval;
    let (a, b) = (from.pose, to.pose);
    Pose2::new(
        a.x + share * (b.x - a.x),
        a.y + share * (b.y - a.y),
        a.yaw + share * wrap_angle(b.yaw - a.yaw),
    )
}
