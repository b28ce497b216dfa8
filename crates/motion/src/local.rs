//! The seam between who knows where to go and who turns that into velocities.

use openbench_core::{MapPoint, Pose2, SimTime, Velocity};
use openbench_osm::polygon::Segment;

use crate::shape::Obstacle;

/// No robot on the Earth has to do with so many metres or radians, or either a second.
const FAR: f64 = 1e8;

/// What a local planner works from.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// Now.
    pub time: SimTime,
    /// Where the robot believes to be, in `map`.
    pub pose: Pose2,
    /// How it believes to move.
    pub velocity: Velocity,
    /// The way; it begins near the robot.
    pub path: &'a [MapPoint],
    /// Heading wanted at the end of the way, radians; any if none.
    pub final_yaw: Option<f64>,
    /// What stands or moves within some metres, where it is now.
    pub obstacles: &'a [Obstacle],
}

/// What a local planner decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// Drive on with this velocity.
    Drive(Velocity),
    /// Drive on with this velocity, slower than the way alone would let the robot be, for this cause.
    Slowed(Velocity, Blocked),
    /// The end of the way is reached, heading included.
    Arrived,
}

impl Progress {
    /// The velocity to drive on with, if the robot is not there.
    pub fn velocity(&self) -> Option<Velocity> {
        match self {
            Self::Drive(velocity) | Self::Slowed(velocity, _) => Some(*velocity),
            Self::Arrived => None,
        }
    }
}

/// Why a local planner does not go on, or not as fast as it could. Where it does not, the robot should stand until it does.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Blocked {
    /// The way is empty or holds a number that is none.
    #[error("there is no way to follow: it is empty or holds a number that is none")]
    NoPath,
    /// The pose or velocity holds a number that is none.
    #[error("the robot does not know where it is: its pose or velocity holds a number that is none")]
    NoPose,
    /// Something stands in the way.
    #[error("an obstacle stands {0:.2} m ahead")]
    Obstacle(f64),
    /// Nothing that the footprint fits through leads on.
    #[error("nothing that the footprint fits through leads on")]
    NoGap,
    /// Something is so near that the robot has to get off it first.
    #[error("something is all but touched")]
    Touching,
    /// Somebody who moves may come there.
    #[error("somebody near may walk where the robot would drive")]
    Yielding,
    /// The robot is driven and hardly moves.
    #[error("the robot hardly moves, though nothing is known to be in its way")]
    Creeping,
}

impl Situation<'_> {
    /// Whether there is a way and all numbers are numbers.
    pub fn check(&self) -> Result<(), Blocked> {
        check(self.pose, self.velocity, self.path, self.final_yaw)
    }
}

/// Whether there is a way and all numbers are numbers that can be: less than 100,000 km, as many radians, or either a second.
pub fn check(
    pose: Pose2,
    velocity: Velocity,
    path: &[MapPoint],
    final_yaw: Option<f64>,
) -> Result<(), Blocked> {
    let finite = |p: &MapPoint| p.x.abs() < FAR && p.y.abs() < FAR;
    if path.is_empty() || !path.iter().all(finite) || final_yaw.is_some_and(|y| !y.is_finite()) {
        return Err(Blocked::NoPath);
    }
    let known = [pose.yaw, velocity.linear, velocity.angular].iter().all(|c| c.abs() < FAR);
    if known && finite(&pose.point()) { Ok(()) } else { Err(Blocked::NoPose) }
}

/// Turns a way into velocities, one call an observation.
pub trait LocalPlanner {
    /// The velocity for now.
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked>;

    /// As much of a velocity that somebody else thought of as may be driven among those who move: all of it, unless the planner cares for more than plans.
    fn among_people(&self, _situation: &Situation<'_>, velocity: Velocity) -> Velocity {
        velocity
    }

    /// Forgets what was planned before: the next way has nothing to do with the last.
    fn reset(&mut self);
}

/// The point `length` metres along a way from its place nearest to `from`, and whether that is its end; `None` of an empty way.
pub fn ahead(path: &[MapPoint], from: MapPoint, length: f64) -> Option<(MapPoint, bool)> {
    let (mut segment, mut foot) = (0, *path.first()?);
    for (i, pair) in path.windows(2).enumerate() {
        let candidate = Segment::new(pair[0], pair[1]).nearest_point(from).point;
        if candidate.distance(from) < foot.distance(from) - 1e-9 {
            (segment, foot) = (i, candidate);
        }
    }
    let (mut at, mut left) = (foot, length);
    for next in &path[(segment + 1).min(path.len())..] {
        let step = at.distance(*next);
        if step >= left && step > 0.0 {
            let t = left / step;
            return Some((MapPoint::new(at.x + t * (next.x - at.x), at.y + t * (next.y - at.y)), false));
        }
        (at, left) = (*next, left - step);
    }
    Some((at, true))
}
