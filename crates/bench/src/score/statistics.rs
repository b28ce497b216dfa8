//! 95 % confidence intervals: Wilson for rates of independent trials, the percentile bootstrap for
//! everything else.
//!
//! What happens in an episode is correlated, so the bootstrap resamples whole episodes. Below
//! [`MIN_EPISODES`] nothing is said: with so few, neither method holds what it promises.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;
/// Number of resamples of the bootstrap.
const RESAMPLES: usize = 10_000;
/// Fewest episodes, or other independent units, for an interval.
pub const MIN_EPISODES: usize = 5;

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
    wilson_bounds(successes as f64 / trials as f64, trials as f64)
}

/// The Wilson score interval of the rate `p` of `n` trials.
fn wilson_bounds(p: f64, n: f64) -> Option<[f64; 2]> {
    // The bounds are the solutions p0 of (p - p0)² = Z² p0 (1 - p0) / n.
    let scale = 1.0 + Z * Z / n;
    let centre = (p + Z * Z / (2.0 * n)) / scale;
    let half = Z / scale * libm::sqrt(p * (1.0 - p) / n + Z * Z / (4.0 * n * n));
    // Only rounding can lead beyond 0 and 1.
    Some([(centre - half).max(0.0), (centre + half).min(1.0)])
}

/// The interval of a rate of independent trials; `None` for fewer than [`MIN_EPISODES`].
pub fn rate_interval(rate: Proportion) -> Option<[f64; 2]> {
    let enough = rate.trials >= MIN_EPISODES;
    wilson_interval(rate.successes, rate.trials).filter(|_| enough)
}

/// The interval of the mean of values between 0 and 1 by episode: that of a rate where each episode
/// has one value and all values are 0 or 1, the bootstrap's otherwise.
pub fn mean_interval(episodes: &[Vec<f64>], seed: u64) -> Option<[f64; 2]> {
    let are_trials = episodes
        .iter()
        .all(|episode| matches!(episode[..], [value] if value == 0.0 || value == 1.0));
    if are_trials {
        rate_interval(Proportion::count(episodes, |episode| episode[0] == 1.0))
    } else {
        bootstrap_interval(episodes, seed)
    }
}

/// The percentile bootstrap interval of a mean of values between 0 and 1, lower and upper bound,
/// from 10,000 resamples drawn from `seed`; `None` for fewer than [`MIN_EPISODES`] clusters.
///
/// Each cluster has the values of an episode. Clusters are resampled as a whole (the cluster
/// bootstrap: A. C. Davison and D. V. Hinkley, *Bootstrap Methods and their Application*, 1997,
/// section 3.8); the mean is that of all values in them.
///
/// Where all values are equal, resamples show no spread, although further episodes may differ.
/// Then the Wilson interval for as many trials as clusters is returned. It is wide enough, since
/// no values between 0 and 1 vary more than successes and failures of the same mean.
///
/// ```
/// use openbench_bench::score::statistics::bootstrap_interval;
///
/// let episodes: Vec<Vec<f64>> = [0.7, 0.9, 0.8, 0.6, 1.0].map(|ratio| vec![ratio]).into();
/// let [low, high] = bootstrap_interval(&episodes, 1).unwrap();
/// assert!(0.6 < low && low < 0.8 && 0.8 < high && high < 1.0);
/// assert_eq!(bootstrap_interval(&episodes[..4], 1), None);
/// ```
pub fn bootstrap_interval(clusters: &[Vec<f64>], seed: u64) -> Option<[f64; 2]> {
    let filled = clusters
        .iter()
        .filter(|cluster| !cluster.is_empty())
        .count();
    if filled < MIN_EPISODES {
        return None;
    }
    let mut values = clusters.iter().flatten();
    let first = *values.next()?;
    if values.all(|value| *value == first) {
        return wilson_bounds(first, filled as f64);
    }
    resampled_means(clusters, seed)
}

