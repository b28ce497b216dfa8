//! Localization errors: the difference between estimated and true poses.

use std::collections::BTreeMap;

use openbench_core::Health;
use serde::{Deserialize, Serialize};

use crate::trace::PoseError;

/// Error above which a pose reported as good counts as a silent divergence.
const SILENT_DIVERGENCE_M: f64 = 1.0;

/// Statistics of the localization errors of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LocalizationSum {
    /// Root mean square of the position errors, metres.
    pub rmse_m: f64,
    /// 95th percentile of the position errors, metres.
    pub p95_m: f64,
    /// Maximum position error, metres.
    pub max_m: f64,
    /// Maximum heading error, radians.
    pub max_yaw_rad: f64,
    /// Maximum change of the position error from one pose to the next, metres.
    pub max_jump_m: f64,
    /// Number of times that the error exceeded 1 m while the agent reported good health.
    #[serde(default)]
    pub silent_divergences: usize,
}

/// A histogram of position errors with bins of 0.1 mm, so that errors of several runs can be
/// merged.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ErrorCounts(BTreeMap<u32, u32>);

impl ErrorCounts {
    /// The histogram of the finite errors.
    pub fn of<'a>(errors: impl IntoIterator<Item = &'a PoseError>) -> Self {
        let mut counts = Self::default();
        // Poses with NaN or infinity are left out, as in [`localization`].
        for error in errors
            .into_iter()
            .filter(|error| error.distance().is_finite())
        {
            // The cast saturates.
            *counts
                .0
                .entry((error.distance() * 1e4).round() as u32)
                .or_default() += 1;
        }
        counts
    }

    /// Adds the errors of another run.
    pub fn add(&mut self, other: &Self) {
        other
            .0
            .iter()
            .for_each(|(size, count)| *self.0.entry(*size).or_default() += count);
    }

    /// The quantile of the errors, metres: the smallest bin that covers `share` (0 to 1) of them;
    /// `None` without errors.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let all: u64 = self.0.values().map(|count| u64::from(*count)).sum();
        // The nearest rank. At least the first, so that a share of 0 gives the smallest error.
        let wanted = (share * all as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let reaches = |(size, count): (&u32, &u32)| {
            seen += u64::from(*count);
            (seen >= wanted).then(|| f64::from(*size) * 1e-4)
        };
        self.0.iter().find_map(reaches)
    }

    /// Root mean square of the errors, metres; `None` without errors.
    pub fn rms(&self) -> Option<f64> {
        // Errors are rounded to their bins, which changes the result by 0.05 mm at most.
        let (mut squares, mut all) = (0.0, 0.0);
        for (size, count) in &self.0 {
            let (metres, count) = (f64::from(*size) * 1e-4, f64::from(*count));
            squares += count * metres * metres;
            all += count;
        }
        (all > 0.0).then(|| (squares / all).sqrt())
    }
}

