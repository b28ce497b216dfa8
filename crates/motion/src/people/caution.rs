//! Driving near people who may not do as predicted: slow enough to stand when they get here, out of what is theirs, and not hastily.

use openbench_core::{Pose2, SimTime, Velocity};

use super::yielding::Ways;
use crate::feasible::clearance;
use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::local::{Blocked, Progress, Situation};
use crate::shape::{Footprint, Obstacle};
use crate::trajectory::Band;
use crate::trajectory::band::COMMAND;

/// Who is nearer than this may surprise, metres.
const ALERT: f64 = 1.5;
/// Looks ahead at whom one passes.
const PASS_LOOKS: usize = 20;
/// Seconds between them.
const PASS_STEP: f64 = 0.1;
/// Distance at which somebody is passed, at least, metres.
const CLEAR: f64 = 0.15;
/// Who stands near somebody who may surprise sets out once there was a way for so long, seconds.
const HESITATES: f64 = 0.5;
/// A robot whose rims are slower than this has all but stopped, m/s.
const ALL_BUT_STANDS: f64 = 0.2;
/// A standing robot whose rims are told less than this does not set out, m/s.
const SETS_OUT: f64 = 0.01;

/// How far people are trusted to go on as they do.
#[derive(Debug, Clone, Copy)]
pub struct Caution<'a> {
    /// The robot's outline.
    pub footprint: &'a Footprint,
    /// What the robot can do.
    pub limits: &'a Limits,
    /// How much faster than predicted somebody may come at the robot, m/s; people are trusted if none.
    pub surprise: Option<f64>,
    /// Seconds that somebody who walks needs to stop; the robot does not yield if none.
    pub yields: Option<f64>,
}

impl Caution<'_> {
    /// A velocity, or as much of it as lets the robot stand, wherever it drives, before somebody near touches it who comes at it faster than foreseen.
    pub fn slowed(&self, situation: &Situation<'_>, wanted: Velocity, plan: Option<&Band>) -> Velocity {
        let Some(surprise) = self.surprise else { return wanted };
        let moving = situation.obstacles.iter().filter(|o| o.is_moving());
        let limits = moving.filter_map(|o| Some((o, self.fastest_near(o, situation.pose, surprise)?)));
        // To stop before somebody whom one can still pass is to stand in his way.
        let most = limits.filter(|(o, _)| !self.passes(o, situation, wanted, plan)).map(|(_, most)| most);
        let most = most.fold(f64::INFINITY, f64::min);
        let share = (most / self.rim_speed(wanted).max(1e-9)).min(1.0);
        Velocity::new(share * wanted.linear, share * wanted.angular)
    }

    /// The fastest that a rim may be, m/s, for the robot to stand when somebody touches it who comes faster than foreseen; `None` if he is too far or goes away.
    fn fastest_near(&self, somebody: &Obstacle, pose: Pose2, surprise: f64) -> Option<f64> {
        let (placed, circle) = (self.footprint.at(pose), self.footprint.circumscribed());
        let near = somebody.contact(&placed, circle, 0.0, ALERT)?;
        let velocity = somebody.velocity();
        let towards = surprise - near.normal.x * velocity.x - near.normal.y * velocity.y;
        (towards > 0.0).then(|| stands_in_time(near.distance, towards, self.limits.acceleration))
    }

    /// Whether somebody who goes on as he does comes near a robot that stands, but not one that drives on: along a band or, without one, as it is told.
    fn passes(
        &self,
        somebody: &Obstacle,
        situation: &Situation<'_>,
        command: Velocity,
        plan: Option<&Band>,
    ) -> bool {
        let mut motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
        let mut times = (1..=PASS_LOOKS).map(|i| i as f64 * PASS_STEP);
        let goes_by = times.clone().all(|time| {
            motion.step(self.limits, PASS_STEP);
            self.keeps_off(somebody, plan.map_or(motion.pose, |band| band.pose_at(time)), time)
        });
        goes_by && times.any(|time| !self.keeps_off(somebody, situation.pose, time))
    }

    fn keeps_off(&self, somebody: &Obstacle, pose: Pose2, time: f64) -> bool {
        clearance(self.footprint, std::iter::once(somebody), pose, time, CLEAR) >= CLEAR
    }

    /// Whether the robot gets into somebody's way if it is told this.
    pub fn cuts_off(&self, situation: &Situation<'_>, command: Velocity, plan: Option<&Band>) -> bool {
        let Some(seconds) = self.yields else { return false };
        let motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
        let ways = Ways { footprint: self.footprint, seconds };
        let mut moving = situation.obstacles.iter().filter(|o| o.is_moving());
        moving.any(|o| {
            ways.is_cut_off(o, motion, self.limits, COMMAND) && !self.passes(o, situation, command, plan)
        })
    }

    fn is_anybody_near(&self, situation: &Situation<'_>) -> bool {
        let moving = situation.obstacles.iter().filter(|o| o.is_moving());
        clearance(self.footprint, moving, situation.pose, 0.0, ALERT) < ALERT
    }

    /// How fast the faster rim is, m/s.
    fn rim_speed(&self, velocity: Velocity) -> f64 {
        velocity.linear.abs() + self.limits.half_track * velocity.angular.abs()
    }
}

