//! Rotations as vectors: the exponential of SO(3), its logarithm, and the Jacobian between the two.
//!
//! J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state estimation in robotics*, 2018,
//! equations 132 to 146.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// The rotation of a vector: about its direction, by its length in radians.
pub(crate) fn exp(rotation: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(rotation)
}

/// The vector of a rotation; it is at most half a turn long.
pub(crate) fn log(rotation: UnitQuaternion<f64>) -> Vector3<f64> {
    rotation.scaled_axis()
}

/// The matrix of the cross product with a vector from the left.
pub(crate) fn hat(v: Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

/// The right Jacobian: `exp(a + b) ≈ exp(a) exp(J b)` for small `b`.
pub(crate) fn right_jacobian(rotation: Vector3<f64>) -> Matrix3<f64> {
    let angle = rotation.norm();
    let hat = hat(rotation);
    // The quotients below lose all digits for small angles.
    if angle < 1e-4 {
        return Matrix3::identity() - hat * 0.5 + hat * hat / 6.0;
    }
    let (sine, cosine) = libm::sincos(angle);
    let square = angle * angle;
    Matrix3::identity() - hat * ((1.0 - cosine) / square)
        + hat * hat * ((angle - sine) / (square * angle))
}

/// Its inverse: `log(exp(a) exp(b)) ≈ a + J⁻¹ b` for small `b`.
pub(crate) fn inverse_right_jacobian(rotation: Vector3<f64>) -> Matrix3<f64> {
    let angle = rotation.norm();
    let hat = hat(rotation);
    if angle < 1e-4 {
        return Matrix3::identity() + hat * 0.5 + hat * hat / 12.0;
    }
    let (sine, cosine) = libm::sincos(angle);
    let factor = 1.0 / (angle * angle) - (1.0 + cosine) / (2.0 * angle * sine);
    Matrix3::identity() + hat * 0.5 + hat * hat * factor
}

/// Two directions at right angles to a vector and to each other, as columns. They change
/// continuously with vectors that are not along x.
pub(crate) fn tangent(direction: Vector3<f64>) -> nalgebra::Matrix3x2<f64> {
    let along_x = direction.x.abs() > 0.9 * direction.norm();
    // Nearly parallel vectors have a cross product of hardly any length.
    let other = if along_x { Vector3::y() } else { Vector3::x() };
    let first = direction.cross(&other).normalize();
    let second = direction.normalize().cross(&first);
    nalgebra::Matrix3x2::from_columns(&[first, second])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        proptest::array::uniform3(-1.7_f64..1.7).prop_map(Vector3::from)
    }

    proptest! {
        #[test]
        fn the_right_jacobian_converts_a_small_addend(a in vector(), b in vector()) {
            let b = b * 1e-6;
            let left = exp(a + b);
            let right = exp(a) * exp(right_jacobian(a) * b);
            prop_assert!(left.angle_to(&right) < 1e-11);
            let product = right_jacobian(a) * inverse_right_jacobian(a);
            prop_assert!((product - Matrix3::identity()).norm() < 1e-9);
        }

        #[test]
        fn logarithms_undo_exponentials(a in vector()) {
            prop_assume!(a.norm() < 3.1);
            prop_assert!((log(exp(a)) - a).norm() < 1e-9);
        }

        #[test]
        fn tangents_are_at_right_angles(a in vector()) {
            prop_assume!(a.norm() > 1e-3);
            let basis = tangent(a);
            prop_assert!((basis.transpose() * a).norm() < 1e-12 * a.norm().max(1.0));
            let square = basis.transpose() * basis;
            prop_assert!((square - nalgebra::Matrix2::identity()).norm() < 1e-12);
        }
    }
}
