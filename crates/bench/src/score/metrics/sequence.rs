//! LSR and LSPL: success over a sequence of deliveries, where earlier deliveries weigh more.
//!
//! `c_i = r^(i-1) (1-r) / (1-r^n)` with r = 0.9, and `LSR = sum c_i S_i / sum c_i`; LSPL likewise
//! with the path ratio (OpenBench, arXiv 2502.09238). The paper prints a leading 1/N, which can
//! only be the number of sequences: its table has 100 % for five of five. Both are therefore the
//! mean over the sequences of a suite.

/// Ratio r of consecutive weights.
const DECAY: f64 = 0.9;

/// The weights `c_1` to `c_n` of a sequence of `n` deliveries; their sum is 1.
fn sequence_weights(n: usize) -> Vec<f64> {
    let powers: Vec<f64> = (0..n)
        .scan(1.0, |p, _| Some(std::mem::replace(p, *p * DECAY)))
        .collect();
    // sum r^(i-1) = (1-r^n) / (1-r)
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|p| p / sum).collect()
}

/// LSR of one sequence from its successes (0 or 1), or LSPL from its path ratios, in driving order;
/// `None` for an empty sequence.
///
/// The paper's table has 75.58 % for a sequence whose first delivery fails, and 83.98 % for one
/// whose last delivery fails:
///
/// ```
/// use openbench_bench::score::metrics::sequence_mean;
///
/// let percent = |lsr: f64| (lsr * 10_000.0).round() / 100.0;
/// assert_eq!(sequence_mean(&[0.0, 1.0, 1.0, 1.0, 1.0]).map(percent), Some(75.58));
/// assert_eq!(sequence_mean(&[1.0, 1.0, 1.0, 1.0, 0.0]).map(percent), Some(83.98));
/// ```
pub fn sequence_mean(values: &[f64]) -> Option<f64> {
    let weighted = sequence_weights(values.len())
        .into_iter()
        .zip(values)
        .map(|(c, v)| c * v);
    (!values.is_empty()).then(|| weighted.sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn percent(successes: [f64; 5]) -> f64 {
        libm::round(sequence_mean(&successes).unwrap() * 10_000.0) / 100.0
    }

    #[test]
    fn the_papers_table_is_reproduced() {
        assert_eq!(percent([1.0, 1.0, 1.0, 1.0, 1.0]), 100.0);
        assert_eq!(percent([0.0, 1.0, 1.0, 1.0, 1.0]), 75.58);
        assert_eq!(percent([1.0, 1.0, 1.0, 1.0, 0.0]), 83.98);
    }

    #[test]
    fn weights_are_the_papers() {
        let n = 5;
        for (i, c) in sequence_weights(n).into_iter().enumerate() {
            let equation =
                libm::pow(DECAY, i as f64) * (1.0 - DECAY) / (1.0 - libm::pow(DECAY, n as f64));
            assert!((c - equation).abs() < 1e-15);
        }
        assert_eq!(sequence_weights(1), [1.0]);
        assert_eq!(sequence_mean(&[]), None);
    }
}
