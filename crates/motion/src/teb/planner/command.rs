//! From the best band to a velocity: what is driven of it, so that the robot stands in time whatever comes.

use openbench_core::{Pose2, SimTime, Velocity};

use crate::evade::evade;
use crate::feasible::{Motion, clearance, conflict_before_stop};
use crate::local::{Blocked, Progress, Situation};
use crate::shape::Obstacle;
use crate::teb::band::Band;
use crate::teb::settings::Limits;
use crate::yielding::Ways;

use super::{SURE, TOO_LATE, Teb};

/// Seconds ahead that a velocity is taken from: the time until the next one and a little for what lags.
const COMMAND: f64 = 0.1;
/// Who is nearer than this may surprise, metres.
const ALERT: f64 = 1.5;
/// Looks ahead at whom one passes, and the seconds between them.
const PASSES: (usize, f64) = (20, 0.1);
/// Distance at which somebody is passed, at least, metres.
const CLEAR: f64 = 0.15;
/// Who stands near somebody who may surprise sets out once there was a way for so long, seconds.
const HESITATES: f64 = 0.5;
/// A robot whose rims are slower than this has all but stopped, m/s.
const ALL_BUT_STANDS: f64 = 0.2;
/// A robot that is slower than this need not brake gently, m/s.
const SLOW: f64 = 0.05;
/// A standing robot whose rims are told less than this does not set out, m/s.
const SETS_OUT: f64 = 0.01;
/// Shares of the deceleration with which a robot brakes that still has to turn.
const GENTLY: [f64; 2] = [0.25, 0.5];
/// Shares of speed and turn rate that are tried after that.
const SHARES: [(f64, f64); 4] = [(0.6, 0.6), (0.3, 0.3), (0.1, 0.1), (0.0, 1.0)];

impl Teb {
    pub(super) fn command(&self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        let Some(best) = self.candidates.first() else { return Err(Blocked::NoGap) };
        if let Some(at) = best.conflict.filter(|at| *at < TOO_LATE) {
            let distance = situation.pose.point().distance(best.band.pose_at(at).point());
            let (footprint, limits) = (&self.footprint, &self.limits);
            // Who lets people come to a standing robot does not run from them.
            let lets_come = self.settings.surprise.is_some();
            let away = if lets_come { None } else { evade(footprint, limits, situation) };
            let cause = Blocked::Obstacle(distance);
            return away.map(|velocity| Progress::Slowed(velocity, cause)).ok_or(cause);
        }
        self.secured(situation, wanted(&best.band, &self.limits), Some(&best.band))
    }

    /// A velocity, or as much of it as lets the robot stand, wherever it drives, before somebody near touches it who comes at it faster than foreseen.
    pub(super) fn wary(&self, situation: &Situation<'_>, wanted: Velocity, plan: Option<&Band>) -> Velocity {
        let Some(surprise) = self.settings.surprise else { return wanted };
        let (foot, circle) = (self.footprint.at(situation.pose), self.footprint.circumscribed());
        let most = |o: &Obstacle| {
            let near = o.contact(&foot, circle, 0.0, ALERT)?;
            let [vx, vy] = o.velocity();
            let towards = surprise - near.normal[0] * vx - near.normal[1] * vy;
            (towards > 0.0).then(|| stands_in_time(near.distance, towards, self.limits.acceleration))
        };
        let moving = situation.obstacles.iter().filter(|o| o.is_moving());
        let limits = moving.filter_map(|o| Some((o, most(o)?)));
        // To stop before somebody whom one can still pass is to stand in his way.
        let most = limits.filter(|(o, _)| !self.passes(o, situation, wanted, plan)).map(|(_, most)| most);
        let most = most.fold(f64::INFINITY, f64::min);
        let rim = wanted.linear.abs() + self.limits.half_track * wanted.angular.abs();
        let share = (most / rim.max(1e-9)).min(1.0);
        Velocity::new(share * wanted.linear, share * wanted.angular)
    }

    /// Whether somebody who goes on as he does comes near a robot that stands, but not one that drives on: along a band or, without one, as it is told.
    fn passes(
        &self,
        somebody: &Obstacle,
        situation: &Situation<'_>,
        command: Velocity,
        plan: Option<&Band>,
    ) -> bool {
        let off = |pose: Pose2, time: f64| {
            clearance(&self.footprint, std::iter::once(somebody), pose, time, CLEAR) >= CLEAR
        };
        let mut motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
        let mut times = (1..=PASSES.0).map(|i| i as f64 * PASSES.1);
        let goes_by = times.clone().all(|time| {
            motion.step(&self.limits, PASSES.1);
            off(plan.map_or(motion.pose, |band| band.pose_at(time)), time)
        });
        goes_by && times.any(|time| !off(situation.pose, time))
    }

    /// What was decided, unless the robot stands, or all but does, near somebody who may surprise and there has hardly been a way yet: one look may err, and who sets out a little and stops again stands in the way.
    pub(super) fn hesitate(
        &mut self,
        situation: &Situation<'_>,
        decided: Result<Progress, Blocked>,
    ) -> Result<Progress, Blocked> {
        if self.settings.surprise.is_none() {
            return decided;
        }
        let rim = |v: Velocity| v.linear.abs() + self.limits.half_track * v.angular.abs();
        let told = decided.ok().and_then(|decided| decided.velocity());
        self.free = told.filter(|v| rim(*v) > SETS_OUT).and(self.free.or(Some(situation.time)));
        let settled = |since: SimTime| situation.time.since(since).as_secs_f64() >= HESITATES;
        let all_but_stands = rim(situation.velocity) < ALL_BUT_STANDS;
        if decided.is_err()
            || !all_but_stands
            || self.free.is_some_and(settled)
            || !self.is_anybody_near(situation)
        {
            return decided;
        }
        Ok(Progress::Slowed(Velocity::ZERO, Blocked::Yielding))
    }

