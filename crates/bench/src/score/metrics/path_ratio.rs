//! SPL, after Anderson et al., *On Evaluation of Embodied Navigation Agents* (arXiv 1807.06757).

/// `S * l / max(p, l)` for one delivery: `shortest` and `driven` in metres. A robot that had nowhere to go and did not
/// move drove the shortest path; a shortest path that does not exist makes the ratio zero.
pub fn path_ratio(success: bool, shortest: f64, driven: f64) -> f64 {
    let longest = driven.max(shortest);
    match (success, longest > 0.0) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) if shortest.is_finite() && longest.is_finite() => shortest / longest,
        (true, true) => 0.0,
    }
}

/// SPL: the mean of the ratios; `None` without deliveries.
pub fn spl(ratios: &[f64]) -> Option<f64> {
    (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detours_cost_and_failures_count_nothing() {
        assert_eq!(path_ratio(true, 10.0, 20.0), 0.5);
        assert_eq!(
            path_ratio(true, 10.0, 8.0),
            1.0,
            "no more than 1 where the goal's radius cut the way short"
        );
        assert_eq!(path_ratio(false, 10.0, 10.0), 0.0);
        assert_eq!(path_ratio(true, 0.0, 0.0), 1.0);
        assert_eq!(path_ratio(true, 0.0, 1.0), 0.0);
        assert_eq!(path_ratio(true, f64::INFINITY, 1.0), 0.0);
    }

    #[test]
    fn spl_is_the_mean() {
        assert_eq!(spl(&[1.0, 0.5, 0.0]), Some(0.5));
        assert_eq!(spl(&[]), None);
    }
}
