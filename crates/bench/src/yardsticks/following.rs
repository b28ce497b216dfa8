//! Driving along a path of straight lines, for robots that know where they are.

use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity};

/// Distance at which a point of the path counts as reached, metres. A corner cut by more may touch
/// what the path grazes.
const REACHED_M: f64 = 0.02;
/// Above this error of the heading the robot turns on the spot, radians.
const TURN_FIRST_RAD: f64 = 0.3;
/// Turn rate for each radian of that error, 1/s.
const TURN_GAIN: f64 = 2.5;
/// Share of the robot's deceleration that is used to stop.
const BRAKING: f64 = 0.5;

/// Follows a path.
#[derive(Debug, Clone)]
pub(super) struct Follower {
    /// The point of the path that was reached last; at first, where the robot was.
    last: Option<MapPoint>,
    /// What is left of the path.
    path: VecDeque<MapPoint>,
}

impl Follower {
    /// Follows these points.
    pub(super) fn new(path: impl IntoIterator<Item = MapPoint>) -> Self {
        Self {
            last: None,
            path: path.into_iter().collect(),
        }
    }

    /// The velocity of a robot that is at `pose`; `None` at the end of the path.
    pub(super) fn velocity(&mut self, pose: Pose2, robot: &RobotDescription) -> Option<Velocity> {
        let here = pose.point();
        self.last.get_or_insert(here);
        while self.has_reached(*self.path.front()?, here) {
            self.last = self.path.pop_front();
        }
        let next = *self.path.front()?;
        let error = wrap_angle(here.bearing_to(next) - pose.yaw);
        let angular = (TURN_GAIN * error).clamp(-robot.max_turn, robot.max_turn);
        let linear = if error.abs() > TURN_FIRST_RAD {
            0.0
        } else {
            self.speed(here, robot)
        };
        Some(Velocity::new(linear, angular))
    }

    /// Whether a point of the path is here or behind.
    fn has_reached(&self, point: MapPoint, here: MapPoint) -> bool {
        let is_behind = self.last.is_some_and(|last| {
            let (along, beyond) = (last.bearing_to(point), point.bearing_to(here));
            wrap_angle(beyond - along).abs() < FRAC_PI_2
        });
        is_behind || point.distance(here) < REACHED_M
    }

    /// The speed from which the robot can stop where it has to turn on the spot, m/s.
    fn speed(&self, here: MapPoint, robot: &RobotDescription) -> f64 {
        let braking = 2.0 * BRAKING * robot.max_acceleration * self.straight(here);
        libm::sqrt(braking).min(robot.max_forward)
    }

    /// Length of the path until it turns sharply or ends, metres.
    fn straight(&self, here: MapPoint) -> f64 {
        let mut from = here;
        let mut length = 0.0;
        for (i, &to) in self.path.iter().enumerate() {
            length += from.distance(to);
            let turn = self
                .path
                .get(i + 1)
                .map(|next| wrap_angle(to.bearing_to(*next) - from.bearing_to(to)));
            if turn.is_none_or(|turn| turn.abs() > TURN_FIRST_RAD) {
                break;
            }
            from = to;
        }
        length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_around_a_corner_is_followed_closely() {
        let robot = RobotDescription::sentry();
        let corner = MapPoint::new(5.0, 0.0);
        let end = MapPoint::new(5.0, 4.0);
        let mut follower = Follower::new([corner, end]);
        let mut pose = Pose2::new(0.0, 0.0, 2.0);
        let (mut steps, mut driven) = (0, 0.0);
        while let Some(velocity) = follower.velocity(pose, &robot) {
            // Exact motion of a robot without inertia.
            let ahead = pose.point().offset(pose.yaw, 0.05 * velocity.linear);
            driven += ahead.distance(pose.point());
            pose = Pose2::new(
                ahead.x,
                ahead.y,
                wrap_angle(pose.yaw + 0.05 * velocity.angular),
            );
            let off = pose.y.abs().min((pose.x - 5.0).abs());
            assert!(off < 0.05, "{pose:?}");
            steps += 1;
            assert!(steps < 2000, "it does not arrive");
        }
        assert!(pose.point().distance(end) < 0.05);
        assert!(driven < 9.1, "{driven} m");
    }
}
