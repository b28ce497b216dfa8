//! From the best band to a velocity with which the robot can stop in time.

use openbench_core::Velocity;

use crate::kinematics::Motion;
use crate::local::{Blocked, Progress, Situation};
use crate::people::caution::Caution;
use crate::recovery::evade::evade;
use crate::trajectory::COMMAND_S;
use crate::trajectory::Trajectory;

use super::{SURE_M, TOO_LATE_S, Teb};

/// A robot that is slower than this need not brake gently, m/s.
const SLOW_MPS: f64 = 0.05;
/// Shares of the deceleration with which a robot brakes that still has to turn.
const GENTLY: [f64; 2] = [0.25, 0.5];
/// Shares of the speed and of the turn rate that are tried after that.
const SHARES: [(f64, f64); 4] = [(0.6, 0.6), (0.3, 0.3), (0.1, 0.1), (0.0, 1.0)];
/// A slower command that is slower than this, m/s,
const LEAST_MPS: f64 = 1e-3;
/// and turns slower than this, rad/s, does not move the robot.
const LEAST_RADPS: f64 = 1e-2;
/// Turn rate for each radian of heading error, 1/s.
const TURN_GAIN: f64 = 4.0;
/// Slowest last turn, rad/s.
const LEAST_TURN_RADPS: f64 = 0.1;

/// Why a velocity is lower than planned.
#[derive(Default)]
struct Causes {
    obstacle: Option<Blocked>,
    yielding: bool,
}

impl Causes {
    /// The main cause: a standing obstacle, since it does not go away.
    fn main(&self) -> Option<Blocked> {
        self.obstacle.or(self.yielding.then_some(Blocked::Yielding))
    }
}

impl Teb {
    /// How far people are trusted.
    pub(super) fn caution(&self) -> Caution<'_> {
        let (approach_margin_mps, stopping_time_s) = (
            self.settings.approach_margin_mps,
            self.settings.stopping_time_s,
        );
        Caution {
            footprint: &self.footprint,
            limits: &self.limits,
            approach_margin_mps,
            stopping_time_s,
        }
    }

    /// What was decided, unless a robot that stands near people has hardly had a free path yet.
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

    /// The velocity along the best band. If that meets an obstacle soon, the robot stops or evades.
    pub(super) fn command(&self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        let Some(best) = self.candidates.first() else {
            return Err(Blocked::NoGap);
        };
        let Some(at) = best.conflict.filter(|at| *at < TOO_LATE_S) else {
            let wanted = best.band.command(&self.limits);
            return self.secured(situation, wanted, Some(&best.band));
        };
        let distance = situation
            .pose
            .point()
            .distance(best.band.pose_at(at).point());
        let cause = Blocked::Obstacle(distance);
        // A robot that is cautious of people stands and does not run from them.
        if self.settings.approach_margin_mps.is_some() {
            return Err(cause);
        }
        let away = evade(&self.footprint, &self.limits, situation);
        away.map(|velocity| Progress::Slowed(velocity, cause))
            .ok_or(cause)
    }

    /// The wanted velocity, or one as near to it as possible with which the robot can still stop
    /// before any standing obstacle and cuts nobody off. `plan` is the band that it is taken from.
    pub(super) fn secured(
        &self,
        situation: &Situation<'_>,
        planned: Velocity,
        plan: Option<&Trajectory>,
    ) -> Result<Progress, Blocked> {
        let caution = self.caution();
        let wanted = caution.slowed(situation, planned, plan);
        let mut causes = Causes {
            obstacle: None,
            yielding: wanted != planned,
        };
        for velocity in self.slower(situation.velocity, wanted) {
            if let Some(at) = self.cannot_stop(situation, velocity) {
                // Reported for the fastest velocity that was tried: that is what the robot wanted
                // to do.
                let ahead = Blocked::Obstacle(at * velocity.linear.abs());
                causes.obstacle = causes.obstacle.or(Some(ahead));
                continue;
            }
            // A slower robot is not where the band says it is, and is predicted by its command.
            let followed = plan.filter(|_| velocity == planned);
            if caution.cuts_off(situation, velocity, followed) {
                causes.yielding = true;
                continue;
            }
            let slowed = causes.main().map(|cause| Progress::Slowed(velocity, cause));
            return Ok(slowed.unwrap_or(Progress::Drive(velocity)));
        }
        Err(causes.main().unwrap_or(Blocked::NoGap))
    }

    /// Seconds until the robot meets a standing obstacle that it cannot stop before.
    fn cannot_stop(&self, situation: &Situation<'_>, command: Velocity) -> Option<f64> {
        let Situation {
            pose,
            velocity,
            obstacles,
            ..
        } = *situation;
        let motion = Motion {
            pose,
            velocity,
            command,
        };
        self.check(obstacles, SURE_M)
            .conflict_before_stop(motion, COMMAND_S)
    }

    /// A velocity, and slower ones that still move the robot if it does.
    ///
    /// Rims that brake as hard as they can do not turn the robot, so a fast robot first tries to
    /// brake gently and to turn as wanted.
    fn slower(&self, now: Velocity, wanted: Velocity) -> impl Iterator<Item = Velocity> + use<> {
        let most = self.limits.acceleration * COMMAND_S;
        let gently = GENTLY.map(move |share| {
            // No harder than to standing, and no faster than wanted.
            let linear = now.linear - share * most.min(now.linear.abs()).copysign(now.linear);
            let fastest = wanted.linear.abs();
            Velocity::new(linear.clamp(-fastest, fastest), wanted.angular)
        });
        let is_fast = now.linear.abs() > SLOW_MPS;
        let gently = gently.into_iter().filter(move |_| is_fast);
        let shares = SHARES.map(move |(v, w)| Velocity::new(v * wanted.linear, w * wanted.angular));
        let moves = move |v: &Velocity| {
            // A standstill is offered only if it is wanted: otherwise the cause is reported.
            v.linear.abs() > LEAST_MPS || v.angular.abs() > LEAST_RADPS || *v == wanted
        };
        std::iter::once(wanted)
            .chain(gently)
            .chain(shares)
            .filter(moves)
    }

    /// The last turn by a heading error (radians), once the robot is at the end of the path.
    pub(super) fn turn(&self, situation: &Situation<'_>, error: f64) -> Result<Progress, Blocked> {
        // So fast that it can still be stopped in time with a third of the wheels' acceleration.
        let braking = self.limits.acceleration / self.limits.half_track / 3.0;
        let rate = (2.0 * braking * error.abs())
            .sqrt()
            .min(TURN_GAIN * error.abs());
        let rate = rate.max(LEAST_TURN_RADPS).min(self.limits.turn);
        self.secured(situation, Velocity::new(0.0, rate.copysign(error)), None)
    }
}
