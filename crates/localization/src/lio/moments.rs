//! Sums over points: from them follow their number, their mean and their covariance.

use nalgebra::{Isometry3, Matrix3, Matrix4, Vector3};

/// Sums over weighted points p: of w, w p and w p pᵀ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moments {
    /// Sum of the weights.
    pub weight: f64,
    /// Sum of the weighted points.
    pub first: Vector3<f64>,
    /// Sums of the weighted products xx, xy, xz, yy, yz, zz.
    pub second: [f64; 6],
}

impl Moments {
    /// Adds a point.
    pub fn add(&mut self, p: Vector3<f64>, weight: f64) {
        let q = p * weight;
        self.weight += weight;
        self.first += q;
        let products = [
            q.x * p.x,
            q.x * p.y,
            q.x * p.z,
            q.y * p.y,
            q.y * p.z,
            q.z * p.z,
        ];
        self.second
            .iter_mut()
            .zip(products)
            .for_each(|(sum, product)| *sum += product);
    }

    /// Adds the points of other sums.
    pub fn merge(&mut self, other: &Self) {
        self.weight += other.weight;
        self.first += other.first;
        self.second
            .iter_mut()
            .zip(other.second)
            .for_each(|(sum, more)| *sum += more);
    }

    fn squares(&self) -> Matrix3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.second;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The sum of w (p, 1) (p, 1)ᵀ.
    pub fn matrix(&self) -> Matrix4<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.second;
        let (f, w) = (self.first, self.weight);
        Matrix4::new(
            xx, xy, xz, f.x, xy, yy, yz, f.y, xz, yz, zz, f.z, f.x, f.y, f.z, w,
        )
    }

    /// The sums over the same points after a rigid motion.
    #[must_use]
    pub fn moved(&self, motion: &Isometry3<f64>) -> Self {
        let rotation = motion.rotation.to_rotation_matrix().into_inner();
        let (shift, turned) = (motion.translation.vector, rotation * self.first);
        // Of q = R p + t: Σ w q qᵀ = R S Rᵀ + (R f) tᵀ + t (R f)ᵀ + w t tᵀ.
        let mixed = turned * shift.transpose();
        let squares = rotation * self.squares() * rotation.transpose()
            + mixed
            + mixed.transpose()
            + shift * shift.transpose() * self.weight;
        let m = |row, column| squares[(row, column)];
        Self {
            weight: self.weight,
            first: turned + shift * self.weight,
            second: [m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)],
        }
    }

    /// The mean of the points; the origin if there are none.
    pub fn mean(&self) -> Vector3<f64> {
        if self.weight > 0.0 {
            self.first / self.weight
        } else {
            Vector3::zeros()
        }
    }

    /// The covariance of the points about their mean.
    pub fn covariance(&self) -> Matrix3<f64> {
        let mean = self.mean();
        self.squares() / self.weight - mean * mean.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::so3::exp;

    #[test]
    fn moving_the_sums_is_moving_the_points() {
        let motion = Isometry3::from_parts(
            Vector3::new(3.0, -2.0, 0.5).into(),
            exp(Vector3::new(0.3, -0.2, 1.0)),
        );
        let (mut here, mut there) = (Moments::default(), Moments::default());
        for i in 0..50 {
            let x = f64::from(i);
            let point = Vector3::new(libm::sin(x), 0.1 * x, libm::cos(3.0 * x));
            here.add(point, 1.0 + 0.1 * x);
            there.add(
                (motion * nalgebra::Point3::from(point)).coords,
                1.0 + 0.1 * x,
            );
        }
        let moved = here.moved(&motion);
        assert!((moved.matrix() - there.matrix()).norm() < 1e-9 * there.matrix().norm());
        assert!((moved.covariance() - there.covariance()).norm() < 1e-9);
        let (one, mut both) = (here, here);
        both.merge(&one);
        assert!((both.matrix() - here.matrix() * 2.0).norm() < 1e-9);
    }
}
