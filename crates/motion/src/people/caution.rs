//! Driving near people who may not do as predicted: slow enough to stop if they approach, off the
//! ground that they need, and without setting out hastily.

use openbench_core::{Pose2, SimTime, Velocity};

use super::right_of_way::RightOfWay;
use crate::feasible::clearance;
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::{Blocked, Progress, Situation};
use crate::shape::{Footprint, Obstacle, moving};
use crate::trajectory::COMMAND_S;
use crate::trajectory::Trajectory;

/// Moving obstacles within this distance may not do as predicted, metres.
const ALERT_M: f64 = 1.5;
/// Checks along a predicted encounter.
const PASS_CHECKS: usize = 20;
/// Seconds between them.
const PASS_STEP_S: f64 = 0.1;
/// Least distance at which somebody is passed, metres.
const CLEAR_M: f64 = 0.15;
/// A robot that stands near people sets out after it has had a free path for so long, seconds.
const HESITATION_S: f64 = 0.5;
/// A robot whose rims are slower than this almost stands, m/s.
const ALMOST_STANDS_MPS: f64 = 0.2;
/// A robot whose rims are commanded to be slower than this does not set out, m/s.
const SETS_OUT_MPS: f64 = 0.01;

/// How far people are trusted to go on as predicted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Caution<'a> {
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// What the robot can do.
    pub limits: &'a Limits,
    /// How much faster than predicted somebody may approach, m/s; people are trusted if `None`.
    pub approach_margin_mps: Option<f64>,
    /// Seconds that a walking person needs to stop; the robot does not yield if `None`.
    pub stopping_time_s: Option<f64>,
}

impl Caution<'_> {
    /// A velocity, or the share of it with which the robot stands, wherever it drives, before
    /// somebody near touches it who approaches faster than predicted. `plan` is the band that the
    /// velocity is taken from.
    pub(crate) fn slowed(
        &self,
        situation: &Situation<'_>,
        wanted: Velocity,
        plan: Option<&Trajectory>,
    ) -> Velocity {
        let Some(approach_margin_mps) = self.approach_margin_mps else {
            return wanted;
        };
        let mut most = f64::INFINITY;
        for somebody in moving(situation.obstacles) {
            let fastest = self.fastest_near(somebody, situation.pose, approach_margin_mps);
            // To stop before somebody whom the robot can still pass is to stand in their path.
            if let Some(fastest) = fastest
                && !self.passes(somebody, situation, wanted, plan)
            {
                most = most.min(fastest);
            }
        }
        // Speed and turn rate shrink alike, so that the robot stays on its arc.
        let share = (most / self.rim_speed(wanted).max(1e-9)).min(1.0);
        Velocity::new(share * wanted.linear, share * wanted.angular)
    }

    /// The largest speed of a rim, m/s, with which the robot stands when somebody touches it who
    /// approaches faster than predicted; `None` if they are too far or go away.
    fn fastest_near(
        &self,
        somebody: &Obstacle,
        pose: Pose2,
        approach_margin_mps: f64,
    ) -> Option<f64> {
        let (placed, circle) = (self.footprint.at(pose), self.footprint.circumscribed());
        let near = somebody.contact(&placed, circle, 0.0, ALERT_M)?;
        let velocity = somebody.velocity();
        // The normal points from the footprint to somebody, and who comes nearer moves against it.
        let towards = approach_margin_mps - near.normal.x * velocity.x - near.normal.y * velocity.y;
        (towards > 0.0).then(|| stands_in_time(near.distance, towards, self.limits.acceleration))
    }

    /// Whether somebody who goes on as predicted comes near a robot that stands, but not near one
    /// that drives on, along a band or, without one, as commanded.
    fn passes(
        &self,
        somebody: &Obstacle,
        situation: &Situation<'_>,
        command: Velocity,
        plan: Option<&Trajectory>,
    ) -> bool {
        let mut motion = Motion {
            pose: situation.pose,
            velocity: situation.velocity,
            command,
        };
        let mut times = (1..=PASS_CHECKS).map(|i| i as f64 * PASS_STEP_S);
        let goes_by = times.clone().all(|time| {
            motion.step(self.limits, PASS_STEP_S);
            self.keeps_off(
                somebody,
                plan.map_or(motion.pose, |band| band.pose_at(time)),
                time,
            )
        });
        // Somebody who would pass a standing robot by is no reason to drive on.
        goes_by && times.any(|time| !self.keeps_off(somebody, situation.pose, time))
    }

    /// Whether the robot at a pose keeps off somebody as they will be after `time` seconds.
    fn keeps_off(&self, somebody: &Obstacle, pose: Pose2, time: f64) -> bool {
        clearance(
            self.footprint,
            std::iter::once(somebody),
            pose,
            time,
            CLEAR_M,
        ) >= CLEAR_M
    }

    /// Whether the robot cuts somebody off if it is commanded this.
    pub(crate) fn cuts_off(
        &self,
        situation: &Situation<'_>,
        command: Velocity,
        plan: Option<&Trajectory>,
    ) -> bool {
        let Some(seconds) = self.stopping_time_s else {
            return false;
        };
        let motion = Motion {
            pose: situation.pose,
            velocity: situation.velocity,
            command,
        };
        let right_of_way = RightOfWay {
            footprint: self.footprint,
            seconds,
        };
        moving(situation.obstacles).any(|o| {
            right_of_way.is_cut_off(o, motion, self.limits, COMMAND_S)
                && !self.passes(o, situation, command, plan)
        })
    }

    /// Whether somebody is near enough not to do as predicted.
    fn is_anybody_near(&self, situation: &Situation<'_>) -> bool {
        let moving = moving(situation.obstacles);
        clearance(self.footprint, moving, situation.pose, 0.0, ALERT_M) < ALERT_M
    }

    /// The speed of the faster rim, m/s.
    fn rim_speed(&self, velocity: Velocity) -> f64 {
        velocity.linear.abs() + self.limits.half_track * velocity.angular.abs()
    }
}