/// The largest speed at which a robot comes to stand, after a command's time, within `distance` less what somebody comes nearer meanwhile: v² / 2a + v (w / a + T) + w T = d.
fn stands_in_time(distance: f64, towards: f64, acceleration: f64) -> f64 {
    let left = distance - towards * COMMAND;
    let late = towards / acceleration + COMMAND;
    if left > 0.0 { acceleration * ((late * late + 2.0 * left / acceleration).sqrt() - late) } else { 0.0 }
}

/// Whether a robot that stands near people has had a way for long enough to set out.
#[derive(Debug, Clone, Copy, Default)]
pub struct Hesitation {
    /// Since when there has been a way to drive.
    free_since: Option<SimTime>,
}

impl Hesitation {
    /// What was decided, unless the robot stands, or all but does, near somebody who may surprise and there has hardly been a way yet: one look may err, and who sets out a little and stops again stands in the way.
    pub fn hold(
        &mut self,
        caution: &Caution<'_>,
        situation: &Situation<'_>,
        decided: Result<Progress, Blocked>,
    ) -> Result<Progress, Blocked> {
        if caution.surprise.is_none() {
            return decided;
        }
        let told = decided.ok().and_then(|decided| decided.velocity());
        let sets_out = told.is_some_and(|velocity| caution.rim_speed(velocity) > SETS_OUT);
        self.free_since = sets_out.then(|| self.free_since.unwrap_or(situation.time));
        let all_but_stands = caution.rim_speed(situation.velocity) < ALL_BUT_STANDS;
        let settled = self.is_settled(situation.time);
        if decided.is_err() || !all_but_stands || settled || !caution.is_anybody_near(situation) {
            return decided;
        }
        Ok(Progress::Slowed(Velocity::ZERO, Blocked::Yielding))
    }

    fn is_settled(&self, now: SimTime) -> bool {
        self.free_since.is_some_and(|since| now.since(since).as_secs_f64() >= HESITATES)
    }

    /// Forgets that there was a way.
    pub fn forget(&mut self) {
        self.free_since = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_brakes_at_that_speed_stands_when_the_other_is_there() {
        let (distance, towards, acceleration) = (0.8, 0.7, 1.0);
        let speed = stands_in_time(distance, towards, acceleration);
        let stops_after = COMMAND + speed / acceleration;
        let driven = speed * COMMAND + speed * speed / (2.0 * acceleration);
        assert!((driven + towards * stops_after - distance).abs() < 1e-9, "{speed}");
        assert_eq!(stands_in_time(0.05, towards, acceleration), 0.0);
    }
}
