//! What the robot knows of itself and what is around it.

use openbench_core::{MapPoint, Pose2, SimTime, Velocity};

use crate::local::Situation;
use crate::shape::Obstacle;

/// Moving obstacles within this distance are near, metres.
const NEAR_M: f64 = 2.0;

/// What the robot knows of itself and its surroundings.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// Now.
    pub time: SimTime,
    /// The robot's estimated pose in `map`.
    pub pose: Pose2,
    /// Its estimated velocity.
    pub velocity: Velocity,
    /// What stands or moves within some metres, where it is now.
    pub obstacles: &'a [Obstacle],
}

impl<'a> Surroundings<'a> {
    /// Whether somebody moves within two metres of the robot.
    pub(crate) fn is_anybody_near(&self) -> bool {
        let here = self.pose.point();
        self.obstacles
            .iter()
            .any(|o| o.is_moving() && o.distance_to(here) < NEAR_M)
    }

    /// Whether anybody moves, however far away.
    pub(crate) fn has_anybody(&self) -> bool {
        self.obstacles.iter().any(Obstacle::is_moving)
    }

    /// The situation of a local planner with a path.
    pub(crate) fn situation<'b>(
        &self,
        path: &'b [MapPoint],
        final_yaw: Option<f64>,
    ) -> Situation<'b>
    where
        'a: 'b,
    {
        let Self {
            time,
            pose,
            velocity,
            obstacles,
        } = *self;
        Situation {
            time,
            pose,
            velocity,
            path,
            final_yaw,
            obstacles,
        }
    }
}
