//! From pseudoranges to a position, by weighted least squares (Misra and Enge, chapter 6).

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Largest position dilution of precision of a fix.
const MAX_DILUTION: f64 = 20.0;

/// A pseudorange. The solution needs only its error, since the geometry is linear over metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    /// Towards the satellite: east, north, up.
    pub(super) direction: Vector3<f64>,
    /// Error, metres.
    pub(super) error: f64,
    /// Standard deviation in the receiver's model, metres.
    pub(super) deviation: f64,
}

impl Range {
    /// The row of the design matrix.
    fn row(&self) -> Vector4<f64> {
        // Derivatives of the range: a step towards the satellite shortens it, a late clock
        // lengthens it.
        Vector4::new(-self.direction.x, -self.direction.y, -self.direction.z, 1.0)
    }

    fn weight(&self) -> f64 {
        1.0 / (self.deviation * self.deviation)
    }
}

/// The position of a fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Solution {
    /// From the true position, metres: east, north, up.
    pub(super) error: Vector3<f64>,
    /// Covariance of the error in the receiver's model, m².
    pub(super) covariance: Matrix3<f64>,
}

/// Position and clock from ranges; `None` with fewer than four or a bad geometry.
pub(super) fn solve(ranges: &[Range]) -> Option<Solution> {
    if ranges.len() < 4 {
        return None;
    }
    // Dilution is that of the unweighted geometry, as receivers report it.
    let plain: Matrix4<f64> = ranges.iter().map(|r| r.row() * r.row().transpose()).sum();
    let shape = plain.try_inverse()?;
    let dilution = (0..3).map(|i| shape[(i, i)]).sum::<f64>().sqrt();
    // Rounding may make a nearly singular inverse negative, whose root is NaN.
    if dilution.is_nan() || dilution > MAX_DILUTION {
        return None;
    }
    // Normal equations (HᵀWH) x = HᵀW e. As the weights are inverse variances, the inverse of HᵀWH
    // is the covariance of x.
    let normal: Matrix4<f64> = ranges
        .iter()
        .map(|r| r.row() * r.row().transpose() * r.weight())
        .sum();
    let right: Vector4<f64> = ranges
        .iter()
        .map(|r| r.row() * (r.error * r.weight()))
        .sum();
    let covariance = normal.try_inverse()?;
    Some(Solution {
        error: (covariance * right).xyz(),
        covariance: covariance.fixed_view::<3, 3>(0, 0).into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges(errors: [f64; 5]) -> Vec<Range> {
        let tilted = |x: f64, y: f64| Vector3::new(x, y, 1.0).normalize();
        let sky = [
            tilted(2.0, 0.0),
            tilted(-2.0, 0.0),
            tilted(0.0, 2.0),
            tilted(0.0, -2.0),
            Vector3::z(),
        ];
        sky.iter()
            .zip(errors)
            .map(|(d, error)| Range {
                direction: *d,
                error,
                deviation: 2.0,
            })
            .collect()
    }

    #[test]
    fn an_error_common_to_all_ranges_is_in_the_clock() {
        let solution = solve(&ranges([7.0; 5])).unwrap();
        assert!(solution.error.norm() < 1e-9);
    }

    #[test]
    fn a_range_that_is_too_long_pushes_the_position_away() {
        let east_is_long = solve(&ranges([3.0, 0.0, 0.0, 0.0, 0.0])).unwrap();
        // Farther from the satellite in the east: two ranges share the 3 m, each 2 / √5 eastwards.
        assert!(
            (east_is_long.error.x + 1.5 / (2.0 / 5.0_f64.sqrt())).abs() < 1e-9,
            "{east_is_long:?}"
        );
        // The deviation of 2 m is shared alike.
        let expected = 2.0 * 2.0 / (2.0 * 4.0 / 5.0);
        assert!(
            (east_is_long.covariance[(0, 0)] - expected).abs() < 1e-9,
            "{east_is_long:?}"
        );
    }

    #[test]
    fn three_ranges_and_ranges_in_a_plane_give_none() {
        assert!(solve(&ranges([0.0; 5])[..3]).is_none());
        let flat: Vec<Range> = ranges([0.0; 5])
            .into_iter()
            .filter(|r| r.direction.y == 0.0)
            .collect();
        assert!(solve(&[flat.clone(), flat].concat()).is_none());
    }
}