/// The largest speed v with which a robot stands in time before somebody at distance d (m) who
/// approaches with w = `towards` (m/s). It goes on for the time T of a command and then brakes with
/// a (m/s²): v² / 2a + v (w / a + T) + w T = d.
fn stands_in_time(distance: f64, towards: f64, acceleration: f64) -> f64 {
    let left = distance - towards * COMMAND_S;
    let late = towards / acceleration + COMMAND_S;
    if left > 0.0 {
        // The positive root of the equation above.
        acceleration * ((late * late + 2.0 * left / acceleration).sqrt() - late)
    } else {
        0.0
    }
}

/// Whether a robot that stands near people has had a free path for long enough to set out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Hesitation {
    /// Since when there has been a free path.
    free_since: Option<SimTime>,
}

impl Hesitation {
    /// What was decided, unless the robot almost stands near people and has hardly had a free path
    /// yet. One estimate may be wrong, and a robot that sets out a little and stops again stands in
    /// the way.
    pub(crate) fn hold(
        &mut self,
        caution: &Caution<'_>,
        situation: &Situation<'_>,
        decided: Result<Progress, Blocked>,
    ) -> Result<Progress, Blocked> {
        if caution.approach_margin_mps.is_none() {
            return decided;
        }
        let commanded = decided.ok().and_then(|decided| decided.velocity());
        let sets_out = commanded.is_some_and(|velocity| caution.rim_speed(velocity) > SETS_OUT_MPS);
        // A single cycle without a free path starts the wait anew.
        self.free_since = sets_out.then(|| self.free_since.unwrap_or(situation.time));
        let almost_stands = caution.rim_speed(situation.velocity) < ALMOST_STANDS_MPS;
        let settled = self.is_settled(situation.time);
        if decided.is_err() || !almost_stands || settled || !caution.is_anybody_near(situation) {
            return decided;
        }
        Ok(Progress::Slowed(Velocity::ZERO, Blocked::Yielding))
    }

    fn is_settled(&self, now: SimTime) -> bool {
        self.free_since
            .is_some_and(|since| now.since(since).as_secs_f64() >= HESITATION_S)
    }

    /// Forgets that there was a free path.
    pub(crate) fn forget(&mut self) {
        self.free_since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_with_the_largest_speed_stands_when_somebody_reaches_it() {
        let (distance, towards, acceleration) = (0.8, 0.7, 1.0);
        let speed = stands_in_time(distance, towards, acceleration);
        let stops_after = COMMAND_S + speed / acceleration;
        let driven = speed * COMMAND_S + speed * speed / (2.0 * acceleration);
        assert!(
            (driven + towards * stops_after - distance).abs() < 1e-9,
            "{speed}"
        );
        assert_eq!(stands_in_time(0.05, towards, acceleration), 0.0);
    }
}
