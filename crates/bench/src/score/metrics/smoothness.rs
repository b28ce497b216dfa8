//! How smoothly a robot drives: how much it turns, how much its speed goes up and down, and how often it stops.

use openbench_core::{Pose2, frames::wrap_angle};
use serde::{Deserialize, Serialize};

/// A robot stops when it gets slower than this, m/s,
const STANDING: f64 = 0.05;
/// after it was faster than this.
const DRIVING: f64 = 0.15;

/// What adds up along a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SmoothnessSum {
    /// Radians turned to either side.
    pub turned_rad: f64,
    /// Changes of speed up and down, m/s: 0.5 there and back for each stop from half a metre a second.
    pub speed_changes_mps: f64,
    /// Times that the robot stopped.
    pub stops: usize,
}

impl SmoothnessSum {
    /// Both together.
    pub fn and(self, other: Self) -> Self {
        Self {
            turned_rad: self.turned_rad + other.turned_rad,
            speed_changes_mps: self.speed_changes_mps + other.speed_changes_mps,
            stops: self.stops + other.stops,
        }
    }

    /// In words, for people to read.
    pub fn describe(&self, path_m: f64) -> String {
        let each = |sum: f64| if path_m > 0.0 { sum / path_m } else { 0.0 };
        let (turned, changes) = (each(self.turned_rad), each(self.speed_changes_mps));
        format!(
            "{turned:.2} rad and {changes:.2} m/s up and down each metre, {} stops",
            self.stops
        )
    }
}

/// Sums up a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Smoothness {
    sum: SmoothnessSum,
    speed: Option<f64>,
    drives: bool,
}

impl Smoothness {
    /// Takes in a step from one pose to the next, which took `seconds`.
    pub fn step(&mut self, before: Pose2, after: Pose2, seconds: f64) {
        let speed = before.point().distance(after.point()) / seconds;
        self.sum.turned_rad += wrap_angle(after.yaw - before.yaw).abs();
        self.sum.speed_changes_mps += (speed - self.speed.unwrap_or(speed)).abs();
        self.speed = Some(speed);
        if speed > DRIVING {
            self.drives = true;
        } else if speed < STANDING {
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
    fn a_drive_with_one_stop_and_a_turn_is_summed_up() {
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
        assert_eq!(sum.and(sum).stops, 2);
        assert_eq!(
            sum.describe(2.0),
            "0.65 rad and 0.75 m/s up and down each metre, 1 stops"
        );
    }
}
