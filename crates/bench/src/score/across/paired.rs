//! Statistics of pairs: two systems in the same episodes.

use crate::score::statistics::{MIN_EPISODES, resampled_means, wilson_interval};

/// Above this number of clusters that differ, the normal distribution is exact enough.
const EXACT_UP_TO: usize = 2000;
/// 97.5 % quantile of the standard normal distribution: tests at 5 %, two-sided.
const Z_LEVEL: f64 = 1.959_963_984_540_054;
/// 80 % quantile of the standard normal distribution: the usual power.
const Z_POWER: f64 = 0.841_621_233_572_914;

/// The percentile bootstrap interval of the mean of clustered values, see
/// [`bootstrap_interval`](crate::score::statistics::bootstrap_interval); `None` for fewer than
/// [`MIN_EPISODES`] clusters, or where all values are equal, since resamples show no spread then.
pub fn interval_of_mean(clusters: &[Vec<f64>], seed: u64) -> Option<[f64; 2]> {
    let mut values = clusters.iter().flatten();
    let first = values.next()?;
    if clusters.len() < MIN_EPISODES || values.all(|value| value == first) {
        return None;
    }
    resampled_means(clusters, seed)
}

/// The interval of the mean difference between two shares: as [`interval_of_mean`]; where all
/// differences are equal, the share of clusters that differ from them is still unknown. It is at
/// most the upper bound of Wilson's interval for none of so many, and such a cluster may differ as
/// far as -1 or 1.
///
/// ```
/// use openbench_bench::score::across::paired::interval_of_share_difference;
///
/// // Two systems that did the same in ten episodes.
/// let same = vec![vec![0.0]; 10];
/// let [low, high] = interval_of_share_difference(&same, 1).unwrap();
/// assert!((high - 0.278).abs() < 1e-3 && low == -high);
/// ```
pub fn interval_of_share_difference(clusters: &[Vec<f64>], seed: u64) -> Option<[f64; 2]> {
    let first = *clusters.iter().flatten().next()?;
    if clusters.len() >= MIN_EPISODES && clusters.iter().flatten().all(|value| *value == first) {
        let [_, share] = wilson_interval(0, clusters.len())?;
        let error = share * (1.0 + first.abs());
        return Some([(first - error).max(-1.0), (first + error).min(1.0)]);
    }
    interval_of_mean(clusters, seed)
}

/// The two-sided p-value of McNemar's exact test (Q. McNemar, Psychometrika 12, 1947), where whole
/// clusters are flipped: under the null hypothesis, a cluster's difference is as likely to be
/// negative as positive.
///
/// `differences` has a number for each cluster: in how many pairs the second system alone
/// succeeded, less those in which the first alone did. With one pair in each cluster, this is
/// McNemar's test. Above 2000 clusters that differ, the normal approximation is used.
///
/// ```
/// use openbench_bench::score::across::paired::mcnemar;
///
/// // The first system alone succeeded once, the second one alone six times: 2 (1 + 7) / 2^7.
/// let differences = [-1, 1, 1, 1, 1, 1, 1, 0, 0];
/// assert!((mcnemar(&differences) - 0.125).abs() < 1e-12);
/// assert_eq!(mcnemar(&[0, 0]), 1.0);
/// ```
pub fn mcnemar(differences: &[i64]) -> f64 {
    let sizes = differences.iter().map(|d| d.unsigned_abs() as usize);
    let reach: usize = sizes.clone().sum();
    let observed = differences.iter().sum::<i64>().unsigned_abs() as usize;
    if differences.iter().filter(|d| **d != 0).count() > EXACT_UP_TO {
        let squares: f64 = sizes.map(|size| (size * size) as f64).sum();
        return libm::erfc(observed as f64 / libm::sqrt(2.0 * squares));
    }
    // The probability of each sum of flipped differences, from -reach to reach.
    let mut chances = vec![0.0; 2 * reach + 1];
    chances[reach] = 1.0;
    for size in sizes.filter(|size| *size > 0) {
        let mut next = vec![0.0; chances.len()];
        for (sum, chance) in chances
            .iter()
            .enumerate()
            .filter(|(_, chance)| **chance > 0.0)
        {
            // No sum of some of them leads beyond the sum of all.
            next[sum - size] += chance / 2.0;
            next[sum + size] += chance / 2.0;
        }
        chances = next;
    }
    let as_far = |sum: usize| sum.abs_diff(reach) >= observed;
    let sums = chances.iter().enumerate().filter(|(sum, _)| as_far(*sum));
    // Only rounding can lead above 1.
    sums.map(|(_, chance)| chance).sum::<f64>().min(1.0)
}

/// The lowest p-value that [`mcnemar`] can have for so many clusters: that of systems of which one
/// alone succeeds in all of them.
///
/// ```
/// use openbench_bench::score::across::paired::lowest_p;
///
/// // Five worlds show nothing at 5 %, whatever happens in them.
/// assert_eq!((lowest_p(5), lowest_p(6)), (0.0625, 0.03125));
/// ```
pub fn lowest_p(clusters: usize) -> f64 {
    libm::pow(0.5, clusters as f64 - 1.0).min(1.0)
}

