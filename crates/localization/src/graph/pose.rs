//! Poses in the plane and in space: SE(2) and SE(3).
//!
//! J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state estimation in robotics*, 2018;
//! equation numbers refer to it. Tangent vectors have the translation first, metres, then the
//! rotation, radians. A pose is perturbed from the right: in its own frame.

use nalgebra::{
    Isometry2, Isometry3, Matrix3, Matrix6, SMatrix, SVector, Vector2, Vector3, Vector6,
};
use openbench_core::frames::wrap_angle;

use crate::so3;

/// A pose with `D` degrees of freedom.
pub trait Pose<const D: usize>: Clone + Send + Sync {
    /// Composition: `other`, which is in this pose's frame, in the frame that this pose is in.
    #[must_use]
    fn then(&self, other: &Self) -> Self;

    /// The inverse.
    #[must_use]
    fn back(&self) -> Self;

    /// The pose after a small motion in its own frame.
    #[must_use]
    fn moved(&self, motion: &SVector<f64, D>) -> Self;

    /// The motion from the identity, as g2o and GTSAM define it: in the plane translation and
    /// angle, in space the logarithm (equation 178).
    fn distance(&self) -> SVector<f64, D>;

    /// Jacobian of [`distance`](Self::distance) by a small motion in the pose's own frame.
    fn distance_jacobian(&self) -> SMatrix<f64, D, D>;

    /// The matrix that converts motions in the pose's frame into motions in the frame that the pose
    /// is in (equations 156 and 175).
    fn adjoint(&self) -> SMatrix<f64, D, D>;
}

impl Pose<3> for Isometry2<f64> {
    fn then(&self, other: &Self) -> Self {
        self * other
    }

    fn back(&self) -> Self {
        self.inverse()
    }

    fn moved(&self, motion: &Vector3<f64>) -> Self {
        let turn = nalgebra::UnitComplex::new(motion.z);
        let there = self.translation.vector + self.rotation * motion.xy();
        let mut rotation = self.rotation * turn;
        // Rounding would add up over the steps of a solution and over the poses of a chain.
        rotation.renormalize();
        Self::from_parts(there.into(), rotation)
    }

    fn distance(&self) -> Vector3<f64> {
        let angle = libm::atan2(self.rotation.im, self.rotation.re);
        Vector3::new(self.translation.x, self.translation.y, wrap_angle(angle))
    }

    fn distance_jacobian(&self) -> Matrix3<f64> {
        let (cosine, sine) = (self.rotation.re, self.rotation.im);
        // A shift in the pose's own frame moves its translation by the rotated shift.
        Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0)
    }

    fn adjoint(&self) -> Matrix3<f64> {
        let (cosine, sine, t): (f64, f64, Vector2<f64>) =
            (self.rotation.re, self.rotation.im, self.translation.vector);
        Matrix3::new(cosine, -sine, t.y, sine, cosine, -t.x, 0.0, 0.0, 1.0)
    }
}

impl Pose<6> for Isometry3<f64> {
    fn then(&self, other: &Self) -> Self {
        self * other
    }

    fn back(&self) -> Self {
        self.inverse()
    }

    /// Translation and rotation separately. This retraction agrees with the exponential to first
    /// order, which is all that the solver needs.
    fn moved(&self, motion: &Vector6<f64>) -> Self {
        let (shift, turn): (Vector3<f64>, Vector3<f64>) = (
            motion.fixed_rows::<3>(0).into_owned(),
            motion.fixed_rows::<3>(3).into_owned(),
        );
        let there = self.translation.vector + self.rotation * shift;
        let mut rotation = self.rotation * so3::exp(turn);
        rotation.renormalize();
        Self::from_parts(there.into(), rotation)
    }

    fn distance(&self) -> Vector6<f64> {
        let turn = so3::log(self.rotation);
        // V⁻¹ t, equations 172 and 174; V is the left Jacobian.
        let shift = so3::inverse_right_jacobian(-turn) * self.translation.vector;
        let mut distance = Vector6::zeros();
        distance.fixed_rows_mut::<3>(0).copy_from(&shift);
        distance.fixed_rows_mut::<3>(3).copy_from(&turn);
        distance
    }

    /// The inverse of the right Jacobian by its series, I + ad/2 + ad²/12 - ad⁴/720 (T. D. Barfoot,
    /// *State Estimation for Robotics*, 2017, equation 7.96). It is right to 10⁻⁵ up to half a
    /// radian; measurements that disagree more have other problems.
    fn distance_jacobian(&self) -> Matrix6<f64> {
        let distance = self.distance();
        let turn = so3::hat(distance.fixed_rows::<3>(3).into_owned());
        let shift = so3::hat(distance.fixed_rows::<3>(0).into_owned());
        let mut ad = Matrix6::zeros();
        ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        ad.fixed_view_mut::<3, 3>(0, 3).copy_from(&shift);
        ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        let square = ad * ad;
        Matrix6::identity() + ad * 0.5 + square / 12.0 - square * square / 720.0
    }

    fn adjoint(&self) -> Matrix6<f64> {
        let rotation = self.rotation.to_rotation_matrix().into_inner();
        let mut adjoint = Matrix6::zeros();
        adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
        adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
        adjoint
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&(so3::hat(self.translation.vector) * rotation));
        adjoint
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Checks Jacobians against differences, and the adjoint against its definition.
    fn check<P: Pose<D>, const D: usize>(a: &P, b: &P) -> Result<(), TestCaseError> {
        const STEP: f64 = 1e-6;
        let jacobian = a.distance_jacobian();
        for i in 0..D {
            let motion = SVector::<f64, D>::from_fn(|row, _| if row == i { STEP } else { 0.0 });
            let difference =
                (a.moved(&motion).distance() - a.moved(&-motion).distance()) / (2.0 * STEP);
            prop_assert!(
                (difference - jacobian.column(i)).norm() < 1e-4,
                "{i}: {difference} {jacobian}"
            );
            // X exp(m) = exp(Ad m) X.
            let same = a.then(&b.moved(&motion)).then(&a.then(b).back());
            let there = a.then(b).adjoint() * motion;
            prop_assert!((same.distance() - there).norm() < 1e-9);
        }
        prop_assert!(a.then(&a.back()).distance().norm() < 1e-12);
        Ok(())
    }

    proptest! {
        #[test]
        fn jacobians_agree_with_differences(n in proptest::collection::vec(-0.6_f64..0.6, 12)) {
            let plane = |i: usize| Isometry2::new(Vector2::new(n[i], n[i + 1]), n[i + 2]);
            check(&plane(0), &plane(3))?;
            let space = |i: usize| {
                let shift = Vector3::new(n[i], n[i + 1], n[i + 2]);
                let turn = Vector3::new(n[i + 3], n[i + 4], n[i + 5]);
                Isometry3::new(shift, turn * 0.5)
            };
            check(&space(0), &space(6))?;
        }
    }
}
