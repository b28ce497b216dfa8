//! Wheels' angles as velocities.

use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::{RobotDescription, WheelSample};

use crate::lio::speed::Speed;

/// Wheels are looked at over so long a time: one mark of their encoders is a small part of the way then.
const STRIDE: Duration = Duration::from_millis(50);
/// How wrong wheels' speed is along the robot's axes, m/s, and how much more so in turns, m/s per rad/s: skidding wheels slide sideways.
const SLIP: [f64; 3] = [0.03, 0.05, 0.1];
const SLIP_IN_TURNS: f64 = 0.2;
/// Rims that are so many times as fast as the robot's limits make them were misread.
const MISREAD: f64 = 3.0;

/// The wheels of a robot that steers by the difference of its sides.
#[derive(Debug, Clone)]
pub struct Wheels {
    /// Metres.
    radius: f64,
    /// By which the turn rate follows from the sides' speeds, metres.
    track: f64,
    /// No rim is faster, m/s: what shows more was misread.
    fastest: f64,
    /// When they were looked at last, and what they showed.
    last: Option<WheelSample>,
}

impl Wheels {
    /// Those of a robot.
    pub fn new(robot: &RobotDescription) -> Self {
        let rim = robot.max_forward + robot.max_turn * robot.effective_track / 2.0;
        let fastest = MISREAD * rim;
        Self {
            radius: robot.wheel_radius,
            track: robot.effective_track,
            fastest,
            last: None,
        }
    }

    /// Takes in a sample; the velocity of `base_link` when enough time has passed since the last one that was told.
    pub fn take(&mut self, sample: &WheelSample) -> Option<Speed> {
        if !(sample.left.is_finite() && sample.right.is_finite()) {
            return None;
        }
        let last = *self.last.get_or_insert(*sample);
        if sample.stamp.since(last.stamp) < STRIDE {
            return None;
        }
        self.last = Some(*sample);
        let took = sample.stamp.since(last.stamp);
        let [left, right] = [sample.left - last.left, sample.right - last.right]
            .map(|angle| angle * self.radius / took.as_secs_f64());
        if [left, right].iter().any(|rim| rim.abs() > self.fastest) {
            return None;
        }
        let turn = (right - left) / self.track;
        // The mean over a stretch is the speed at its middle.
        Some(Speed {
            stamp: last.stamp + took / 2,
            velocity: Vector3::new((left + right) / 2.0, 0.0, 0.0),
            deviation: Vector3::from(SLIP).map(|slip| slip + SLIP_IN_TURNS * turn.abs()),
            turn,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::SimTime;

    #[test]
    fn a_turn_of_the_wheels_is_a_way() {
        let robot = RobotDescription::sentry();
        let mut wheels = Wheels::new(&robot);
        let sample = |millis, left, right| WheelSample {
            stamp: SimTime::from_millis(millis),
            left,
            right,
        };
        assert!(wheels.take(&sample(0, 1.0, 1.0)).is_none());
        assert!(wheels.take(&sample(40, 1.1, 1.1)).is_none());
        assert!(wheels.take(&sample(45, f64::NAN, 1.1)).is_none());
        let speed = wheels.take(&sample(50, 1.5, 1.5)).unwrap();
        assert!((speed.velocity.x - 0.5 * robot.wheel_radius / 0.05).abs() < 1e-12);
        assert_eq!(speed.stamp, SimTime::from_millis(25));
        // In a turn it is less sure, and time that runs backwards says nothing.
        let turning = wheels.take(&sample(100, 1.4, 1.6)).unwrap();
        assert!(turning.deviation.y > speed.deviation.y);
        assert!(wheels.take(&sample(60, 9.0, 9.0)).is_none());
    }
}
