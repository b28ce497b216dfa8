//! SPL, success weighted by path length: `1/N sum S_i l_i / max(p_i, l_i)`.
//!
//! Source: P. Anderson et al., *On Evaluation of Embodied Navigation Agents*, arXiv 1807.06757.

/// `S * l / max(p, l)` of one delivery, where `l` is the `shortest` path and `p` the `driven` path,
/// in metres.
///
/// If both are zero, the ratio is 1. If there is no shortest path (infinite), it is 0.
///
/// ```
/// use openbench_bench::score::metrics::{path_ratio, spl};
///
/// // The door is 30 m away; the robots drove 40 m, 30 m, and 35 m without success.
/// let ratios = [
///     path_ratio(true, 30.0, 40.0),
///     path_ratio(true, 30.0, 30.0),
///     path_ratio(false, 30.0, 35.0),
/// ];
/// assert_eq!(ratios, [0.75, 1.0, 0.0]);
/// assert_eq!(spl(&ratios), Some(1.75 / 3.0));
/// ```
pub fn path_ratio(success: bool, shortest: f64, driven: f64) -> f64 {
    let longest = driven.max(shortest);
    match (success, longest > 0.0) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        // Infinity divided by infinity would be NaN.
        (true, true) if shortest.is_finite() && longest.is_finite() => shortest / longest,
        (true, true) => 0.0,
    }
}

/// SPL: the mean of the path ratios; `None` without deliveries.
pub fn spl(ratios: &[f64]) -> Option<f64> {
    (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detours_lower_the_ratio_and_failures_are_zero() {
        assert_eq!(path_ratio(true, 10.0, 20.0), 0.5);
        assert_eq!(
            path_ratio(true, 10.0, 8.0),
            1.0,
            "at most 1, even if the radius of success shortens the path"
        );
        assert_eq!(path_ratio(false, 10.0, 10.0), 0.0);
        assert_eq!(path_ratio(true, 0.0, 0.0), 1.0);
        assert_eq!(path_ratio(true, 0.0, 1.0), 0.0);
        assert_eq!(path_ratio(true, f64::INFINITY, 1.0), 0.0);
    }

    #[test]
    fn spl_is_the_mean_of_the_ratios() {
        assert_eq!(spl(&[1.0, 0.5, 0.0]), Some(0.5));
        assert_eq!(spl(&[]), None);
    }
}
