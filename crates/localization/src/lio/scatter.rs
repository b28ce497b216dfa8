//! How noisy the LiDAR turns out to be: points that are scattered more widely than its data sheet
//! says count less.
//!
//! A filter that believes noisier points as if they were sound comes to poses, biases and headings
//! that are surely wrong. One that refuses them has nothing to go by. The residuals say how wide
//! the scatter is (R. Mehra, *On the Identification of Variances and Adaptive Kalman Filtering*,
//! 1970: noise from innovations).

use super::update::Matched;

/// Mean square of residuals, in deviations, of a LiDAR that is as noisy as it is thought to be:
/// surfaces are not quite even.
const USUAL: f64 = 1.1;
/// Mean over about so many scans, as one over it.
const RECENT: f64 = 1.0 / 10.0;
/// Less than that is none, and more is not believed.
const USED: f64 = 1.25;
const WIDEST: f64 = 15.0;
const LEAST_AGREEING: f64 = 0.2;
/// So many times the usual scatter is worth telling.
const WIDE: f64 = 2.5;
/// A scan with fewer points on surfaces says nothing of the scatter.
const FEW: usize = 200;

/// The scatter of points, as a multiple of the usual one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scatter(f64);

impl Default for Scatter {
    fn default() -> Self {
        Self(1.0)
    }
}

impl Scatter {
    /// Takes in how a scan, weighed by [`factor`](Self::factor), lay on the map.
    pub(super) fn look(&mut self, matched: &Matched) {
        if matched.points < FEW || !matched.fit.is_finite() {
            return;
        }
        // What is scattered beyond the gate is not in the residuals: the fewer points pass, the
        // wider it must be.
        let seen =
            self.factor() * (matched.fit / USUAL).sqrt() / matched.agreeing.max(LEAST_AGREEING);
        self.0 = (self.0 + RECENT * (seen - self.0)).clamp(1.0, WIDEST);
    }

    /// So many times the usual deviation points are to be weighed by.
    pub(super) fn factor(self) -> f64 {
        if self.0 < USED { 1.0 } else { self.0 }
    }

    /// Whether the LiDAR is noisier than can be passed over.
    pub(super) fn is_wide(self) -> bool {
        self.0 >= WIDE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What becomes of it with a LiDAR whose residuals have that mean square by its data sheet, and
    /// so many points within the gate.
    fn settled(fit: f64, agreeing: f64) -> Scatter {
        let mut scatter = Scatter::default();
        for _ in 0..200 {
            let fit = fit / scatter.factor().powi(2);
            scatter.look(&Matched {
                points: 9000,
                agreeing,
                fit,
                loose: vec![],
                surprise: 1.0,
            });
        }
        scatter
    }

    #[test]
    fn the_scatter_is_found_out() {
        // Medians of fit and share on a drive in `large` with noise of 1, 2, 5 and 10 times the
        // data sheet's.
        assert_eq!(settled(1.11, 0.99).factor(), 1.0);
        let found = [(2.65, 0.97), (4.07, 0.77), (4.28, 0.59)]
            .map(|(fit, agreeing)| settled(fit, agreeing));
        assert!(
            found
                .windows(2)
                .all(|pair| pair[0].factor() < pair[1].factor()),
            "{found:?}"
        );
        assert!(!found[0].is_wide() && found[1].is_wide() == (found[1].factor() >= WIDE));
        assert!(found[2].is_wide() && settled(1e9, 0.01).factor() <= WIDEST);
    }

    #[test]
    fn few_points_say_nothing() {
        let mut scatter = Scatter::default();
        scatter.look(&Matched {
            points: 60,
            agreeing: 0.1,
            fit: 100.0,
            loose: vec![],
            surprise: 1.0,
        });
        scatter.look(&Matched {
            points: 9000,
            agreeing: 1.0,
            fit: f64::NAN,
            loose: vec![],
            surprise: 1.0,
        });
        assert_eq!(scatter.factor(), 1.0);
    }
}