    fn is_anybody_near(&self, situation: &Situation<'_>) -> bool {
        let moving = situation.obstacles.iter().filter(|o| o.is_moving());
        clearance(&self.footprint, moving, situation.pose, 0.0, ALERT) < ALERT
    }

    /// What is wanted, or as near to it as lets the robot still stop before anything that stands.
    pub(super) fn secured(
        &self,
        situation: &Situation<'_>,
        wanted: Velocity,
        plan: Option<&Band>,
    ) -> Result<Progress, Blocked> {
        let planned = wanted;
        let wanted = self.wary(situation, wanted, plan);
        let (mut obstacle, mut yielding) = (None, wanted != planned);
        // What stands is the better reason: it does not go away.
        let cause =
            |obstacle: Option<Blocked>, yielding: bool| obstacle.or(yielding.then_some(Blocked::Yielding));
        for velocity in self.slower(situation.velocity, wanted) {
            let motion = Motion { pose: situation.pose, velocity: situation.velocity, command: velocity };
            let (foot, limits) = (&self.footprint, &self.limits);
            match conflict_before_stop(foot, situation.obstacles, motion, limits, COMMAND, SURE) {
                None if self.cuts_off(situation, velocity, plan.filter(|_| velocity == planned)) => {
                    yielding = true;
                }
                None => {
                    let slowed = cause(obstacle, yielding).map(|cause| Progress::Slowed(velocity, cause));
                    return Ok(slowed.unwrap_or(Progress::Drive(velocity)));
                }
                Some(at) => obstacle = obstacle.or(Some(Blocked::Obstacle(at * velocity.linear.abs()))),
            }
        }
        Err(cause(obstacle, yielding).unwrap_or(Blocked::NoGap))
    }

    /// Whether the robot gets into somebody's way if it is told this.
    pub(super) fn cuts_off(&self, situation: &Situation<'_>, command: Velocity, plan: Option<&Band>) -> bool {
        let Some(seconds) = self.settings.yields else { return false };
        let motion = Motion { pose: situation.pose, velocity: situation.velocity, command };
        let ways = Ways { footprint: &self.footprint, seconds };
        let mut moving = situation.obstacles.iter().filter(|o| o.is_moving());
        moving.any(|o| {
            ways.is_cut_off(o, motion, &self.limits, COMMAND) && !self.passes(o, situation, command, plan)
        })
    }

    /// A velocity, and slower ones, none of which stands where driving was wanted. Rims that brake as hard as they can cannot turn the robot too, so who is fast at first brakes gently and turns as it was to.
    fn slower(&self, now: Velocity, wanted: Velocity) -> impl Iterator<Item = Velocity> + use<> {
        let most = self.limits.acceleration * COMMAND;
        let gently = GENTLY.map(move |share| {
            let linear = now.linear - share * most.min(now.linear.abs()).copysign(now.linear);
            Velocity::new(linear.clamp(-wanted.linear.abs(), wanted.linear.abs()), wanted.angular)
        });
        let shares = SHARES.map(move |(v, w)| Velocity::new(v * wanted.linear, w * wanted.angular));
        let is_fast = now.linear.abs() > SLOW;
        let gently = gently.into_iter().filter(move |_| is_fast);
        let moves = move |v: &Velocity| v.linear.abs() > 1e-3 || v.angular.abs() > 1e-2 || *v == wanted;
        std::iter::once(wanted).chain(gently).chain(shares).filter(moves)
    }

    /// The last turn, once the robot stands where it should.
    pub(super) fn turn(&self, situation: &Situation<'_>, error: f64) -> Result<Progress, Blocked> {
        // As fast as it can still be stopped in time, with a third of what the wheels could do.
        let angular = self.limits.acceleration / self.limits.half_track / 3.0;
        let rate = (2.0 * angular * error.abs()).sqrt().min(4.0 * error.abs()).max(0.1).min(self.limits.turn);
        self.secured(situation, Velocity::new(0.0, rate.copysign(error)), None)
    }
}

/// The largest speed at which a robot comes to stand, after a command's time, within `distance` less what somebody comes nearer meanwhile: v² / 2a + v (w / a + T) + w T = d.
fn stands_in_time(distance: f64, towards: f64, acceleration: f64) -> f64 {
    let left = distance - towards * COMMAND;
    let late = towards / acceleration + COMMAND;
    if left > 0.0 { acceleration * ((late * late + 2.0 * left / acceleration).sqrt() - late) } else { 0.0 }
}

/// The velocity that leads to where the band has the robot next.
pub fn wanted(band: &Band, limits: &Limits) -> Velocity {
    let v = band.velocity_until(COMMAND);
    Velocity::new(
        v.linear.clamp(-limits.backward, limits.forward),
        v.angular.clamp(-limits.turn, limits.turn),
    )
}