/// The range of 95 % of the means of resampled clusters; `None` without values.
pub(super) fn resampled_means(clusters: &[Vec<f64>], seed: u64) -> Option<[f64; 2]> {
    let filled = clusters.iter().filter(|cluster| !cluster.is_empty());
    let sums: Vec<ClusterSum> = filled.map(|cluster| ClusterSum::of(cluster)).collect();
    if sums.is_empty() {
        return None;
    }
    let mut random = Pcg32::seed_from_u64(seed);
    let mut means: Vec<f64> = (0..RESAMPLES)
        .map(|_| resampled_mean(&sums, &mut random))
        .collect();
    means.sort_by(f64::total_cmp);
    let quantile = |q: f64| means[libm::round(q * (RESAMPLES - 1) as f64) as usize];
    Some([quantile(0.025), quantile(0.975)])
}

/// Sum and number of the values of a cluster.
#[derive(Debug, Clone, Copy)]
struct ClusterSum {
    sum: f64,
    count: f64,
}

impl ClusterSum {
    fn of(values: &[f64]) -> Self {
        Self {
            sum: values.iter().sum(),
            count: values.len() as f64,
        }
    }
}

fn resampled_mean(clusters: &[ClusterSum], random: &mut Pcg32) -> f64 {
    let n = clusters.len() as u64;
    // Multiply-shift: one random number for each draw. Its bias, below n / 2^32, is negligible.
    let draw = |_| clusters[((u64::from(random.next_u32()) * n) >> 32) as usize];
    let add = |all: ClusterSum, one: ClusterSum| ClusterSum {
        sum: all.sum + one.sum,
        count: all.count + one.count,
    };
    let nothing = ClusterSum::of(&[]);
    let all = (0..clusters.len()).map(draw).fold(nothing, add);
    all.sum / all.count
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

    /// Clusters of one value each.
    fn single(values: &[f64]) -> Vec<Vec<f64>> {
        values.iter().map(|value| vec![*value]).collect()
    }

    #[test]
    fn the_bootstrap_agrees_with_the_normal_interval_for_many_values() {
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 20) / 19.0).collect();
        // Mean 0.5, standard deviation of 20 equal steps 0.30349, standard error / 20.
        let half = Z * 0.30349 / 20.0;
        let interval = bootstrap_interval(&single(&values), 1).unwrap();
        assert!(
            close(interval, [0.5 - half, 0.5 + half], 2e-3),
            "{interval:?}"
        );
    }

    #[test]
    fn values_of_an_episode_count_as_one() {
        // Each value five times: as many independent values would give a narrower interval.
        let few: Vec<f64> = (0..20).map(|i| f64::from(i) / 19.0).collect();
        let clusters: Vec<Vec<f64>> = few.iter().map(|value| vec![*value; 5]).collect();
        let width = |[low, high]: [f64; 2]| high - low;
        let clustered = width(bootstrap_interval(&clusters, 1).unwrap());
        assert!((clustered - width(bootstrap_interval(&single(&few), 1).unwrap())).abs() < 1e-9);
        let all: Vec<f64> = clusters.concat();
        let independent = width(bootstrap_interval(&single(&all), 1).unwrap());
        assert!(independent < 0.6 * clustered, "{independent} {clustered}");
    }

    #[test]
    fn equal_values_have_an_interval_of_some_width_and_few_have_none() {
        assert_eq!(bootstrap_interval(&single(&[0.5; 4]), 7), None);
        assert_eq!(
            bootstrap_interval(&[vec![0.1, 0.2, 0.3, 0.4, 0.5]], 7),
            None
        );
        let ones = bootstrap_interval(&single(&[1.0; 5]), 7);
        assert_eq!(ones, wilson_interval(5, 5));
        let [low, high] = bootstrap_interval(&single(&[0.5; 6]), 7).unwrap();
        assert!(low < 0.3 && high > 0.7, "{low} {high}");
    }

    #[test]
    fn the_bootstrap_is_deterministic() {
        let values = single(&[0.1, 0.9, 0.4, 0.3, 0.2]);
        assert_eq!(
            bootstrap_interval(&values, 7),
            bootstrap_interval(&values, 7)
        );
        assert_ne!(
            bootstrap_interval(&single(&[0.0, 0.1, 0.3, 0.7, 0.2]), 7),
            bootstrap_interval(&single(&[0.0, 0.1, 0.3, 0.8, 0.2]), 7)
        );
    }
}
