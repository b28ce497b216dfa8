//! Whether a person or the robot obstructs a lane.

use openbench_core::Pose2;

use super::driver_model::Leader;
use super::hull::{CAR_HALF_LENGTH_M, CAR_HALF_WIDTH_M};
use super::social_force::Body;

/// Distance between the points of a lane at which bodies are searched, metres.
pub(super) const STEP_M: f64 = 1.5;
/// Half the length of lane that a point covers, with overlap, metres.
const REACH_M: f64 = 0.8;
/// How far to the side of a lane bodies are regarded, metres.
const WIDTH_M: f64 = 4.0;
/// Lateral room for people beside a car, metres.
const ASIDE_M: f64 = 0.35;
/// Cars yield to people who will be on the lane within this time, seconds.
const ABOUT_TO_S: f64 = 1.5;
/// People who walk towards the lane faster than this are about to enter it, m/s.
const ABOUT_TO_SPEED: f64 = 0.4;

/// A point of the lane ahead of a car.
pub(super) struct LanePoint {
    pub pose: Pose2,
    sin: f64,
    cos: f64,
    /// Distance along the lane from the car's middle, metres.
    run: f64,
}

impl LanePoint {
    /// The point `run` metres ahead of a car's middle.
    pub fn new(pose: Pose2, run: f64) -> Self {
        let (sin, cos) = libm::sincos(pose.yaw);
        Self {
            pose,
            sin,
            cos,
            run,
        }
    }

    /// A body near this point as a leader, if it is on the lane or about to enter it. A body beside
    /// the front is passed; one that touches it stops the car.
    pub fn obstruction(&self, body: Body) -> Option<Leader> {
        let Body {
            position,
            velocity,
            radius,
        } = body;
        let (sin, cos) = (self.sin, self.cos);
        let (dx, dy) = (position.x - self.pose.x, position.y - self.pose.y);
        // In the axes of the lane at this point.
        let (forward, left) = (cos * dx + sin * dy, cos * dy - sin * dx);
        if !(-REACH_M..=REACH_M).contains(&forward) || left.abs() > WIDTH_M {
            return None;
        }
        let across = cos * velocity[1] - sin * velocity[0];
        let gap = self.run + forward - CAR_HALF_LENGTH_M - radius;
        let touches = left.abs() < CAR_HALF_WIDTH_M + radius;
        // A body that comes towards the car counts as standing: leaders do not drive backwards.
        let speed = (cos * velocity[0] + sin * velocity[1]).max(0.0);
        let obstructs = touches || (gap > -0.5 && enters_lane(left, across, radius));
        obstructs.then_some(Leader { gap, speed })
    }
}

/// Whether a body `left` metres beside the middle of a lane is on it or about to be. It moves to
/// the left at `across` m/s.
fn enters_lane(left: f64, across: f64, radius: f64) -> bool {
    let half = CAR_HALF_WIDTH_M + ASIDE_M + radius;
    let later = left + across * ABOUT_TO_S;
    // Towards the middle of the lane; by then the body may be on it, or already beyond it.
    let enters = across.abs() > ABOUT_TO_SPEED && across * left < 0.0;
    left.abs() < half || (enters && (later.abs() < half || later * left < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_who_walk_towards_the_lane_obstruct_it() {
        assert!(enters_lane(1.0, 0.0, 0.25));
        assert!(!enters_lane(2.0, 0.0, 0.25) && !enters_lane(2.0, 1.0, 0.25));
        assert!(enters_lane(2.0, -1.0, 0.25));
        assert!(!enters_lane(2.0, -0.3, 0.25), "too slow to be on it soon");
    }
}
