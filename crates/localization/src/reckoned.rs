//! Where a robot is by odometry, and how well odometry knows that.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen};
use openbench_core::Pose2;

/// A pose in `odom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reckoned {
    pub pose: Pose2,
    /// Of x and y in `odom`, and yaw.
    pub covariance: Matrix3<f64>,
}

impl Reckoned {
    /// Covariance of the motion since an earlier pose, in the frame of this one (forward, left,
    /// yaw): how much that of the odometry grew.
    pub fn growth_since(&self, earlier: &Self) -> Matrix3<f64> {
        let dx = self.pose.x - earlier.pose.x;
        let dy = self.pose.y - earlier.pose.y;
        // A heading error at the earlier pose displaces this one by the lever between both.
        let carried = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let grown = self.covariance - carried * earlier.covariance * carried.transpose();
        let turn = rotating(self.pose.yaw);
        let mut eigen = SymmetricEigen::new(turn.transpose() * grown * turn);
        // Where a pose is known better later, as when a scan fits the map again, odometry took back
        // by as much what it had said between.
        eigen.eigenvalues.apply(|value| *value = value.abs());
        eigen.recompose()
    }

    /// Sum of the variances of x and y, m².
    pub fn level_variance(&self) -> f64 {
        level_variance(&self.covariance)
    }
}

/// Sum of the variances of x and y, m².
pub(crate) fn level_variance(covariance: &Matrix3<f64>) -> f64 {
    covariance[(0, 0)] + covariance[(1, 1)]
}

/// Rotates x and y, leaves yaw.
pub(crate) fn rotating(yaw: f64) -> Matrix3<f64> {
    let (sine, cosine) = libm::sincos(yaw);
    let mut turn = Matrix3::identity();
    let level = Matrix2::new(cosine, -sine, sine, cosine);
    turn.fixed_view_mut::<2, 2>(0, 0).copy_from(&level);
    turn
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn a_motion_is_as_uncertain_as_its_end_is_more_than_its_beginning() {
        let at = |x: f64, yaw: f64, forward: f64, left: f64| Reckoned {
            pose: Pose2::new(x, 0.0, yaw),
            covariance: {
                let own = Matrix3::from_diagonal(&[forward, left, 1e-6].into());
                rotating(yaw) * own * rotating(yaw).transpose()
            },
        };
        let grown = at(0.0, FRAC_PI_2, 0.09, 0.01).growth_since(&at(0.0, FRAC_PI_2, 0.05, 0.01));
        assert!((grown[(0, 0)] - 0.04).abs() < 1e-12, "{grown}");
        assert!(grown[(1, 1)].abs() < 1e-12, "{grown}");
        // An error of the heading displaces what lies ten metres ahead. That is no drift.
        let mut ahead = at(10.0, 0.0, 0.0, 1e-4);
        (ahead.covariance[(1, 2)], ahead.covariance[(2, 1)]) = (1e-5, 1e-5);
        let grown = ahead.growth_since(&at(0.0, 0.0, 0.0, 0.0));
        assert!(grown.norm() < 1e-12, "{grown}");
    }
}
