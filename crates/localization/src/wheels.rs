//! Wheel angles as velocities.

use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{RobotDescription, WheelSample};

use crate::lio::Speed;

/// Velocities are means over this time: one tick of the wheels' encoders is little then.
const INTERVAL: Duration = Duration::from_millis(50);
/// Standard deviation of the velocity along the robot's axes, m/s: wheels slip.
const SLIP_M_S: Vector3<f64> = Vector3::new(0.03, 0.05, 0.1);
/// How much larger it is in turns, m/s per rad/s: skidding wheels slide sideways.
const SLIP_IN_TURNS: f64 = 0.2;
/// A rim this many times as fast as the robot's limits allow was misread.
const MISREAD: f64 = 3.0;

/// The wheels of a robot that steers by the difference of its sides.
///
/// # Example
///
/// ```
/// use openbench_core::{RobotDescription, SimTime, WheelSample};
/// use openbench_localization::wheels::Wheels;
///
/// let mut wheels = Wheels::new(&RobotDescription::sentry());
/// let sample = |millis, angle| {
///     WheelSample { stamp: SimTime::from_millis(millis), left: angle, right: angle }
/// };
/// assert!(wheels.take(&sample(0, 0.0)).is_none());
/// // Half a radian of wheels of 6 cm in 50 ms: 0.6 m/s.
/// let speed = wheels.take(&sample(50, 0.5)).unwrap();
/// assert!((speed.velocity.x - 0.6).abs() < 1e-9);
/// assert_eq!(speed.stamp, SimTime::from_millis(25));
/// ```
#[derive(Debug, Clone)]
pub struct Wheels {
    /// Metres.
    radius: f64,
    /// Effective distance of the sides, which the turn rate follows from, metres.
    track: f64,
    /// A faster rim was misread, m/s.
    max_rim_speed: f64,
    /// The sample that the next velocity begins at.
    last: Option<WheelSample>,
}

impl Wheels {
    /// The wheels of a robot.
    pub fn new(robot: &RobotDescription) -> Self {
        let rim_speed = robot.max_forward + robot.max_turn * robot.effective_track / 2.0;
        Self {
            radius: robot.wheel_radius,
            track: robot.effective_track,
            max_rim_speed: MISREAD * rim_speed,
            last: None,
        }
    }

    /// Takes in a sample. Returns the velocity of `base_link` once 50 ms have passed since the one
    /// before.
    pub fn take(&mut self, sample: &WheelSample) -> Option<Speed> {
        if !(sample.left.is_finite() && sample.right.is_finite()) {
            return None;
        }
        let last = *self.last.get_or_insert(*sample);
        let interval = sample.stamp.since(last.stamp);
        if interval < INTERVAL {
            return None;
        }
        // Even if the velocity is refused below: the sample before may be the misread one.
        self.last = Some(*sample);
        let angles = [sample.left - last.left, sample.right - last.right];
        let [left, right] = angles.map(|angle| angle * self.radius / interval.as_secs_f64());
        if left.abs() > self.max_rim_speed || right.abs() > self.max_rim_speed {
            return None;
        }
        let turn = (right - left) / self.track;
        // The mean over an interval is the velocity in its middle.
        Some(Speed {
            stamp: last.stamp + interval / 2,
            velocity: Vector3::new((left + right) / 2.0, 0.0, 0.0),
            deviation: SLIP_M_S.map(|slip| slip + SLIP_IN_TURNS * turn.abs()),
            turn,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    fn sample(millis: u64, left: f64, right: f64) -> WheelSample {
        WheelSample {
            stamp: SimTime::from_millis(millis),
            left,
            right,
        }
    }

    #[test]
    fn angles_become_velocities_over_an_interval() {
        let robot = RobotDescription::sentry();
        let mut wheels = Wheels::new(&robot);
        assert!(wheels.take(&sample(0, 1.0, 1.0)).is_none());
        assert!(wheels.take(&sample(40, 1.1, 1.1)).is_none(), "too soon");
        assert!(wheels.take(&sample(45, f64::NAN, 1.1)).is_none());
        let speed = wheels.take(&sample(50, 1.5, 1.5)).unwrap();
        assert!((speed.velocity.x - 0.5 * robot.wheel_radius / 0.05).abs() < 1e-12);
        assert_eq!(speed.stamp, SimTime::from_millis(25));
        let turning = wheels.take(&sample(100, 1.4, 1.6)).unwrap();
        assert!(
            turning.deviation.y > speed.deviation.y,
            "less certain in a turn"
        );
        assert!(
            wheels.take(&sample(60, 9.0, 9.0)).is_none(),
            "time runs backwards"
        );
    }
}
