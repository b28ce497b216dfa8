//! How noisy the LiDAR turns out to be: points that are scattered more widely than its data sheet
//! says count less.
//!
//! A filter that trusts noisier points as if they were sound arrives at wrong poses, biases and
//! headings with high certainty. One that rejects them has no measurements. The residuals say how
//! wide the scatter is (R. Mehra, *On the Identification of Variances and Adaptive Kalman
//! Filtering*, 1970: noise from innovations).

use super::scan_match::ScanMatch;

/// Mean square of residuals, in standard deviations, of a LiDAR that is as noisy as stated: above 1
/// since surfaces are not quite even.
const USUAL_FIT: f64 = 1.1;
/// Weight of a new scan in the mean: one over the number of scans that it is taken over.
const SCAN_WEIGHT: f64 = 1.0 / 10.0;
/// A smaller factor is not applied.
const MIN_APPLIED: f64 = 1.25;
/// A larger factor is not trusted.
const MAX_FACTOR: f64 = 15.0;
/// A smaller share of points on planes is taken for this one.
const MIN_AGREEING: f64 = 0.2;
/// From this factor on, the LiDAR is reported as noisy.
const NOISY: f64 = 2.5;
/// A scan with fewer points on planes says nothing of the noise.
const MIN_POINTS: usize = 200;

/// The LiDAR's noise as a multiple of what its data sheet says.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoiseScale(f64);

impl Default for NoiseScale {
    fn default() -> Self {
        Self(1.0)
    }
}

impl NoiseScale {
    /// Learns from a scan, matched with [`factor`](Self::factor).
    pub(super) fn learn(&mut self, matched: &ScanMatch) {
        if matched.points < MIN_POINTS || !matched.fit.is_finite() {
            return;
        }
        // Residuals beyond the gate are missing. The fewer points pass it, the wider the scatter.
        let by_residuals = self.factor() * (matched.fit / USUAL_FIT).sqrt();
        let seen = by_residuals / matched.agreeing.max(MIN_AGREEING);
        self.0 = (self.0 + SCAN_WEIGHT * (seen - self.0)).clamp(1.0, MAX_FACTOR);
    }

    /// The factor that the LiDAR's standard deviations are to be multiplied by.
    pub(super) fn factor(self) -> f64 {
        if self.0 < MIN_APPLIED { 1.0 } else { self.0 }
    }

    /// Whether the LiDAR is so noisy that an estimate should say so.
    pub(super) fn is_noisy(self) -> bool {
        self.0 >= NOISY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matched(points: usize, agreeing: f64, fit: f64) -> ScanMatch {
        ScanMatch {
            points,
            agreeing,
            fit,
            degenerate: vec![],
            innovation: 1.0,
        }
    }

    /// The scale after many scans of a LiDAR whose residuals have this mean square by its data
    /// sheet, and this share of points within the gate.
    fn settled(fit: f64, agreeing: f64) -> NoiseScale {
        let mut scale = NoiseScale::default();
        for _ in 0..200 {
            let fit = fit / scale.factor().powi(2);
            scale.learn(&matched(9000, agreeing, fit));
        }
        scale
    }

    #[test]
    fn the_scale_follows_the_noise() {
        // Medians of fit and share on a drive in `large` with noise of 1, 2, 5 and 10 times the
        // data sheet's.
        assert_eq!(settled(1.11, 0.99).factor(), 1.0);
        let found = [(2.65, 0.97), (4.07, 0.77), (4.28, 0.59)];
        let found = found.map(|(fit, agreeing)| settled(fit, agreeing));
        let increases = |pair: &[NoiseScale]| pair[0].factor() < pair[1].factor();
        assert!(found.windows(2).all(increases), "{found:?}");
        assert!(!found[0].is_noisy());
        assert_eq!(found[1].is_noisy(), found[1].factor() >= NOISY);
        assert!(found[2].is_noisy());
        assert!(settled(1e9, 0.01).factor() <= MAX_FACTOR);
    }

    #[test]
    fn few_points_say_nothing() {
        let mut scale = NoiseScale::default();
        scale.learn(&matched(60, 0.1, 100.0));
        scale.learn(&matched(9000, 1.0, f64::NAN));
        assert_eq!(scale.factor(), 1.0);
    }
}
