//! Points of a cube, and the plane fitted to them.

use nalgebra::{Isometry3, Vector3};

use super::plane::{Plane, Shape};
use crate::lio::moments::Moments;
use crate::lio::noise::{Incidence, LidarNoise};

/// A plane has at least this many points.
const MIN_POINTS: f64 = 8.0;
/// Cubes with this many points take no more. More points make no plane better known, and a wall
/// stays where it was seen first.
const FULL: f64 = 2000.0;
/// Whether points were corrected for the angle of incidence of their rays, see
/// [`LidarNoise::grazing_bias`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::lio) enum Rays {
    /// They were; the mean variance across the plane by the LiDAR's noise, m².
    Corrected(f64),
    /// They could not be, since no plane was known yet; the vector from the LiDAR to their mean.
    Uncorrected(Vector3<f64>),
}

/// Points that are to be corrected once there is a plane.
#[derive(Debug, Clone, Copy, Default)]
struct UncorrectedRays {
    count: f64,
    /// Sum of the vectors from the LiDAR to the points.
    sum: Vector3<f64>,
}

/// Points of a cube. Places are relative to its middle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cube {
    /// Number of points when the plane was fitted.
    fitted: f64,
    points: Moments,
    uncorrected: UncorrectedRays,
    /// Of corrected points, the sum of the variances across the plane by the LiDAR's noise, m².
    noise_variances: f64,
    /// Sum of the unit vectors from the points to the LiDAR.
    towards_lidar: Vector3<f64>,
    plane: Option<Plane>,
}

/// Where a cube is, and where the LiDAR is relative to its middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// In `odom`.
    pub(super) middle: Vector3<f64>,
    pub(super) lidar: Vector3<f64>,
}

impl Cube {
    pub(super) fn plane(&self) -> Option<&Plane> {
        self.plane.as_ref()
    }

    /// Number of points.
    pub(super) fn count(&self) -> f64 {
        self.points.weight
    }

    /// Whether it has a plane and takes no more points.
    pub(super) fn is_full(&self) -> bool {
        self.plane.is_some() && self.points.weight >= FULL
    }

    /// Whether the LiDAR, in `odom`, is where it cannot see the plane.
    pub(super) fn is_seen_from_behind(&self, lidar: Vector3<f64>) -> bool {
        self.plane.is_some_and(|plane| plane.distance(lidar) < 0.0)
    }

    /// Takes points in, unless there are enough.
    pub(super) fn add(&mut self, points: &Moments, rays: Rays, view: View, noise: &LidarNoise) {
        if self.points.weight >= FULL {
            return;
        }
        self.points.merge(points);
        let direction = (view.lidar - points.mean())
            .try_normalize(0.0)
            .unwrap_or_default();
        self.towards_lidar += direction * points.weight;
        match rays {
            Rays::Corrected(variance) => self.noise_variances += variance * points.weight,
            Rays::Uncorrected(ray) => {
                self.uncorrected.count += points.weight;
                self.uncorrected.sum += ray * points.weight;
            }
        }
        if self.needs_fit() {
            self.fit(view.middle, noise);
        }
    }

    /// Whether there are a third more points than when the plane was fitted.
    fn needs_fit(&self) -> bool {
        // So the number of fits grows with the logarithm of the points.
        self.points.weight >= MIN_POINTS && 3.0 * self.points.weight >= 4.0 * self.fitted
    }

    /// Fits the plane to the points, if they lie on one.
    fn fit(&mut self, middle: Vector3<f64>, noise: &LidarNoise) {
        let count = self.points.weight;
        self.fitted = count;
        // A cube that turns out not to be flat loses its plane.
        self.plane = None;
        let shape = Shape::of(&self.points);
        if shape.is_flat() {
            let normal = shape.normal_towards(&self.towards_lidar);
            self.correct_rays(normal, noise);
            let middle = middle + self.points.mean();
            let noise_variance = self.noise_variances / count;
            self.plane = Some(shape.plane(normal, middle, count, noise_variance, noise));
        }
    }

    /// Moves points to where they are on average, now that the plane's normal is known.
    fn correct_rays(&mut self, normal: Vector3<f64>, noise: &LidarNoise) {
        let UncorrectedRays { count, sum } = std::mem::take(&mut self.uncorrected);
        if count > 0.0 {
            let ray = sum / count;
            let incidence = Incidence::new(&ray, &normal);
            self.noise_variances += noise.variance_across(incidence) * count;
            // Only the part across the plane: a shift along it does not change the plane.
            let bias = normal * (incidence.along_normal * noise.grazing_bias(incidence));
            // The sums no longer tell corrected points from uncorrected ones. All are moved, by the
            // mean.
            let shift = -bias * (count / self.points.weight);
            let motion = Isometry3::translation(shift.x, shift.y, shift.z);
            self.points = self.points.moved(&motion);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::planes::plane::{EVENNESS_M, UNEVENNESS};

    #[test]
    fn unevenness_is_what_is_beyond_the_noise() {
        let noise = LidarNoise {
            range: 0.02,
            angle: 0.001,
        };
        // Two layers of points, 4 cm apart, seen from straight ahead.
        let uneven = |rays: Rays| {
            let mut cube = Cube::default();
            let mut points = Moments::default();
            for i in 0..400 {
                let layer = f64::from(i % 2) * 0.04;
                points.add(
                    Vector3::new(f64::from(i % 20) * 0.05, f64::from(i / 20) * 0.05, layer),
                    1.0,
                );
            }
            let view = View {
                middle: Vector3::zeros(),
                lidar: Vector3::z() * 5.0,
            };
            cube.add(&points, rays, view, &noise);
            cube.plane.unwrap().uneven
        };
        let most = EVENNESS_M * EVENNESS_M + UNEVENNESS * 0.02 * 0.02;
        assert!((uneven(Rays::Corrected(0.0)) / most - 1.0).abs() < 0.02);
        for noisy in [
            Rays::Corrected(0.02 * 0.02),
            Rays::Corrected(1.0),
            Rays::Uncorrected(Vector3::z() * 5.0),
        ] {
            assert!(uneven(noisy) <= EVENNESS_M * EVENNESS_M, "{noisy:?}");
        }
    }
}
