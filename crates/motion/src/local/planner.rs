//! The trait of local planners, with its input and its output.

use openbench_core::{MapPoint, Pose2, SimTime, Velocity};

use crate::shape::Obstacle;

/// Metres, radians, m/s and rad/s from here on are no numbers of a robot on the Earth.
const IMPOSSIBLE: f64 = 1e8;

/// The input of a local planner.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// Now.
    pub time: SimTime,
    /// The robot's estimated pose in `map`.
    pub pose: Pose2,
    /// Its estimated velocity.
    pub velocity: Velocity,
    /// The path to follow, in `map`; it begins near the robot.
    pub path: &'a [MapPoint],
    /// Heading at the end of the path, radians; any if `None`.
    pub final_yaw: Option<f64>,
    /// Standing and moving obstacles within some metres, where they are now.
    pub obstacles: &'a [Obstacle],
}

/// The output of a local planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// Drive on with this velocity.
    Drive(Velocity),
    /// Drive on with this velocity, slower than the path alone would allow, for this cause.
    Slowed(Velocity, Blocked),
    /// The end of the path is reached, heading included.
    Arrived,
}

impl Progress {
    /// The velocity to drive on with, unless the robot has arrived.
    pub fn velocity(&self) -> Option<Velocity> {
        match self {
            Self::Drive(velocity) | Self::Slowed(velocity, _) => Some(*velocity),
            Self::Arrived => None,
        }
    }
}

/// Why a local planner does not drive on, or not as fast as it could. Where it does not, the robot
/// should stand until it does.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Blocked {
    /// The path is empty or contains NaN, infinity or an impossible number.
    #[error("there is no path to follow: it is empty or contains NaN or infinity")]
    NoPath,
    /// The pose or velocity contains NaN, infinity or an impossible number.
    #[error("the robot's pose is unknown: its pose or velocity contains NaN or infinity")]
    NoPose,
    /// An obstacle stands in the path, this many metres ahead.
    #[error("an obstacle stands {0:.2} m ahead")]
    Obstacle(f64),
    /// No gap that the footprint fits through leads on.
    #[error("no gap that the footprint fits through leads on")]
    NoGap,
    /// An obstacle is so near that the robot has to move away from it first.
    #[error("an obstacle is in near contact")]
    Touching,
    /// A moving obstacle may come there.
    #[error("a person nearby may walk into the robot's path")]
    Yielding,
    /// The robot is commanded to drive and hardly moves.
    #[error("the robot hardly moves, though no obstacle is known in its path")]
    Creeping,
}

impl Situation<'_> {
    /// Whether there is a path and all numbers are possible.
    pub fn check(&self) -> Result<(), Blocked> {
        check(self.pose, self.velocity, self.path, self.final_yaw)
    }
}

/// Whether there is a path and all numbers are possible: less than 1e8 metres, radians, m/s or
/// rad/s.
pub(crate) fn check(
    pose: Pose2,
    velocity: Velocity,
    path: &[MapPoint],
    final_yaw: Option<f64>,
) -> Result<(), Blocked> {
    if path.is_empty() || !path.iter().all(is_possible) || final_yaw.is_some_and(|y| !y.is_finite())
    {
        return Err(Blocked::NoPath);
    }
    let known = [pose.yaw, velocity.linear, velocity.angular]
        .iter()
        .all(|c| c.abs() < IMPOSSIBLE);
    if known && is_possible(&pose.point()) {
        Ok(())
    } else {
        Err(Blocked::NoPose)
    }
}

/// Whether a point may be one on the Earth; not with NaN.
fn is_possible(point: &MapPoint) -> bool {
    point.x.abs() < IMPOSSIBLE && point.y.abs() < IMPOSSIBLE
}

/// Turns a path into velocities, one call for each observation.
pub trait LocalPlanner: Send {
    /// The velocity to drive with now.
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked>;

    /// The share of a velocity from elsewhere, a recovery maneuver for example, that may be driven
    /// near people: all of it, unless the planner has its own rules for people.
    fn limit_near_people(&self, _situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        velocity
    }

    /// Forgets what was planned before: the next path is unrelated to the last.
    fn reset(&mut self);
}
