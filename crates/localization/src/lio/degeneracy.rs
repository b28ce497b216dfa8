//! Directions along which a scan does not say where it is.
//!
//! Two smooth walls have normals that are tilted forwards and back by chance, and seem to say how
//! far the robot has come between them.

use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

use super::state::at;

/// Information is real if it is at least this many times what is feigned.
const MIN_REAL: f64 = 1.0;
/// A direction with no more than this share of the best direction's information is degenerate.
const MIN_SHARE: f64 = 1e-4;

/// Directions of which the information about the position says little: no more than `feigned`, what
/// the tilt of the planes' normals feigns, or hardly anything beside the best direction.
pub(super) fn degenerate_directions(
    information: &Matrix3<f64>,
    feigned: &Matrix3<f64>,
) -> Vec<Vector3<f64>> {
    let eigen = SymmetricEigen::new(*information);
    let best = eigen.eigenvalues.max();
    let mut degenerate = Vec::new();
    for i in 0..3 {
        let known = eigen.eigenvalues[i];
        // The eigenvalue is the information about the position along its eigenvector.
        let direction = eigen.eigenvectors.column(i).into_owned();
        let is_feigned = known < MIN_REAL * direction.dot(&(feigned * direction));
        if known <= best * MIN_SHARE || is_feigned {
            degenerate.push(direction);
        }
    }
    degenerate
}

/// Removes what is measured of the position along a direction (J. Zhang, M. Kaess, S. Singh, *On
/// Degeneracy of Optimization-based State Estimation Problems*, 2016).
pub(super) fn remove<const N: usize>(
    information: &mut SMatrix<f64, N, N>,
    gradient: &mut SVector<f64, N>,
    direction: &Vector3<f64>,
) {
    let others = Matrix3::identity() - direction * direction.transpose();
    let mut keep = SMatrix::<f64, N, N>::identity();
    keep.fixed_view_mut::<3, 3>(at::POSITION, at::POSITION)
        .copy_from(&others);
    *information = keep * *information * keep;
    *gradient = keep * *gradient;
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix6;

    #[test]
    fn what_normals_feign_is_no_measurement() {
        let information = Matrix3::from_diagonal(&Vector3::new(5.0, 1e5, 1e5));
        let feigned = Matrix3::from_diagonal(&Vector3::new(6.0, 10.0, 10.0));
        let found = degenerate_directions(&information, &feigned);
        assert_eq!(found.len(), 1);
        assert!(found[0].x.abs() > 0.999, "{found:?}");
        let feigned = feigned * 0.5;
        let corridor = degenerate_directions(&information, &feigned);
        assert_eq!(corridor.len(), 1, "five parts in a hundred thousand");
        let information = Matrix3::from_diagonal(&Vector3::new(50.0, 1e5, 1e5));
        assert!(degenerate_directions(&information, &feigned).is_empty());
    }

    #[test]
    fn only_the_position_along_the_direction_is_removed() {
        let mut information = Matrix6::identity();
        let mut gradient = SVector::<f64, 6>::repeat(1.0);
        remove(&mut information, &mut gradient, &Vector3::y());
        let mut expected = Matrix6::identity();
        expected[(4, 4)] = 0.0;
        assert_eq!(information, expected);
        assert_eq!(gradient[4], 0.0);
        assert_eq!(gradient.sum(), 5.0);
    }
}
