//! What the robot drives during an action.

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::follower::{Follower, Tolerance};
use openbench_motion::local::{LocalPlanner, Situation};

use crate::error::EnvironmentError;
use crate::options::Actions;

/// A waypoint is reached within this distance, at any heading, metres.
const REACHED_M: f64 = 0.05;

/// What turns waypoints into velocities; `None` where actions are velocities.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tracker(Option<Follower>);

/// What the robot drives during an action.
pub(crate) struct Course<'a> {
    tracker: &'a mut Tracker,
    /// In `map`.
    path: [MapPoint; 2],
    velocity: Velocity,
}

impl Tracker {
    /// For a robot and what actions are.
    pub(crate) fn new(
        actions: Actions,
        robot: &RobotDescription,
    ) -> Result<Self, EnvironmentError> {
        if actions == Actions::Velocity {
            return Ok(Self(None));
        }
        let tolerance = Tolerance {
            distance: REACHED_M,
            yaw: std::f64::consts::PI,
        };
        let follower = Follower::new(robot.clone()).map_err(|error| EnvironmentError::Option {
            option: "actions",
            problem: error.to_string(),
        })?;
        Ok(Self(Some(follower.with_tolerance(tolerance))))
    }

    /// The course of an action that begins at the pose where the robot takes itself to be.
    pub(crate) fn course(&mut self, action: [f64; 2], pose: Option<Pose2>) -> Course<'_> {
        let [first, second] = action;
        let pose = pose.unwrap_or_default();
        Course {
            path: [pose.point(), pose.transform(first, second)],
            velocity: match self.0 {
                Some(_) => Velocity::ZERO,
                None => Velocity::new(first, second),
            },
            tracker: self,
        }
    }
}

impl Course<'_> {
    /// The velocity of the next step.
    pub(crate) fn velocity(&mut self, time: SimTime, pose: Option<Pose2>) -> Velocity {
        let Some(follower) = &mut self.tracker.0 else {
            return self.velocity;
        };
        let situation = Situation {
            time,
            pose: pose.unwrap_or_default(),
            velocity: self.velocity,
            path: &self.path,
            final_yaw: None,
            obstacles: &[],
        };
        // Arrived, or a waypoint so far away that it is none: it stands.
        let progress = follower.plan(&situation).ok();
        let wanted = progress.and_then(|progress| progress.velocity());
        self.velocity = wanted.unwrap_or_default();
        self.velocity
    }
}

#[cfg(test)]
mod tests {
    use openbench_motion::kinematics::arc;

    use super::*;

    #[test]
    fn a_waypoint_is_driven_to_and_waited_at() {
        let robot = RobotDescription::sentry();
        let mut tracker = Tracker::new(Actions::Waypoint, &robot).unwrap();
        let mut pose = Pose2::new(10.0, -4.0, 2.0);
        let goal = pose.transform(1.0, 0.8);
        let mut course = tracker.course([1.0, 0.8], Some(pose));
        let mut velocity = Velocity::ZERO;
        for step in 0..200 {
            velocity = course.velocity(SimTime::from_millis(50 * step), Some(pose));
            pose = arc(pose, velocity, 0.05);
        }
        assert_eq!(velocity, Velocity::ZERO);
        assert!(pose.point().distance(goal) < 2.0 * REACHED_M, "{pose:?}");
    }

    #[test]
    fn a_velocity_stays_what_it_is() {
        let robot = RobotDescription::sentry();
        let mut tracker = Tracker::new(Actions::Velocity, &robot).unwrap();
        let mut course = tracker.course([0.3, -0.2], None);
        for step in 0..3 {
            let velocity = course.velocity(SimTime::from_millis(50 * step), None);
            assert_eq!(velocity, Velocity::new(0.3, -0.2));
        }
    }
}
