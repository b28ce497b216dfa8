//! Whether the robot makes progress, and whether it moves at all.

use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, SimTime, Velocity};

use crate::surroundings::Surroundings;

/// Distance from where it last was in trouble at which the robot is out of it, metres.
const PROGRESS_M: f64 = 0.5;
/// Without progress for this long, a goal is given up.
pub(crate) const NO_PROGRESS: Duration = Duration::from_secs(25);
/// Time near moving obstacles does not count, up to this: sooner or later they are gone.
const NO_PROGRESS_AMONG_PEOPLE: Duration = Duration::from_secs(120);
/// A robot that has moved by less than this has almost stood, metres.
const CREEPING_M: f64 = 0.03;
/// A robot that has turned by less than this has almost stood, radians.
const CREEPING_RAD: f64 = 0.1;
/// A robot that was commanded to drive for so long and has almost stood is creeping: it makes no
/// progress, though its planner drives.
const CREEPING: Duration = Duration::from_millis(2000);
/// A command below this is to stand, m/s.
const STILL_MPS: f64 = 1e-3;
/// A command below this is to stand, rad/s.
const STILL_RADPS: f64 = 1e-2;

/// A place, and when the robot was there.
#[derive(Debug, Clone, Copy)]
struct Anchor {
    place: MapPoint,
    time: SimTime,
}

/// A pose, and for how long the robot has been commanded to drive since without leaving it.
#[derive(Debug, Clone, Copy)]
struct Standstill {
    pose: Pose2,
    driven: Duration,
}

impl Standstill {
    /// Whether the robot has almost not left the pose.
    fn holds(&self, pose: Pose2) -> bool {
        self.pose.point().distance(pose.point()) < CREEPING_M
            && wrap_angle(self.pose.yaw - pose.yaw).abs() < CREEPING_RAD
    }
}

/// Monitors the robot's progress.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ProgressMonitor {
    /// Where and when the robot last made progress.
    anchor: Option<Anchor>,
    /// For how long since then a moving obstacle has been near.
    waited: Duration,
    /// When that was last updated.
    last: Option<SimTime>,
    standstill: Option<Standstill>,
    /// Whether the last command was to drive.
    is_driven: bool,
}

impl ProgressMonitor {
    /// Updates the monitor; returns whether the robot has made progress.
    pub(crate) fn note(&mut self, now: &Surroundings<'_>) -> bool {
        let here = now.pose.point();
        let has_progressed = self
            .anchor
            .is_none_or(|anchor| anchor.place.distance(here) > PROGRESS_M);
        if has_progressed {
            self.anchor = Some(Anchor {
                place: here,
                time: now.time,
            });
            self.waited = Duration::ZERO;
        }
        let elapsed = now
            .time
            .since(self.last.replace(now.time).unwrap_or(now.time));
        if now.is_anybody_near() {
            self.waited += elapsed;
        }
        match &mut self.standstill {
            Some(standstill) if standstill.holds(now.pose) => {
                if self.is_driven {
                    standstill.driven += elapsed;
                }
            }
            _ => self.restart(now.pose),
        }
        has_progressed
    }

    /// The robot is commanded this.
    pub(crate) fn command(&mut self, velocity: Velocity) {
        let is_still = velocity.linear.abs() < STILL_MPS && velocity.angular.abs() < STILL_RADPS;
        self.is_driven = !is_still;
    }

    /// Whether the robot has almost stood while it was commanded to drive. Near moving obstacles it
    /// may well wait.
    pub(crate) fn is_creeping(&self, now: &Surroundings<'_>) -> bool {
        let still = self
            .standstill
            .is_some_and(|standstill| standstill.driven >= CREEPING);
        still && !now.has_anybody()
    }

    /// Whether the robot has made no progress for so long that its goal is to be given up.
    pub(crate) fn is_stagnant(&self, now: SimTime) -> bool {
        let Some(anchor) = self.anchor else {
            return false;
        };
        let stood = now.since(anchor.time);
        stood >= NO_PROGRESS_AMONG_PEOPLE || stood.saturating_sub(self.waited) >= NO_PROGRESS
    }

    /// Measures from `pose` on whether the robot moves at all.
    pub(crate) fn restart(&mut self, pose: Pose2) {
        self.standstill = Some(Standstill {
            pose,
            driven: Duration::ZERO,
        });
    }

    /// Leaves out a time in which the robot could not make progress.
    pub(crate) fn resume(&mut self, stood: Duration) {
        if let Some(anchor) = &mut self.anchor {
            anchor.time = anchor.time + stood;
        }
        // The next note then counts no time since, and compares with no pose from before.
        (self.standstill, self.last) = (None, None);
    }
}
