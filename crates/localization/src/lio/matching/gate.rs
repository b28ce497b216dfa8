//! Which points lie on a plane.

use nalgebra::{Isometry3, Vector3, Vector6};

use crate::lio::noise::{Incidence, LidarNoise};
use crate::lio::planes::Plane;
use crate::lio::state::{Covariance, State};

/// A residual is farther than this from the expected one, in standard deviations, only if something
/// has moved there.
const GATE_DEVIATIONS: f64 = 4.0;
/// Surfaces are not quite planes, metres (one standard deviation).
const ROUGHNESS_M: f64 = 0.004;

/// Where a scan was taken, and how uncertain that and the scan are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Viewpoint<'a> {
    pub(super) state: &'a State,
    /// Pose of the LiDAR in `odom`.
    pub(super) lidar: Isometry3<f64>,
    /// Of the state; only the pose's part counts.
    pub(super) covariance: &'a Covariance,
    pub(super) noise: &'a LidarNoise,
    /// No point farther from a plane lies on it, metres.
    pub(super) gate: f64,
    /// Factor of a point's weight.
    pub(super) certainty: f64,
}

/// Whether points lie on a plane, in the LiDAR's frame.
pub(super) struct Gate {
    normal: Vector3<f64>,
    offset: f64,
    /// Expected variance beside a point's own noise, m².
    variance: f64,
    noise: LidarNoise,
    /// Squared residuals beyond this do not pass, m².
    widest: f64,
    certainty: f64,
}

/// A point that lies on a plane.
pub(super) struct Inlier {
    /// Where it is on average, see [`LidarNoise::grazing_bias`].
    pub(super) point: Vector3<f64>,
    /// Inverse of its variance across the plane by the LiDAR's own noise, 1/m².
    pub(super) weight: f64,
}

impl Gate {
    /// For points near a place in `odom`.
    pub(super) fn new(view: &Viewpoint<'_>, plane: &Plane, place: Vector3<f64>) -> Self {
        Self {
            normal: view.lidar.rotation.inverse() * plane.normal,
            offset: plane.distance(view.lidar.translation.vector),
            variance: plane.variance(place) + pose_variance(view, plane, place),
            noise: *view.noise,
            widest: view.gate * view.gate,
            certainty: view.certainty,
        }
    }

    /// The point, if it lies on the plane.
    pub(super) fn pass(&self, point: &Vector3<f64>) -> Option<Inlier> {
        let incidence = Incidence::new(point, &self.normal);
        let variance = self.noise.variance_across(incidence) + ROUGHNESS_M * ROUGHNESS_M;
        let residual = incidence.along_normal + self.offset;
        // Noise of the point and uncertainty of plane and pose are independent, so their variances
        // add.
        let expected = GATE_DEVIATIONS * GATE_DEVIATIONS * (variance + self.variance);
        let passes = residual * residual < expected.min(self.widest);
        passes.then(|| Inlier {
            point: point * (1.0 - self.noise.grazing_bias(incidence)),
            weight: self.certainty / variance,
        })
    }
}

/// Variance of a residual at a place by the pose's uncertainty, m².
fn pose_variance(view: &Viewpoint<'_>, plane: &Plane, place: Vector3<f64>) -> f64 {
    let into_imu = view.state.rotation.inverse();
    let arm = into_imu * (place - view.state.position);
    // The IMU turned by δ in its own frame moves the place by δ × arm. Along n that is δ · (arm ×
    // n).
    let turned = arm.cross(&(into_imu * plane.normal));
    let normal = plane.normal;
    let row = Vector6::new(turned.x, turned.y, turned.z, normal.x, normal.y, normal.z);
    let pose = view.covariance.fixed_view::<6, 6>(0, 0);
    (row.transpose() * pose * row)[0]
}
