//! How far one gets without finding a way.

use openbench_core::{
    Action, Agent, Briefing, Events, FailureCause, GiveUp, MapPoint, Observation, RobotDescription,
    SimTime, Velocity,
};

use super::errands::{Errands, Stop, give_up};
use super::following::Follower;
use crate::run::truth::{Truth, TruthHandle};

/// A robot that has not come nearer by `NEARER_M` in this time is stuck, seconds.
const PATIENCE_S: f64 = 15.0;
const NEARER_M: f64 = 0.2;

/// Drives straight at the nearest door of its instruction, whatever is in the way, and declares
/// the delivery there. A robot that gets stuck gives up this door and tries the next one.
pub(super) struct StraightLine {
    handle: TruthHandle,
    robot: RobotDescription,
    errands: Errands,
    attempt: Option<Attempt>,
}

/// The way to a door.
struct Attempt {
    stop: Stop,
    goal: MapPoint,
    follower: Follower,
    /// Least distance to the door so far, metres, and when it was measured.
    nearest_m: f64,
    nearest_at: SimTime,
}

impl StraightLine {
    /// For an episode.
    pub(super) fn new(truth: &Truth<'_>) -> Self {
        Self {
            handle: truth.handle.clone(),
            robot: truth.prepared.robot.clone(),
            errands: Errands::of(truth),
            attempt: None,
        }
    }

    /// Begins to drive to the next door; an action if there is none.
    fn set_out(&mut self, from: MapPoint, now: SimTime) -> Option<Action> {
        let Some(stop) = self.errands.take_nearest(from) else {
            let detail = "no door is left";
            return Some(give_up(None, FailureCause::UnknownAddress, detail));
        };
        let Some(goal) = stop.approach else {
            let detail = "the door cannot be reached";
            return Some(give_up(Some(stop.address), FailureCause::NoRoute, detail));
        };
        self.attempt = Some(Attempt {
            stop,
            goal,
            follower: Follower::new([goal]),
            nearest_m: from.distance(goal),
            nearest_at: now,
        });
        None
    }
}

impl Attempt {
    /// Whether the robot has not come nearer for long.
    fn is_stuck(&mut self, here: MapPoint, now: SimTime) -> bool {
        let distance = here.distance(self.goal);
        if distance < self.nearest_m - NEARER_M {
            (self.nearest_m, self.nearest_at) = (distance, now);
        }
        now.since(self.nearest_at).as_secs_f64() > PATIENCE_S
    }
}

impl Agent for StraightLine {
    fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
        Ok(())
    }

    fn act(&mut self, observation: &Observation<'_>, _: &mut dyn Events) -> Action {
        let now = observation.time;
        let pose = self.handle.pose_at(now);
        if self.attempt.is_none()
            && let Some(action) = self.set_out(pose.point(), now)
        {
            return action;
        }
        let Some(attempt) = &mut self.attempt else {
            return Action::Drive(Velocity::ZERO);
        };
        let address = attempt.stop.address.clone();
        if attempt.is_stuck(pose.point(), now) {
            self.attempt = None;
            let detail = "something is in the way";
            return give_up(Some(address), FailureCause::Stuck, detail);
        }
        match attempt.follower.velocity(pose, &self.robot) {
            Some(velocity) => Action::Drive(velocity),
            None => {
                self.attempt = None;
                Action::Delivered(address)
            }
        }
    }
}
