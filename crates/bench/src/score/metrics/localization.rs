//! How far the agent was from where it believed to be.

use std::collections::BTreeMap;

use openbench_core::frames::wrap_angle;
use openbench_core::{Health, Pose2, PoseEstimate, SimTime};
use serde::{Deserialize, Serialize};

/// Poses farther off than that are wrong, metres: who still calls them good diverges silently.
const SILENT_M: f64 = 1.0;

/// From the true pose to the one that the agent told, at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseError {
    /// When.
    pub time: SimTime,
    /// Metres east and north.
    pub offset: [f64; 2],
    /// Radians, counter-clockwise.
    pub yaw: f64,
    /// What the agent said of the pose.
    pub health: Health,
}

impl PoseError {
    /// Of a pose that was told while the robot was at `truth`.
    pub fn new(time: SimTime, truth: Pose2, told: PoseEstimate) -> Self {
        let PoseEstimate { pose, health } = told;
        let offset = [pose.x - truth.x, pose.y - truth.y];
        Self {
            time,
            offset,
            yaw: wrap_angle(pose.yaw - truth.yaw),
            health,
        }
    }

    /// Metres.
    pub fn distance(&self) -> f64 {
        libm::hypot(self.offset[0], self.offset[1])
    }

    /// Whether the agent is far off and does not know it.
    fn is_silent(&self) -> bool {
        // What is no number is no good pose either.
        let is_near = self.distance() <= SILENT_M;
        self.health == Health::Good && !is_near
    }

    /// By how many metres the error changed since another one.
    fn jump(&self, before: &Self) -> f64 {
        libm::hypot(
            self.offset[0] - before.offset[0],
            self.offset[1] - before.offset[1],
        )
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
    /// How often the agent came to be more than a metre off while it called its pose good.
    #[serde(default)]
    pub silent_divergences: usize,
}

/// How often errors of each size were made, to a tenth of a millimetre: errors of several runs can be put together.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ErrorCounts(BTreeMap<u32, u32>);

impl ErrorCounts {
    /// Of poses that were told.
    pub fn of<'a>(errors: impl IntoIterator<Item = &'a PoseError>) -> Self {
        let mut counts = Self::default();
        // What is no number is no pose, as in [`localization`].
        for error in errors
            .into_iter()
            .filter(|error| error.distance().is_finite())
        {
            // A cast takes what is too large for the largest number.
            *counts
                .0
                .entry((error.distance() * 1e4).round() as u32)
                .or_default() += 1;
        }
        counts
    }

    /// Adds those of another run.
    pub fn add(&mut self, other: &Self) {
        other
            .0
            .iter()
            .for_each(|(size, count)| *self.0.entry(*size).or_default() += count);
    }

    /// The error that a share of all does not exceed, metres; `None` without any.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let all: u64 = self.0.values().map(|count| u64::from(*count)).sum();
        let wanted = (share * all as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let reaches = |(size, count): (&u32, &u32)| {
            seen += u64::from(*count);
            (seen >= wanted).then(|| f64::from(*size) * 1e-4)
        };
        self.0.iter().find_map(reaches)
    }

    /// Root of the mean square, metres; `None` without any.
    pub fn rms(&self) -> Option<f64> {
        let (mut squares, mut all) = (0.0, 0.0);
        for (size, count) in &self.0 {
            let (metres, count) = (f64::from(*size) * 1e-4, f64::from(*count));
            squares += count * metres * metres;
            all += count;
        }
        (all > 0.0).then(|| (squares / all).sqrt())
    }
}

/// Over the poses of all episodes; `None` if the agent told none.
pub fn localization<'a>(
    episodes: impl Iterator<Item = &'a [PoseError]>,
) -> Option<LocalizationSum> {
    let (mut distances, mut max_yaw_rad, mut max_jump_m) = (Vec::new(), 0.0_f64, 0.0_f64);
    let mut silent_divergences = 0;
    for errors in episodes {
        silent_divergences += divergences(errors);
        // What is no number is no pose; the agent drives by it all the same, and pays.
        let errors: Vec<_> = errors
            .iter()
            .filter(|e| e.distance().is_finite() && e.yaw.is_finite())
            .collect();
        distances.extend(errors.iter().map(|error| error.distance()));
        max_yaw_rad = errors
            .iter()
            .map(|error| error.yaw.abs())
            .fold(max_yaw_rad, f64::max);
        max_jump_m = errors
            .windows(2)
            .map(|two| two[1].jump(two[0]))
            .fold(max_jump_m, f64::max);
    }
    distances.sort_by(f64::total_cmp);
    let max_m = *distances.last()?;
    let squares = distances
        .iter()
        .map(|distance| distance * distance)
        .sum::<f64>();
    let p95_m = distances[(distances.len() * 95).div_ceil(100) - 1];
    let rmse_m = (squares / distances.len() as f64).sqrt();
    Some(LocalizationSum {
        rmse_m,
        p95_m,
        max_m,
        max_yaw_rad,
        max_jump_m,
        silent_divergences,
    })
}

