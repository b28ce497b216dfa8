//! A maneuver being driven.

use openbench_core::{SimTime, Velocity};

use super::ladder::Step;
use crate::feasible::ConflictCheck;
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::shape::Footprint;
use crate::surroundings::Surroundings;
use crate::trajectory::Trajectory;

/// Distance from obstacles that a maneuver keeps to be driven on, metres.
const SURE_M: f64 = 0.001;
/// Seconds until a conflict below which a maneuver is not driven on.
const SOON_S: f64 = 1.0;
/// Seconds that a velocity is driven until the next command, and a little for latency.
const HOLD_S: f64 = 0.1;
/// Speeds below this count as none, m/s.
const NO_SPEED_MPS: f64 = 1e-3;

/// A maneuver, as far as it is still to be driven.
#[derive(Debug, Clone)]
pub(crate) struct UnderWay {
    band: Trajectory,
    /// When it was last updated.
    seen: SimTime,
}

impl UnderWay {
    /// Sets out on a maneuver.
    pub(crate) fn new(band: Trajectory, now: SimTime) -> Self {
        Self { band, seen: now }
    }

    /// What it begins with.
    pub(crate) fn first_step(&self) -> Step {
        match self.band.velocity(0).linear {
            v if v < -NO_SPEED_MPS => Step::Back,
            v if v < NO_SPEED_MPS => Step::Turn,
            _ => Step::Maneuver,
        }
    }

    /// Drops what has been driven by now.
    pub(crate) fn keep_up(&mut self, now: &Surroundings<'_>) {
        self.band
            .keep_up(now.pose, now.time.since(self.seen).as_secs_f64());
        self.seen = now.time;
    }

    /// The velocity that leads along it.
    pub(crate) fn command(&self, limits: &Limits) -> Velocity {
        self.band.command(limits)
    }

    /// Whether it is driven. Its last steps lead to the very place of the goal, which a robot just
    /// beside it may not reach.
    pub(crate) fn is_over(&self) -> bool {
        self.band.duration() < 3.0 * HOLD_S
    }

    /// Whether an obstacle blocks it by now, or the robot that drives with `command` could not stop
    /// before an obstacle.
    pub(crate) fn is_blocked(
        &self,
        footprint: &Footprint,
        limits: &Limits,
        now: &Surroundings<'_>,
        command: Velocity,
    ) -> bool {
        let motion = Motion {
            pose: now.pose,
            velocity: now.velocity,
            command,
        };
        let check = ConflictCheck {
            footprint,
            limits,
            obstacles: now.obstacles,
            margin: SURE_M,
        };
        let conflict = check.first_conflict(&self.band);
        check.conflict_before_stop(motion, HOLD_S).is_some()
            || conflict.is_some_and(|at| at < SOON_S)
    }
}