/// The statistics over the poses of all episodes; `None` if the agent reported none.
pub fn localization<'a>(
    episodes: impl Iterator<Item = &'a [PoseError]>,
) -> Option<LocalizationSum> {
    let (mut distances, mut max_yaw_rad, mut max_jump_m) = (Vec::new(), 0.0_f64, 0.0_f64);
    let mut silent_divergences = 0;
    for errors in episodes {
        // Before estimates with NaN are left out: in good health these are divergences as well.
        silent_divergences += divergences(errors);
        // Poses with NaN or infinity are left out: the metrics of driving show their effect.
        let errors: Vec<_> = errors
            .iter()
            .filter(|e| e.distance().is_finite() && e.yaw.is_finite())
            .collect();
        distances.extend(errors.iter().map(|error| error.distance()));
        max_yaw_rad = errors
            .iter()
            .map(|error| error.yaw.abs())
            .fold(max_yaw_rad, f64::max);
        // Pairs within an episode only: the error of the next one starts anew.
        max_jump_m = errors
            .windows(2)
            .map(|two| jump(two[0], two[1]))
            .fold(max_jump_m, f64::max);
    }
    distances.sort_by(f64::total_cmp);
    let max_m = *distances.last()?;
    let squares = distances
        .iter()
        .map(|distance| distance * distance)
        .sum::<f64>();
    // The nearest rank: an error that occurred, and none interpolated between two.
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

/// Change of the error from one pose to the next, metres.
fn jump(before: &PoseError, after: &PoseError) -> f64 {
    libm::hypot(
        after.offset[0] - before.offset[0],
        after.offset[1] - before.offset[1],
    )
}

/// Number of intervals in which the error is large, but the agent reports good health.
fn divergences(errors: &[PoseError]) -> usize {
    let begins = |i: usize| is_silent(&errors[i]) && !(i > 0 && is_silent(&errors[i - 1]));
    (0..errors.len()).filter(|i| begins(*i)).count()
}

/// Whether the error is large, but the agent reports good health.
fn is_silent(error: &PoseError) -> bool {
    // Negated, since a distance of NaN is not near either.
    let is_near = error.distance() <= SILENT_DIVERGENCE_M;
    error.health == Health::Good && !is_near
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Pose2, PoseEstimate, SimTime};

    #[test]
    fn errors_are_pooled_over_episodes_but_jumps_are_within_one() {
        let estimate = |x: f64, yaw: f64| {
            let pose = Pose2::new(1.0 + x, 1.0, 3.1 + yaw);
            let estimate = PoseEstimate {
                pose,
                health: Health::Good,
            };
            PoseError::new(SimTime::ZERO, Pose2::new(1.0, 1.0, 3.1), estimate)
        };
        let first: Vec<_> = (0..19).map(|_| estimate(0.1, 0.0)).collect();
        let episodes = [&first[..], &[estimate(0.5, -0.2)]];
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
        let broken = [
            estimate(f64::NAN, 0.0),
            estimate(0.2, f64::NAN),
            estimate(0.1, 0.0),
        ];
        assert!((localization([&broken[..]].into_iter()).unwrap().max_m - 0.1).abs() < 1e-9);
        let both = [estimate(0.1, 0.0), estimate(-0.3, 0.0)];
        assert!((localization([&both[..]].into_iter()).unwrap().max_jump_m - 0.4).abs() < 1e-9);
        assert!(localization(std::iter::empty()).is_none());
    }

    #[test]
    fn errors_of_several_runs_are_merged() {
        let estimate = |x: f64| {
            let estimate = PoseEstimate {
                pose: Pose2::new(x, 0.0, 0.0),
                health: Health::Good,
            };
            PoseError::new(SimTime::ZERO, Pose2::default(), estimate)
        };
        let mut counts = ErrorCounts::of(&[
            estimate(0.1),
            estimate(-0.1),
            estimate(0.3),
            estimate(f64::NAN),
        ]);
        counts.add(&ErrorCounts::of(&[estimate(1.0)]));
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
    fn a_large_error_that_is_reported_is_no_silent_divergence() {
        let estimate = |x: f64, health: Health| {
            let pose = Pose2::new(x, 0.0, 0.0);
            PoseError::new(
                SimTime::ZERO,
                Pose2::default(),
                PoseEstimate { pose, health },
            )
        };
        let good = |x| estimate(x, Health::Good);
        let errors = [
            good(0.9),
            good(1.1),
            good(1.2),
            estimate(1.3, Health::Lost),
            good(1.4),
            good(f64::NAN),
        ];
        assert_eq!(
            divergences(&errors),
            2,
            "once before the agent reports it, once after"
        );
        assert_eq!(
            localization([&errors[..]].into_iter())
                .unwrap()
                .silent_divergences,
            2
        );
        assert_eq!(
            divergences(&[estimate(
                9.0,
                Health::Degraded(openbench_core::Doubt::Noise)
            )]),
            0
        );
    }
}
