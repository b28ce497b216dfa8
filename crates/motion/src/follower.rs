//! Pure pursuit (Coulter 1992): along a path, slower in bends and near the end, turning on the spot
//! where the path leads sideways, and standing still before anything in the robot's next second.

use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity, frames::wrap_angle};

use crate::checks::SettingsError;
use crate::limits::Limits;
use crate::local::{
    Blocked, LocalPlanner, PlannerEntry, Progress, Situation, ahead, planner_entry,
};
use crate::shape::{Footprint, Obstacle, ShapeError};

/// Distance along the path to the point that is steered for, metres.
const LOOKAHEAD_M: f64 = 0.6;
/// A point that is steered for counts as at least so far away, metres.
const NEAREST_M: f64 = 0.05;
/// Heading error above which the robot turns on the spot, radians.
const TURN_FIRST_RAD: f64 = 0.7;
/// Turn rate for each radian of heading error, 1/s.
const TURN_GAIN: f64 = 2.0;
/// Slowest turn on the spot, rad/s.
const LEAST_TURN_RADPS: f64 = 0.15;
/// By how much a curvature of 1/m makes the robot slower.
const BEND_FACTOR: f64 = 0.8;
/// Slowest approach to the end, m/s.
const LEAST_SPEED_MPS: f64 = 0.08;
/// Deceleration that is always possible, m/s².
const BRAKING_MPS2: f64 = 0.6;
/// Time over which the commanded motion must be free, seconds.
const HORIZON_S: f64 = 1.0;
/// Looks at that time.
const LOOKS: i32 = 10;
/// Distance from the inscribed circle to obstacles that is kept, metres.
const KEEP_M: f64 = 0.02;
/// A robot that is too near to an obstacle moves away if no look is nearer by more than this,
/// metres.
const AWAY_M: f64 = 0.005;
/// Shares of the wanted velocity that are tried where it is not free.
const SLOWER: [f64; 2] = [0.6, 0.3];

/// Its entry among the local planners.
pub fn entry() -> PlannerEntry {
    entry_with(Tolerance::default())
}

/// Its entry with another tolerance.
pub fn entry_with(tolerance: Tolerance) -> PlannerEntry {
    let about = "Pure pursuit that stops before obstacles";
    planner_entry("follower", about, move |settings| {
        let follower = Follower::new(settings.robot.clone())?;
        Ok(Box::new(follower.with_tolerance(tolerance)))
    })
}

/// A follower cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FollowerError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// How near to the end of a path the robot has arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Distance from the end, metres.
    pub distance: f64,
    /// Heading error there, radians.
    pub yaw: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            distance: 0.15,
            yaw: 0.08,
        }
    }
}

/// Pure pursuit with a look at the next second.
#[derive(Debug, Clone)]
pub struct Follower {
    robot: RobotDescription,
    tolerance: Tolerance,
}

impl Follower {
    /// A follower for a robot.
    pub fn new(robot: RobotDescription) -> Result<Self, FollowerError> {
        Limits::of(&robot)?;
        Footprint::of(&robot)?;
        Ok(Self {
            robot,
            tolerance: Tolerance::default(),
        })
    }

    /// The same with another tolerance.
    pub fn with_tolerance(self, tolerance: Tolerance) -> Self {
        Self { tolerance, ..self }
    }

    /// The velocity along the circle through the point that is steered for; `remaining` metres are
    /// left to the end of the path.
    fn pursue(&self, pose: Pose2, path: &[MapPoint], remaining: f64) -> Velocity {
        let target = ahead(path, pose.point(), LOOKAHEAD_M);
        let target = target.map_or(pose.point(), |target| target.point);
        let (forward, left) = pose.inverse_transform(target);
        let error = libm::atan2(left, forward);
        if error.abs() > TURN_FIRST_RAD {
            return self.turn(error);
        }
        let distance = libm::hypot(forward, left).max(NEAREST_M);
        // Of the circle that touches the robot's heading and passes through the target (Coulter
        // 1992).
        let curvature = 2.0 * left / (distance * distance);
        let for_bend = self.robot.max_forward / (1.0 + BEND_FACTOR * curvature.abs());
        // From v² = 2 a s: so fast that the robot can still stop at the end.
        let for_end = (2.0 * BRAKING_MPS2 * remaining).sqrt().max(LEAST_SPEED_MPS);
        let linear = self.robot.max_forward.min(for_bend).min(for_end);
        let turn = (linear * curvature).clamp(-self.robot.max_turn, self.robot.max_turn);
        Velocity::new(linear, turn)
    }

    /// Turns on the spot.
    fn turn(&self, error: f64) -> Velocity {
        let rate = (TURN_GAIN * error.abs())
            .max(LEAST_TURN_RADPS)
            .min(self.robot.max_turn);
        Velocity::new(0.0, rate.copysign(error))
    }

    /// The fastest share of a velocity whose next second stays clear of obstacles.
    fn secured(&self, situation: &Situation<'_>, wanted: Velocity) -> Result<Progress, Blocked> {
        let Some(at) = self.first_contact(situation, wanted) else {
            return Ok(Progress::Drive(wanted));
        };
        let mut last = at;
        for share in SLOWER {
            let slower = Velocity::new(wanted.linear * share, wanted.angular * share);
            match self.first_contact(situation, slower) {
                None => return Ok(Progress::Slowed(slower, Blocked::Obstacle(at))),
                Some(at) => last = at,
            }
        }
        Err(Blocked::Obstacle(last))
    }

    /// Distance driven with a velocity before the robot comes too close to an obstacle, metres.
    fn first_contact(&self, situation: &Situation<'_>, velocity: Velocity) -> Option<f64> {
        let reach = self.robot.inscribed_radius() + KEEP_M;
        let obstacles = situation.obstacles;
        let here = nearest_within(obstacles, situation.pose.point(), reach);
        let dt = HORIZON_S / f64::from(LOOKS);
        let mut pose = situation.pose;
        for i in 1..=LOOKS {
            let step = Pose2::new(velocity.linear * dt, 0.0, velocity.angular * dt);
            pose = pose.compose(step);
            let Some(there) = nearest_within(obstacles, pose.point(), reach) else {
                continue;
            };
            // From where it is too close already, the robot may move away.
            if here.is_none_or(|here| there < here - AWAY_M) {
                return Some(velocity.linear * dt * f64::from(i));
            }
        }
        None
    }
}

/// Distance from a point to the nearest obstacle, metres, if it is less than `reach`.
fn nearest_within(obstacles: &[Obstacle], point: MapPoint, reach: f64) -> Option<f64> {
    let distances = obstacles.iter().map(|o| o.distance_to(point));
    distances
        .filter(|distance| *distance < reach)
        .reduce(f64::min)
}

impl LocalPlanner for Follower {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let Situation {
            pose,
            path,
            final_yaw,
            ..
        } = *situation;
        let end = *path.last().ok_or(Blocked::NoPath)?;
        let to_end = pose.point().distance(end);
        if to_end <= self.tolerance.distance {
            let error = final_yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
            let arrived = error.abs() <= self.tolerance.yaw;
            return Ok(if arrived {
                Progress::Arrived
            } else {
                // Without a look ahead: a turn on the spot does not move the inscribed circle,
                // which is all that `secured` checks.
                Progress::Drive(self.turn(error))
            });
        }
        self.secured(situation, self.pursue(pose, path, to_end))
    }

    fn reset(&mut self) {}
}