/// The p-values of several tests, adjusted so that the chance of any false discovery is that of one
/// test (S. Holm, Scandinavian Journal of Statistics 6, 1979).
///
/// ```
/// use openbench_bench::score::across::paired::holm;
///
/// assert_eq!(holm(&[0.01, 0.5, 0.25]), [0.03, 0.5, 0.5]);
/// ```
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut largest = 0.0_f64;
    for (rank, &test) in order.iter().enumerate() {
        let left = (p.len() - rank) as f64;
        largest = largest.max((left * p[test]).min(1.0));
        adjusted[test] = largest;
    }
    adjusted
}

/// The number of pairs in which McNemar's test at 5 % finds a difference of two success rates with
/// a probability of 80 % (R. J. Connor, Biometrics 43, 1987).
///
/// `difference` is that of the rates, above 0; `disagreement` the share of pairs in which exactly
/// one system succeeds. It is no less than the difference.
///
/// ```
/// use openbench_bench::score::across::paired::pairs_to_tell;
///
/// // Two points apart, if one of ten episodes ends differently.
/// assert_eq!(pairs_to_tell(0.02, 0.1), 1960);
/// ```
pub fn pairs_to_tell(difference: f64, disagreement: f64) -> usize {
    let disagreement = disagreement.max(difference);
    let spread = libm::sqrt((disagreement - difference * difference).max(0.0));
    let sum = Z_LEVEL * libm::sqrt(disagreement) + Z_POWER * spread;
    libm::ceil(sum * sum / (difference * difference)) as usize
}

/// The share of pairs in which two systems with these success rates disagree if they succeed
/// independently: what is assumed before anything is measured.
pub fn independent_disagreement(first: f64, second: f64) -> f64 {
    first * (1.0 - second) + second * (1.0 - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two-sided binomial test that McNemar's exact test is.
    fn binomial(first_alone: u32, second_alone: u32) -> f64 {
        let n = first_alone + second_alone;
        let choose = |k: u32| (0..k).fold(1.0, |c, i| c * f64::from(n - i) / f64::from(i + 1));
        let tail: f64 = (0..=first_alone.min(second_alone)).map(choose).sum();
        (2.0 * tail / libm::pow(2.0, f64::from(n))).min(1.0)
    }

    #[test]
    fn single_pairs_give_the_binomial_test() {
        for (first, second) in [(0, 5), (3, 9), (7, 7), (1, 0), (12, 30)] {
            let mut differences = vec![-1; first as usize];
            differences.extend(vec![1; second as usize]);
            let p = mcnemar(&differences);
            assert!(
                (p - binomial(first, second)).abs() < 1e-12,
                "{first} {second}: {p}"
            );
        }
    }

    #[test]
    fn pairs_of_a_cluster_count_as_one() {
        // Ten pairs that agree with each other say no more than one.
        assert_eq!(mcnemar(&[10]), 1.0);
        assert_eq!(mcnemar(&[10, 10]), mcnemar(&[1, 1]));
        // 2 of the 8 signs of 3, 2 and 1 reach 6.
        assert_eq!(mcnemar(&[3, 2, 1]), 0.25);
        // Also where they are many pairs in few clusters.
        assert_eq!(mcnemar(&[1001; 5]), 0.0625);
    }

    #[test]
    fn no_outcome_has_a_lower_p_than_the_lowest() {
        for clusters in 0..12 {
            let p = mcnemar(&vec![1; clusters]);
            assert!((p - lowest_p(clusters)).abs() < 1e-12, "{clusters}");
            let unequal: Vec<i64> = (1..=clusters as i64).collect();
            assert!(mcnemar(&unequal) >= p - 1e-12, "{clusters}");
        }
    }

    #[test]
    fn many_pairs_are_tested_by_the_normal_distribution() {
        // The exact test of so many, just below the limit, is close to the approximation above.
        let differences = |second: usize| {
            let mut all = vec![-1; 950];
            all.extend(vec![1; second]);
            all
        };
        let (exact, normal) = (mcnemar(&differences(1050)), mcnemar(&differences(1051)));
        assert!(exact > 0.0255 && exact < 0.0275, "{exact}");
        assert!(normal > 0.0225 && normal < 0.0255, "{normal}");
        let hostile = vec![1; 300_000];
        assert_eq!(mcnemar(&hostile), 0.0);
    }

    #[test]
    fn adjusted_values_keep_their_order() {
        assert_eq!(holm(&[]), Vec::<f64>::new());
        assert_eq!(holm(&[0.04, 0.03]), [0.06, 0.06]);
        assert_eq!(holm(&[0.9, 0.8]), [1.0, 1.0]);
    }

    #[test]
    fn a_difference_that_varies_has_a_bootstrap_interval() {
        let clusters: Vec<Vec<f64>> = (0..20).map(|i| vec![f64::from(i % 4)]).collect();
        let [low, high] = interval_of_mean(&clusters, 1).unwrap();
        assert!(low < 1.5 && 1.5 < high);
        assert_eq!(interval_of_mean(&clusters[..4], 1), None);
        assert_eq!(interval_of_mean(&vec![vec![2.0]; 20], 1), None);
        let [low, high] = interval_of_share_difference(&vec![vec![1.0]; 20], 1).unwrap();
        assert!(low > 0.6 && low < 0.7 && high == 1.0);
    }

    #[test]
    fn more_disagreement_takes_more_pairs() {
        assert!(pairs_to_tell(0.02, 0.2) > pairs_to_tell(0.02, 0.1));
        // Where every disagreement is in one direction, z² / d² and little else is left.
        assert!(pairs_to_tell(0.5, 0.1) < 20);
        assert!((independent_disagreement(0.9, 0.8) - 0.26).abs() < 1e-12);
    }
}
