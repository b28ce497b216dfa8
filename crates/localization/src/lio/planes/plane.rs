//! A plane that points lie on, and how certain it is.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::lio::moments::Moments;
use crate::lio::noise::LidarNoise;

/// No plane is known better than this (one standard deviation), metres: nothing built is as even as
/// many points make it seem.
pub(super) const EVENNESS_M: f64 = 0.005;
/// Nor is a plane known better than this share of the variance of its points beyond the LiDAR's
/// noise.
///
/// Leaves, cars and whatever else is no plane are seen elsewhere by each scan; noise averages out.
/// Chosen together with [`FLATNESS`] on thirteen drives of three minutes (ten windows of two towns,
/// the built-in worlds) and five of 450 to 800 m in four of these windows. Compared with counting
/// the noise as unevenness, errors on the ground are 0.88 and 0.71 as large, and the mean NEES is
/// 5.2 and 5.0 instead of 3.6 and 4.9.
pub(super) const UNEVENNESS: f64 = 0.5;
/// The stated noise of a LiDAR counts as much as this many points.
const NOISE_POINTS: f64 = 10.0;
/// Degrees of freedom of a plane, which its points lose.
const FREEDOM: f64 = 3.0;
/// Points lie on a plane if they are no farther from it than this (one standard deviation), metres,
const MAX_THICKNESS_M: f64 = 0.04;
/// and spread along it this many times as far, in its narrower direction.
///
/// On the drives of [`UNEVENNESS`] errors are 0.79 and 0.85 as large with 3, 1.02 and 0.69 with 5,
/// and 1.01 on the long ones with 7.
const FLATNESS: f64 = 4.0;
/// No points are taken for thinner than this when their spread is compared, m².
const MIN_THICKNESS_M2: f64 = 1e-5;

/// A plane that points lie on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit vector, towards where the points were seen from.
    pub normal: Vector3<f64>,
    /// Mean of its points.
    pub middle: Vector3<f64>,
    /// Directions along it.
    pub(super) along: [Vector3<f64>; 2],
    /// Variances of its points along these directions, m².
    spread: [f64; 2],
    /// Variance of its points across it, m².
    pub thickness: f64,
    /// Variance of the plane that no number of points reduces, m².
    pub(super) uneven: f64,
    /// Number of its points.
    count: f64,
}

/// One way in which a plane may be wrong: shifted along its normal, or tilted about a direction.
///
/// At a point p the plane is off by `along` · (p - middle) + `shift`, times an error.
#[derive(Debug, Clone, Copy)]
pub(in crate::lio) struct PlaneError {
    pub(in crate::lio) along: Vector3<f64>,
    pub(in crate::lio) shift: f64,
    /// Variance of the error, m².
    pub(in crate::lio) variance: f64,
}

impl Plane {
    /// Signed distance of a point, metres; positive on the side of the normal.
    pub fn distance(&self, point: Vector3<f64>) -> f64 {
        self.normal.dot(&(point - self.middle))
    }

    /// How it may be wrong.
    pub(in crate::lio) fn errors(&self) -> [PlaneError; 3] {
        let shifted = PlaneError {
            along: Vector3::zeros(),
            shift: 1.0,
            variance: self.offset(),
        };
        [shifted, self.tilted(0), self.tilted(1)]
    }

    fn tilted(&self, i: usize) -> PlaneError {
        // As the slope of a regression: its variance falls with the spread of the points.
        let variance = self.offset() / self.spread[i];
        PlaneError {
            along: self.along[i],
            shift: 0.0,
            variance,
        }
    }

    /// Variance at its middle, m².
    fn offset(&self) -> f64 {
        self.uneven + self.thickness / self.count
    }

    /// Covariance of the normal.
    pub(in crate::lio) fn normal_covariance(&self) -> Matrix3<f64> {
        let [first, second] = [0, 1]
            .map(|i| self.along[i] * self.along[i].transpose() * (self.offset() / self.spread[i]));
        first + second
    }

    /// Variance of the plane at a point, m²: that of a regression there, and what no regression
    /// reduces.
    pub fn variance(&self, point: Vector3<f64>) -> f64 {
        let offset = point - self.middle;
        let [first, second] = [0, 1].map(|i| {
            let distance = self.along[i].dot(&offset);
            distance * distance / self.spread[i]
        });
        self.uneven + self.thickness / self.count * (1.0 + first + second)
    }
}

/// How points spread about their mean.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Directions of least, middle and greatest spread.
    directions: [Vector3<f64>; 3],
    /// Variances along them, m².
    variances: [f64; 3],
}

impl Shape {
    pub(super) fn of(points: &Moments) -> Self {
        let eigen = SymmetricEigen::new(points.covariance());
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        Self {
            directions: order.map(|i| eigen.eigenvectors.column(i).into_owned()),
            // Rounding may leave a variance below zero.
            variances: order.map(|i| eigen.eigenvalues[i].max(0.0)),
        }
    }

    /// Whether points of this shape lie on a plane.
    pub(super) fn is_flat(&self) -> bool {
        let [thickness, narrow, _] = self.variances;
        thickness < MAX_THICKNESS_M * MAX_THICKNESS_M
            && narrow > FLATNESS * FLATNESS * thickness.max(MIN_THICKNESS_M2)
    }

    /// Normal of the plane, on the side of a direction.
    pub(super) fn normal_towards(&self, side: &Vector3<f64>) -> Vector3<f64> {
        let normal = self.directions[0];
        if normal.dot(side) < 0.0 {
            -normal
        } else {
            normal
        }
    }

    /// The plane of `count` points of this shape. `noise_variance` is the mean variance across it
    /// by the LiDAR's noise, m².
    pub(super) fn plane(
        &self,
        normal: Vector3<f64>,
        middle: Vector3<f64>,
        count: f64,
        noise_variance: f64,
        noise: &LidarNoise,
    ) -> Plane {
        let [thickness, narrow, wide] = self.variances;
        let [_, first, second] = self.directions;
        // What few points say about their own noise counts little.
        let stated = NOISE_POINTS * noise.range * noise.range;
        Plane {
            normal,
            middle,
            along: [first, second],
            spread: [narrow, wide],
            thickness: (thickness * count + stated) / (count - FREEDOM + NOISE_POINTS),
            count,
            uneven: EVENNESS_M * EVENNESS_M + UNEVENNESS * (thickness - noise_variance).max(0.0),
        }
    }
}
