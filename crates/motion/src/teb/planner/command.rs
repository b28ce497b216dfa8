//! From the best band to a velocity: what is driven of it, so that the robot stands in time whatever comes.

use openbench_core::Velocity;

use crate::feasible::conflict_before_stop;
use crate::kinematics::Motion;
use crate::local::{Blocked, Progress, Situation};
use crate::people::caution::Caution;
use crate::recovery::evade::evade;
use crate::trajectory::Band;
use crate::trajectory::band::COMMAND;

use super::{SURE, TOO_LATE, Teb};

/// A robot that is slower than this need not brake gently, m/s.
const SLOW: f64 = 0.05;
/// Shares of the deceleration with which a robot brakes that still has to turn.
const GENTLY: [f64; 2] = [0.25, 0.5];
/// Shares of speed and turn rate that are tried after that.
const SHARES: [(f64, f64); 4] = [(0.6, 0.6), (0.3, 0.3), (0.1, 0.1), (0.0, 1.0)];

impl Teb {
    /// How far people are trusted.
    pub(super) fn caution(&self) -> Caution<'_> {
        let (surprise, yields) = (self.settings.surprise, self.settings.yields);
        Caution { footprint: &self.footprint, limits: &self.limits, surprise, yields }
    }

    /// What was decided, unless a robot that stands near people has hardly had a way yet.
    pub(super) fn hesitate(
        &mut self,
        situation: &Situation<'_>,
        decided: Result<Progress, Blocked>,
    ) -> Result<Progress, Blocked> {
        let mut hesitation = self.hesitation;
        let decided = hesitation.hold(&self.caution(), situation, decided);
        self.hesitation = hesitation;
        decided
    }

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
        self.secured(situation, best.band.command(&self.limits), Some(&best.band))
    }

    /// What is wanted, or as near to it as lets the robot still stop before anything that stands.
    pub(super) fn secured(
        &self,
        situation: &Situation<'_>,
        wanted: Velocity,
        plan: Option<&Band>,
    ) -> Result<Progress, Blocked> {
        let planned = wanted;
        let wanted = self.caution().slowed(situation, wanted, plan);
        let (mut obstacle, mut yielding) = (None, wanted != planned);
        // What stands is the better reason: it does not go away.
        let cause =
            |obstacle: Option<Blocked>, yielding: bool| obstacle.or(yielding.then_some(Blocked::Yielding));
        for velocity in self.slower(situation.velocity, wanted) {
            let motion = Motion { pose: situation.pose, velocity: situation.velocity, command: velocity };
            let (foot, limits) = (&self.footprint, &self.limits);
            match conflict_before_stop(foot, situation.obstacles, motion, limits, COMMAND, SURE) {
                None if self.caution().cuts_off(
                    situation,
                    velocity,
                    plan.filter(|_| velocity == planned),
                ) =>
                {
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