/// Stretches in which the agent is far off and does not know it.
fn divergences(errors: &[PoseError]) -> usize {
    let begins = |i: usize| errors[i].is_silent() && !(i > 0 && errors[i - 1].is_silent());
    (0..errors.len()).filter(|i| begins(*i)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed_over_episodes_and_jumps_within_them() {
        let told = |x: f64, yaw: f64| {
            let pose = Pose2::new(1.0 + x, 1.0, 3.1 + yaw);
            let told = PoseEstimate {
                pose,
                health: Health::Good,
            };
            PoseError::new(SimTime::ZERO, Pose2::new(1.0, 1.0, 3.1), told)
        };
        let first: Vec<_> = (0..19).map(|_| told(0.1, 0.0)).collect();
        let episodes = [&first[..], &[told(0.5, -0.2)]];
        let sum = localization(episodes.into_iter()).unwrap();
        assert!(
            (sum.p95_m - 0.1).abs() < 1e-9 && (sum.max_m - 0.5).abs() < 1e-9,
            "{sum:?}"
        );
        assert!(sum.max_jump_m < 1e-9 && (sum.max_yaw_rad - 0.2).abs() < 1e-9);
        assert!(
            (sum.rmse_m - (0.22_f64 + 0.25 - 0.03).sqrt() / 20.0_f64.sqrt()).abs() < 1e-3,
            "{sum:?}"
        );
        let broken = [told(f64::NAN, 0.0), told(0.2, f64::NAN), told(0.1, 0.0)];
        assert!((localization([&broken[..]].into_iter()).unwrap().max_m - 0.1).abs() < 1e-9);
        let both = [told(0.1, 0.0), told(-0.3, 0.0)];
        assert!((localization([&both[..]].into_iter()).unwrap().max_jump_m - 0.4).abs() < 1e-9);
        assert!(localization(std::iter::empty()).is_none());
    }

    #[test]
    fn errors_of_several_runs_are_put_together() {
        let told = |x: f64| {
            let told = PoseEstimate {
                pose: Pose2::new(x, 0.0, 0.0),
                health: Health::Good,
            };
            PoseError::new(SimTime::ZERO, Pose2::default(), told)
        };
        let mut counts = ErrorCounts::of(&[told(0.1), told(-0.1), told(0.3), told(f64::NAN)]);
        counts.add(&ErrorCounts::of(&[told(1.0)]));
        assert_eq!(counts.quantile(0.5), Some(0.1));
        assert!(
            (counts.quantile(0.75).unwrap() - 0.3).abs() < 1e-9
                && counts.quantile(1.0) == Some(1.0)
        );
        assert!((counts.rms().unwrap() - (1.11_f64 / 4.0).sqrt()).abs() < 1e-9);
        assert_eq!(
            (
                ErrorCounts::default().quantile(0.5),
                ErrorCounts::default().rms()
            ),
            (None, None)
        );
    }

    #[test]
    fn who_is_far_off_and_says_so_is_not_silent() {
        let told = |x: f64, health: Health| {
            let pose = Pose2::new(x, 0.0, 0.0);
            PoseError::new(
                SimTime::ZERO,
                Pose2::default(),
                PoseEstimate { pose, health },
            )
        };
        let good = |x| told(x, Health::Good);
        let way = [
            good(0.9),
            good(1.1),
            good(1.2),
            told(1.3, Health::Lost),
            good(1.4),
            good(f64::NAN),
        ];
        assert_eq!(
            divergences(&way),
            2,
            "once until it was noticed, once after that"
        );
        assert_eq!(
            localization([&way[..]].into_iter())
                .unwrap()
                .silent_divergences,
            2
        );
        assert_eq!(
            divergences(&[told(9.0, Health::Degraded(openbench_core::Doubt::Noise))]),
            0
        );
    }
}
