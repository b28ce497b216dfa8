//! The error of an estimated pose.

use openbench_core::frames::wrap_angle;
use openbench_core::{Health, Pose2, PoseEstimate, SimTime};

/// The error of one estimated pose: estimate minus truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// Time of the estimate.
    pub time: SimTime,
    /// Position error, metres, east and north.
    pub offset: [f64; 2],
    /// Heading error, radians, counter-clockwise.
    pub yaw: f64,
    /// Health of the estimate as reported by the agent.
    pub health: Health,
}

impl PoseError {
    /// The error of `estimate` while the robot is at `truth`, both in the `map` frame.
    pub fn new(time: SimTime, truth: Pose2, estimate: PoseEstimate) -> Self {
        let PoseEstimate { pose, health } = estimate;
        let offset = [pose.x - truth.x, pose.y - truth.y];
        Self {
            time,
            offset,
            yaw: wrap_angle(pose.yaw - truth.yaw),
            health,
        }
    }

    /// The distance between estimated and true position, metres.
    pub fn distance(&self) -> f64 {
        libm::hypot(self.offset[0], self.offset[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_the_heading_is_wrapped() {
        let estimate = PoseEstimate {
            pose: Pose2::new(4.0, 6.0, -3.1),
            health: Health::Good,
        };
        let error = PoseError::new(SimTime::ZERO, Pose2::new(1.0, 2.0, 3.1), estimate);
        assert_eq!((error.offset, error.distance()), ([3.0, 4.0], 5.0));
        assert!((error.yaw - (std::f64::consts::TAU - 6.2)).abs() < 1e-9);
    }
}
