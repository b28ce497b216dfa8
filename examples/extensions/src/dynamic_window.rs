//! A local planner: the Dynamic Window Approach (D. Fox, W. Burgard, S. Thrun 1997).
//!
//! Of the velocities that the robot can reach within a few cycles, those are admissible that lead
//! into no obstacle. The one with the best weighted sum of progress along the path, heading,
//! clearance and speed is driven (equation 13 of the paper, with progress towards a point ahead on
//! the path added).

use openbench::PartError;
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, Velocity};
use openbench_motion::local::ahead;
use openbench_motion::{Blocked, LocalPlanner, PlannerSettings, Progress, Situation};

/// Duration of a cycle, seconds.
const CYCLE_S: f64 = 0.05;
/// Time in which a velocity must be reachable, seconds. Within one cycle all velocities are so near
/// to each other that their motions hardly differ.
const WINDOW_S: f64 = 4.0 * CYCLE_S;
/// Duration of a simulated motion, seconds, and its number of steps.
const HORIZON_S: f64 = 1.5;
const STEPS: u32 = 15;
/// Velocities that are tried for each of forward speed and turn rate.
const SAMPLES: u32 = 11;
/// Distance along the path to the point that is driven at, metres.
const LOOKAHEAD_M: f64 = 0.8;
/// Distance from the end of the path at which the robot has arrived, metres.
const TOLERANCE_M: f64 = 0.15;
/// Heading error at which it has arrived, radians.
const YAW_TOLERANCE_RAD: f64 = 0.08;
/// Heading error above which the robot turns on the spot, radians.
const TURN_FIRST_RAD: f64 = 0.9;
/// Acceleration along and about, m/s² and rad/s², chosen for smooth drives.
const ACCELERATION: f64 = 0.8;
const TURN_ACCELERATION: f64 = 3.0;
/// Clearance beyond which more of it does not count, metres.
const ENOUGH_CLEARANCE_M: f64 = 0.5;
/// Weights of heading error, clearance and speed against metres of progress.
const HEADING_WEIGHT: f64 = 0.2;
const CLEARANCE_WEIGHT: f64 = 0.2;
const SPEED_WEIGHT: f64 = 0.1;

/// The planner by its name: `--set motion=dynamic-window`.
pub fn make(settings: &PlannerSettings) -> Result<Box<dyn LocalPlanner>, PartError> {
    Ok(Box::new(DynamicWindow {
        robot: settings.robot.clone(),
    }))
}

/// Chooses among the velocities that can be reached.
struct DynamicWindow {
    robot: RobotDescription,
}

impl DynamicWindow {
    /// The best admissible velocity towards a point.
    fn best(&self, situation: &Situation<'_>, target: MapPoint) -> Option<Velocity> {
        let Velocity { linear, angular } = situation.velocity;
        let faster = ACCELERATION * WINDOW_S;
        let turning = TURN_ACCELERATION * WINDOW_S;
        let forward = Window::new(linear, faster, 0.0, self.robot.max_forward);
        let turn = Window::new(angular, turning, -self.robot.max_turn, self.robot.max_turn);
        let mut best: Option<(f64, Velocity)> = None;
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                let velocity = Velocity::new(forward.at(i), turn.at(j));
                let Some(score) = self.score(situation, target, velocity) else {
                    continue;
                };
                if best.is_none_or(|(other, _)| score > other) {
                    best = Some((score, velocity));
                }
            }
        }
        best.map(|(_, velocity)| velocity)
    }

    /// How good a velocity is; `None` if it is not admissible.
    fn score(
        &self,
        situation: &Situation<'_>,
        target: MapPoint,
        velocity: Velocity,
    ) -> Option<f64> {
        let dt = HORIZON_S / f64::from(STEPS);
        let mut pose = situation.pose;
        let mut clearance = self.clearance(situation, pose, 0.0);
        let here = clearance;
        for step in 1..=STEPS {
            let moved = Pose2::new(velocity.linear * dt, 0.0, velocity.angular * dt);
            pose = pose.compose(moved);
            let now = self.clearance(situation, pose, dt * f64::from(step));
            // Close to an obstacle, motions that gain clearance are admissible.
            if now <= 0.02 && now <= here {
                return None;
            }
            clearance = clearance.min(now);
        }
        let progress = situation.pose.point().distance(target) - pose.point().distance(target);
        let (forward, left) = pose.inverse_transform(target);
        let heading = libm::atan2(left, forward).abs();
        let clear = clearance.min(ENOUGH_CLEARANCE_M);
        let speed = velocity.linear;
        let facing = HEADING_WEIGHT * heading;
        Some(progress - facing + CLEARANCE_WEIGHT * clear + SPEED_WEIGHT * speed)
    }

    /// Distance between the robot's circle and the nearest obstacle after so many seconds, metres.
    fn clearance(&self, situation: &Situation<'_>, pose: Pose2, seconds: f64) -> f64 {
        let distances = situation.obstacles.iter().map(|obstacle| {
            if obstacle.is_moving() {
                obstacle.after(seconds).distance_to(pose.point())
            } else {
                obstacle.distance_to(pose.point())
            }
        });
        distances.fold(f64::INFINITY, f64::min) - self.robot.inscribed_radius()
    }

    fn turn(&self, error: f64) -> Velocity {
        let rate = (2.0 * error.abs()).clamp(0.15, self.robot.max_turn);
        Velocity::new(0.0, rate.copysign(error))
    }
}

/// An interval of velocities.
struct Window {
    least: f64,
    most: f64,
}

impl Window {
    /// Velocities around `now` within limits.
    fn new(now: f64, reach: f64, least: f64, most: f64) -> Self {
        Self {
            least: (now - reach).clamp(least, most),
            most: (now + reach).clamp(least, most),
        }
    }

    fn at(&self, sample: u32) -> f64 {
        let share = f64::from(sample) / f64::from(SAMPLES - 1);
        self.least + share * (self.most - self.least)
    }
}

impl LocalPlanner for DynamicWindow {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Progress, Blocked> {
        situation.check()?;
        let end = *situation.path.last().ok_or(Blocked::NoPath)?;
        let pose = situation.pose;
        if pose.point().distance(end) <= TOLERANCE_M {
            let error = situation
                .final_yaw
                .map_or(0.0, |yaw| wrap_angle(yaw - pose.yaw));
            let has_arrived = error.abs() <= YAW_TOLERANCE_RAD;
            let turn = Progress::Drive(self.turn(error));
            return Ok(if has_arrived { Progress::Arrived } else { turn });
        }
        let ahead = ahead(situation.path, pose.point(), LOOKAHEAD_M).ok_or(Blocked::NoPath)?;
        let target = ahead.point;
        let (forward, left) = pose.inverse_transform(target);
        let error = libm::atan2(left, forward);
        if error.abs() > TURN_FIRST_RAD {
            return Ok(Progress::Drive(self.turn(error)));
        }
        self.best(situation, target)
            .map(Progress::Drive)
            .ok_or(Blocked::NoGap)
    }

    fn reset(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_stay_within_limits() {
        let window = Window::new(0.48, 0.16, 0.0, 0.5);
        assert_eq!((window.at(0), window.at(SAMPLES - 1)), (0.48 - 0.16, 0.5));
    }
}
