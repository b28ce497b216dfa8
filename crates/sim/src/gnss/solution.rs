//! From pseudoranges to a position, by weighted least squares (Misra and Enge, chapter 6).

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// A fix whose dilution of precision is worse is none.
const WORST_DILUTION: f64 = 20.0;

/// A pseudorange: its error is all that the solution needs to know, since the geometry is linear over metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    /// Towards the satellite: east, north, up.
    pub(super) direction: Vector3<f64>,
    /// Error, metres.
    pub(super) error: f64,
    /// Deviation that the receiver believes in, metres.
    pub(super) deviation: f64,
}

/// Where the solution lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Solution {
    /// From the truth, metres.
    pub(super) error: Vector3<f64>,
    /// What the receiver believes of that, m².
    pub(super) covariance: Matrix3<f64>,
}

/// Position and clock from at least four ranges; `None` if they are fewer or lie badly.
pub(super) fn solve(ranges: &[Range]) -> Option<Solution> {
    if ranges.len() < 4 {
        return None;
    }
    let row = |r: &Range| Vector4::new(-r.direction.x, -r.direction.y, -r.direction.z, 1.0);
    let plain: Matrix4<f64> = ranges.iter().map(|r| row(r) * row(r).transpose()).sum();
    // The position dilution of precision.
    let shape = plain.try_inverse()?;
    let dilution = (0..3).map(|i| shape[(i, i)]).sum::<f64>().sqrt();
    if dilution.is_nan() || dilution > WORST_DILUTION {
        return None;
    }
    let weight = |r: &Range| 1.0 / (r.deviation * r.deviation);
    let normal: Matrix4<f64> = ranges
        .iter()
        .map(|r| row(r) * row(r).transpose() * weight(r))
        .sum();
    let right: Vector4<f64> = ranges.iter().map(|r| row(r) * (r.error * weight(r))).sum();
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
    fn an_error_of_all_ranges_is_the_clock_s() {
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
        // The deviation of 2 m, likewise.
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
