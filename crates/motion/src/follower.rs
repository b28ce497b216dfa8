//! Driving along a way: pure pursuit (Coulter 1992), slower in bends and near the end, turning on the spot where the way
//! leads sideways, and standing still before anything the LiDAR sees in the robot's next second.

use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity, frames::wrap_angle};

use crate::local::{Blocked, LocalPlanner, Progress, Situation, ahead};
use crate::shape::{Footprint, ShapeError};
use crate::teb::settings::{Limits, SettingsError};

/// Distance along the way to the point that is steered for, metres.
const LOOKAHEAD: f64 = 0.6;
/// Heading error above which the robot turns on the spot, radians.
const TURN_FIRST: f64 = 0.7;
/// Deceleration that is always possible, m/s².
const BRAKING: f64 = 0.6;
/// Time over which the commanded motion must be free, seconds.
const HORIZON: f64 = 1.0;

/// A follower cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FollowerError {
    /// A limit makes no sense.
    #[error(transparent)]
    Limits(#[from] SettingsError),
    /// The footprint is none.
    #[error(transparent)]
    Footprint(#[from] ShapeError),
}

/// Pure pursuit with a look at the next second.
#[derive(Debug, Clone)]
pub struct Follower {
    robot: RobotDescription,
    /// Distance from the end at which the robot has arrived, metres.
    tolerance: f64,
    /// Heading error at the end with which the robot has arrived, radians.
    yaw_tolerance: f64,
}

impl Follower {
    /// A follower for a robot.
    pub fn new(robot: RobotDescription) -> Result<Self, FollowerError> {
        Limits::of(&robot)?;
        Footprint::of(&robot)?;
        Ok(Self { robot, tolerance: 0.15, yaw_tolerance: 0.08 })
    }

    /// Another distance from the end, metres, and heading error there, radians, with which the robot has arrived.
    pub fn with_tolerances(self, tolerance: f64, yaw_tolerance: f64) -> Self {
        Self { tolerance, yaw_tolerance, ..self }
    }

    fn pursue(&self, pose: Pose2, path: &[MapPoint], remaining: f64) -> Velocity {
        let target = ahead(path, pose.point(), LOOKAHEAD).map_or(pose.point(), |(point, _)| point);
        let (forward, left) = pose.inverse_transform(target);
        let error = libm::atan2(left, forward);
        if error.abs() > TURN_FIRST {
            return self.turn(error);
        }
        let distance = libm::hypot(forward, left).max(0.05);
        let curvature = 2.0 * left / (distance * distance);
        let for_bend = self.robot.max_forward / (1.0 + 0.8 * curvature.abs());
        let for_end = (2.0 * BRAKING * remaining).sqrt().max(0.08);
        let linear = self.robot.max_forward.min(for_bend).min(for_end);
        Velocity::new(linear, (linear * curvature).clamp(-self.robot.max_turn, self.robot.max_turn))
    }

    fn turn(&self, error: f64) -> Velocity {
        let rate = (2.0 * error.abs()).max(0.15).min(self.robot.max_turn);
        Velocity::new(0.0, rate.copysign(error))
    }

    /// The fastest share of `wanted` whose next second stays clear of obstacles.
    fn secured(&self, pose: Pose2, near: Near<'_>, wanted: Velocity) -> Result<Progress, Blocked> {
        let Some(at) = self.first_contact(pose, near, wanted) else { return Ok(Progress::Drive(wanted)) };
        let mut last = at;
        for share in [0.6, 0.3] {
            let free = Velocity::new(wanted.linear * share, wanted.angular * share);
            match self.first_contact(pose, near, free) {
                None => return Ok(Progress::Slowed(free, Blocked::Obstacle(at))),
                Some(at) => last = at,
            }
        }
        Err(Blocked::Obstacle(last))
    }

    /// Distance driven before the robot's hull, at its wanted velocity, comes too close to an obstacle.
    fn first_contact(&self, pose: Pose2, near: Near<'_>, velocity: Velocity) -> Option<f64> {
        let reach = self.robot.inscribed_radius() + 0.02;
        let here = near(pose.point(), reach);
        let steps = 10;
        let dt = HORIZON / f64::from(steps);
        let mut pose = pose;
        for i in 1..=steps {
            pose = pose.compose(Pose2::new(velocity.linear * dt, 0.0, velocity.angular * dt));
            if let Some(distance) = near(pose.point(), reach) {
                // Already too close: moving away is allowed.
                if here.is_none_or(|h| distance < h - 0.005) {
                    return Some(velocity.linear * dt * f64::from(i));
                }
            }
        }
        None
    }

    fn decide(
        &self,
        pose: Pose2,
        path: &[MapPoint],
        final_yaw: Option<f64>,
        near: Near<'_>,
    ) -> Result<Progress, Blocked> {
        let end = *path.last().ok_or(Blocked::NoPath)?;
        let to_end = pose.point().distance(end);
        if to_end <= self.tolerance {
            let error = final_yaw.map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
            let arrived = error.abs() <= self.yaw_tolerance;
            return Ok(if arrived { Progress::Arrived } else { Progress::Drive(self.turn(error)) });
        }
        self.secured(pose, near, self.pursue(pose, path, to_end))
    }
}

/// Distance from a point to the nearest obstacle, if it is within so many metres.
type Near<'a> = &'a dyn Fn(MapPoint, f64) -> Option<f64>;

impl LocalPlanner for Follower {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let near = |point: MapPoint, reach: f64| {
            let distances = situation.obstacles.iter().map(|o| o.distance_to(point));
            distances.filter(|d| *d < reach).reduce(f64::min)
        };
        self.decide(situation.pose, situation.path, situation.final_yaw, &near)
    }

    fn reset(&mut self) {}
}
