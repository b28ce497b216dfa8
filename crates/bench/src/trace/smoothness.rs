//! Smoothness of a drive: turning, speed variation, and stops.

use openbench_core::{Pose2, frames::wrap_angle};
use serde::{Deserialize, Serialize};

use crate::plural::count;

/// Below this speed a driving robot has stopped.
const STOPPED_MPS: f64 = 0.05;
/// Above this speed a stopped robot is driving again.
const DRIVING_MPS: f64 = 0.15;

/// Sums along a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SmoothnessSum {
    /// Sum of the absolute changes of the heading, radians.
    pub turned_rad: f64,
    /// Sum of the absolute changes of the speed, m/s: a stop from 0.5 m/s and the start after it
    /// add 1.0.
    pub speed_changes_mps: f64,
    /// Number of stops.
    pub stops: usize,
}

impl SmoothnessSum {
    /// The sum of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            turned_rad: self.turned_rad + other.turned_rad,
            speed_changes_mps: self.speed_changes_mps + other.speed_changes_mps,
            stops: self.stops + other.stops,
        }
    }

    /// The sums in words, per metre of a path of `path_m` metres, for reports.
    pub fn describe(&self, path_m: f64) -> String {
        let per_metre = |sum: f64| if path_m > 0.0 { sum / path_m } else { 0.0 };
        let (turning, variation) = (
            per_metre(self.turned_rad),
            per_metre(self.speed_changes_mps),
        );
        format!(
            "speed variation {variation:.2} m/s per m, turning {turning:.2} rad/m, {}",
            count(self.stops, "stop", "stops")
        )
    }
}

/// Accumulates the smoothness of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Smoothness {
    sum: SmoothnessSum,
    speed: Option<f64>,
    drives: bool,
}

impl Smoothness {
    /// Adds a step between two poses that took `seconds`.
    pub fn step(&mut self, before: Pose2, after: Pose2, seconds: f64) {
        let speed = before.point().distance(after.point()) / seconds;
        self.sum.turned_rad += wrap_angle(after.yaw - before.yaw).abs();
        // The first step has no earlier speed to differ from.
        self.sum.speed_changes_mps += (speed - self.speed.unwrap_or(speed)).abs();
        self.speed = Some(speed);
        // Two thresholds: with one, a robot that creeps at about that speed would stop again and
        // again.
        if speed > DRIVING_MPS {
            self.drives = true;
        } else if speed < STOPPED_MPS {
            self.sum.stops += usize::from(self.drives);
            self.drives = false;
        }
    }

    /// The sum so far.
    pub fn sum(&self) -> SmoothnessSum {
        self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_with_one_stop_and_a_turn_is_summed() {
        let mut smoothness = Smoothness::default();
        let mut pose = Pose2::default();
        let mut drive = |speed: f64, rate: f64, steps: usize| {
            for _ in 0..steps {
                let next = Pose2::new(pose.x + 0.1 * speed, pose.y, pose.yaw + 0.1 * rate);
                smoothness.step(pose, next, 0.1);
                pose = next;
            }
        };
        drive(0.0, 0.0, 3);
        drive(0.5, 0.0, 10);
        drive(0.1, 0.0, 1);
        drive(0.0, -1.0, 10);
        drive(0.5, 0.3, 10);
        let sum = smoothness.sum();
        assert!(
            (sum.turned_rad - 1.3).abs() < 1e-9 && (sum.speed_changes_mps - 1.5).abs() < 1e-9,
            "{sum:?}"
        );
        assert_eq!(sum.stops, 1);
        assert_eq!(sum.plus(sum).stops, 2);
        assert_eq!(
            sum.describe(2.0),
            "speed variation 0.75 m/s per m, turning 0.65 rad/m, 1 stop"
        );
    }
}
