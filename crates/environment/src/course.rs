//! What the robot drives during an action.

use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::follower::{Follower, Tolerance};
use openbench_motion::local::{LocalPlanner, Situation};

use crate::error::EnvironmentError;
use crate::options::Actions;

/// A waypoint is reached within this distance, at any heading, metres.
const REACHED_M: f64 = 0.05;

/// What the robot drives during an action.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    /// What turns waypoints into velocities; `None` where actions are velocities.
    tracker: Option<Follower>,
    /// To the waypoint of the last action, in `map`.
    path: [MapPoint; 2],
    velocity: Velocity,
}

impl Course {
    /// Stands, until an action begins.
    pub(crate) fn new(
        actions: Actions,
        robot: &RobotDescription,
    ) -> Result<Self, EnvironmentError> {
        let tracker = match actions {
            Actions::Velocity => None,
            Actions::Waypoint => Some(tracker(robot)?),
        };
        Ok(Self {
            tracker,
            path: [MapPoint::default(); 2],
            velocity: Velocity::ZERO,
        })
    }

    /// Begins an action at the pose where the robot takes itself to be.
    pub(crate) fn begin(&mut self, action: [f64; 2], pose: Pose2) {
        let [first, second] = action;
        self.path = [pose.point(), pose.transform(first, second)];
        self.velocity = match self.tracker {
            Some(_) => Velocity::ZERO,
            None => Velocity::new(first, second),
        };
    }

    /// The velocity of the next step.
    pub(crate) fn velocity(&mut self, time: SimTime, pose: Pose2) -> Velocity {
        let Some(follower) = &mut self.tracker else {
            return self.velocity;
        };
        let situation = Situation {
            time,
            pose,
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

fn tracker(robot: &RobotDescription) -> Result<Follower, EnvironmentError> {
    let tolerance = Tolerance {
        distance: REACHED_M,
        yaw: std::f64::consts::PI,
    };
    let follower = Follower::new(robot.clone()).map_err(|error| EnvironmentError::Option {
        option: "actions",
        problem: error.to_string(),
    })?;
    Ok(follower.with_tolerance(tolerance))
}

#[cfg(test)]
mod tests {
    use openbench_motion::kinematics::arc;

    use super::*;

    #[test]
    fn a_waypoint_is_driven_to_and_waited_at() {
        let robot = RobotDescription::sentry();
        let mut course = Course::new(Actions::Waypoint, &robot).unwrap();
        let mut pose = Pose2::new(10.0, -4.0, 2.0);
        let goal = pose.transform(1.0, 0.8);
        course.begin([1.0, 0.8], pose);
        let mut velocity = Velocity::ZERO;
        for step in 0..200 {
            velocity = course.velocity(SimTime::from_millis(50 * step), pose);
            pose = arc(pose, velocity, 0.05);
        }
        assert_eq!(velocity, Velocity::ZERO);
        assert!(pose.point().distance(goal) < 2.0 * REACHED_M, "{pose:?}");
    }

    #[test]
    fn a_velocity_stays_what_it_is() {
        let robot = RobotDescription::sentry();
        let mut course = Course::new(Actions::Velocity, &robot).unwrap();
        course.begin([0.3, -0.2], Pose2::default());
        for step in 0..3 {
            let velocity = course.velocity(SimTime::from_millis(50 * step), Pose2::default());
            assert_eq!(velocity, Velocity::new(0.3, -0.2));
        }
    }
}
