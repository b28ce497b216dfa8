//! How far the agent was from where it believed to be.

use openbench_core::frames::wrap_angle;
use openbench_core::{Pose2, SimTime};
use serde::{Deserialize, Serialize};

/// From the true pose to the one that the agent told, at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// When.
    pub time: SimTime,
    /// Metres east and north.
    pub offset: [f64; 2],
    /// Radians, counter-clockwise.
    pub yaw: f64,
}

impl PoseError {
    /// Of a pose that was told while the robot was at `truth`.
    pub fn new(time: SimTime, truth: Pose2, told: Pose2) -> Self {
        Self { time, offset: [told.x - truth.x, told.y - truth.y], yaw: wrap_angle(told.yaw - truth.yaw) }
    }

    /// Metres.
    pub fn distance(&self) -> f64 {
        libm::hypot(self.offset[0], self.offset[1])
    }

    /// By how many metres the error changed since another one.
    fn jump(&self, before: &Self) -> f64 {
        libm::hypot(self.offset[0] - before.offset[0], self.offset[1] - before.offset[1])
    }
}

/// Errors of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LocalizationSum {
    /// Root of the mean square of the distances, metres.
    pub rmse_m: f64,
    /// Nineteen of twenty are no larger, metres.
    pub p95_m: f64,
    /// The largest, metres.
    pub max_m: f64,
    /// The largest error of the heading, radians.
    pub max_yaw_rad: f64,
    /// The largest change of the error from one pose to the next, metres.
    pub max_jump_m: f64,
}

/// Over the poses of all episodes; `None` if the agent told none.
pub fn localization<'a>(episodes: impl Iterator<Item = &'a [PoseError]>) -> Option<LocalizationSum> {
    let (mut distances, mut max_yaw_rad, mut max_jump_m) = (Vec::new(), 0.0_f64, 0.0_f64);
    for errors in episodes {
        // What is no number is no pose; the agent drives by it all the same, and pays.
        let errors: Vec<_> =
            errors.iter().filter(|e| e.distance().is_finite() && e.yaw.is_finite()).collect();
        distances.extend(errors.iter().map(|error| error.distance()));
        max_yaw_rad = errors.iter().map(|error| error.yaw.abs()).fold(max_yaw_rad, f64::max);
        max_jump_m = errors.windows(2).map(|two| two[1].jump(two[0])).fold(max_jump_m, f64::max);
    }
    distances.sort_by(f64::total_cmp);
    let max_m = *distances.last()?;
    let squares = distances.iter().map(|distance| distance * distance).sum::<f64>();
    let p95_m = distances[(distances.len() * 95).div_ceil(100) - 1];
    let rmse_m = (squares / distances.len() as f64).sqrt();
    Some(LocalizationSum { rmse_m, p95_m, max_m, max_yaw_rad, max_jump_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed_over_episodes_and_jumps_within_them() {
        let told = |x: f64, yaw: f64| {
            PoseError::new(SimTime::ZERO, Pose2::new(1.0, 1.0, 3.1), Pose2::new(1.0 + x, 1.0, 3.1 + yaw))
        };
        let first: Vec<_> = (0..19).map(|_| told(0.1, 0.0)).collect();
        let episodes = [&first[..], &[told(0.5, -0.2)]];
        let sum = localization(episodes.into_iter()).unwrap();
        assert!((sum.p95_m - 0.1).abs() < 1e-9 && (sum.max_m - 0.5).abs() < 1e-9, "{sum:?}");
        assert!(sum.max_jump_m < 1e-9 && (sum.max_yaw_rad - 0.2).abs() < 1e-9);
        assert!((sum.rmse_m - (0.22_f64 + 0.25 - 0.03).sqrt() / 20.0_f64.sqrt()).abs() < 1e-3, "{sum:?}");
        let broken = [told(f64::NAN, 0.0), told(0.2, f64::NAN), told(0.1, 0.0)];
        assert!((localization([&broken[..]].into_iter()).unwrap().max_m - 0.1).abs() < 1e-9);
        let both = [told(0.1, 0.0), told(-0.3, 0.0)];
        assert!((localization([&both[..]].into_iter()).unwrap().max_jump_m - 0.4).abs() < 1e-9);
        assert!(localization(std::iter::empty()).is_none());
    }
}
