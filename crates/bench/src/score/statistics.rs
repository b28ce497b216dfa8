//! 95 % confidence intervals: Wilson for rates, the percentile bootstrap for means.
//!
//! Both treat the deliveries (for LSR and LSPL, the sequences) as independent. Deliveries within a
//! sequence are correlated, so their intervals are slightly too narrow.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;
/// Number of resamples of the bootstrap.
const RESAMPLES: usize = 10_000;

/// A number of successes among a number of trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Proportion {
    /// Number of successes.
    pub successes: usize,
    /// Number of trials.
    pub trials: usize,
}

impl Proportion {
    /// Counts the trials that are successes.
    pub fn count<T>(trials: &[T], is_success: impl Fn(&T) -> bool) -> Self {
        Self {
            successes: trials.iter().filter(|trial| is_success(trial)).count(),
            trials: trials.len(),
        }
    }

    /// The share of successes, 0 to 1; `None` without trials.
    pub fn rate(self) -> Option<f64> {
        (self.trials > 0).then(|| self.successes as f64 / self.trials as f64)
    }
}

/// The Wilson score interval of the rate `successes / trials`, lower and upper bound; `None`
/// without trials (E. B. Wilson, JASA 22, 1927).
///
/// ```
/// use openbench_bench::score::statistics::wilson_interval;
///
/// let [low, high] = wilson_interval(8, 10).unwrap();
/// assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4);
/// ```
pub fn wilson_interval(successes: usize, trials: usize) -> Option<[f64; 2]> {
    if trials == 0 {
        return None;
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    // The bounds are the solutions p0 of (p - p0)² = Z² p0 (1 - p0) / n.
    let scale = 1.0 + Z * Z / n;
    let centre = (p + Z * Z / (2.0 * n)) / scale;
    let half = Z / scale * libm::sqrt(p * (1.0 - p) / n + Z * Z / (4.0 * n * n));
    // Only rounding can lead beyond 0 and 1.
    Some([(centre - half).max(0.0), (centre + half).min(1.0)])
}

/// The percentile bootstrap interval of the mean of `values`, lower and upper bound, from 10,000
/// resamples drawn from `seed`; `None` for fewer than two values.
pub fn bootstrap_interval(values: &[f64], seed: u64) -> Option<[f64; 2]> {
    if values.len() < 2 {
        return None;
    }
    let mut random = Pcg32::seed_from_u64(seed);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| resampled_mean(values, &mut random))
        .collect();
    means.sort_by(f64::total_cmp);
    let quantile = |q: f64| means[libm::round(q * (RESAMPLES - 1) as f64) as usize];
    Some([quantile(0.025), quantile(0.975)])
}

fn resampled_mean(values: &[f64], random: &mut Pcg32) -> f64 {
    let n = values.len() as u64;
    // Multiply-shift: one random number for each draw. Its bias, below n / 2^32, is negligible.
    let draw = |_| values[((u64::from(random.next_u32()) * n) >> 32) as usize];
    (0..values.len()).map(draw).sum::<f64>() / n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 2], b: [f64; 2], tolerance: f64) -> bool {
        (a[0] - b[0]).abs() < tolerance && (a[1] - b[1]).abs() < tolerance
    }

    #[test]
    fn wilson_gives_textbook_values() {
        // 8 of 10: 0.4902 to 0.9433.
        assert!(close(
            wilson_interval(8, 10).unwrap(),
            [0.4902, 0.9433],
            1e-4
        ));
        assert!(close(wilson_interval(5, 5).unwrap(), [0.5655, 1.0], 1e-4));
        assert!(close(wilson_interval(0, 5).unwrap(), [0.0, 0.4345], 1e-4));
        assert_eq!(wilson_interval(0, 0), None);
    }

    #[test]
    fn the_bootstrap_agrees_with_the_normal_interval_for_many_values() {
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 20) / 19.0).collect();
        // Mean 0.5, standard deviation of 20 equal steps 0.30349, standard error / 20.
        let half = Z * 0.30349 / 20.0;
        let interval = bootstrap_interval(&values, 1).unwrap();
        assert!(
            close(interval, [0.5 - half, 0.5 + half], 2e-3),
            "{interval:?}"
        );
    }

    #[test]
    fn the_bootstrap_is_deterministic() {
        let values = [0.1, 0.9, 0.4];
        assert_eq!(
            bootstrap_interval(&values, 7),
            bootstrap_interval(&values, 7)
        );
        assert_ne!(
            bootstrap_interval(&[0.0, 0.1, 0.3, 0.7], 7),
            bootstrap_interval(&[0.0, 0.1, 0.3, 0.8], 7)
        );
        assert_eq!(bootstrap_interval(&[0.5], 7), None);
        assert_eq!(bootstrap_interval(&[0.5, 0.5], 7), Some([0.5, 0.5]));
    }
}
