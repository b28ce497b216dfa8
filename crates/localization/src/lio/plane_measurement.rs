//! What the points of a scan on the planes of a map say about a state.
//!
//! W. Xu, F. Zhang, *FAST-LIO*, 2021: residuals and their Jacobians are its equations 12 to 14.
//! Here they are summed over the points of a plane. Points on one plane share its errors, so that
//! they are joined as one measurement of many points would be (Woodbury's identity).

use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector4};

use super::degeneracy::{degenerate_directions, remove};
use super::matching::{Cluster, PlaneObservation};
use super::state::State;
use crate::so3::hat;

/// What a scan says about `N` numbers: the IMU's pose in the map, and the LiDAR's on the IMU.
#[derive(Debug, Clone)]
pub(super) struct Measurement<const N: usize> {
    /// Inverse of their covariance.
    pub(super) information: SMatrix<f64, N, N>,
    /// Gradient of half the squared residuals.
    pub(super) gradient: SVector<f64, N>,
    pub(super) summary: Summary,
}

/// How a scan lies on the planes.
#[derive(Debug, Clone, Default)]
pub(super) struct Summary {
    /// Points on planes.
    pub(super) points: usize,
    /// Mean square of their residuals in standard deviations.
    pub(super) fit: f64,
    /// Directions in `odom` along which the scan is degenerate: unit vectors. Nothing is measured
    /// of the position along them.
    pub(super) degenerate: Vec<Vector3<f64>>,
}

/// Sums up the points of all clusters at a state in the map.
pub(super) fn measure<const N: usize>(state: &State, clusters: &[Cluster]) -> Measurement<N> {
    let mut information = SMatrix::<f64, N, N>::zeros();
    let mut gradient = SVector::<f64, N>::zeros();
    let mut points = 0.0;
    let mut squares = 0.0;
    let mut feigned = Matrix3::zeros();
    for cluster in clusters {
        let Some(plane) = &cluster.plane else {
            continue;
        };
        let residual = Residual::<N>::new(state, plane);
        let sums = plane.weighted.matrix();
        let weighted = residual.jacobian * sums;
        // Woodbury: the points' covariance is that of their own noise and of three numbers more,
        // the errors of the plane.
        let errors = plane.errors * sums;
        let shared = errors * plane.errors.transpose() + Matrix3::from_diagonal(&plane.known);
        let Some(shared) = shared.try_inverse() else {
            continue;
        };
        let mixed = residual.jacobian * errors.transpose();
        // With S the sums, E the error rows and K = (E S Eᵀ + Λ)⁻¹, the points weigh S - S Eᵀ K E
        // S.
        let error_sums = errors * residual.distance;
        information +=
            weighted * residual.jacobian.transpose() - mixed * shared * mixed.transpose();
        gradient += weighted * residual.distance - mixed * (shared * error_sums);
        squares += residual.distance.dot(&(sums * residual.distance))
            - error_sums.dot(&(shared * error_sums));
        feigned += feigned_information(plane);
        points += cluster.points.weight;
    }
    // Directions are judged by all planes together, before anything is removed.
    let position = information.fixed_view::<3, 3>(3, 3).into_owned();
    let degenerate = degenerate_directions(&position, &feigned);
    for direction in &degenerate {
        remove(&mut information, &mut gradient, direction);
    }
    let fit = squares / points.max(1.0);
    let summary = Summary {
        points: points as usize,
        fit,
        degenerate,
    };
    Measurement {
        information,
        gradient,
        summary,
    }
}

/// Information about the position that a plane's points feign, since the plane's normal is tilted
/// by chance.
fn feigned_information(plane: &PlaneObservation) -> Matrix3<f64> {
    let weight = plane.weighted.weight;
    // weight * (1 - lost * weight) is weight / (1 + shared * weight): points that share an error
    // together say no more than 1 / shared.
    let lost = plane.shared / (1.0 + plane.shared * weight);
    plane.normal_covariance * (weight * (1.0 - lost * weight))
}

/// Distance of a point from a plane, and how it changes with the state. Both are linear in the
/// point p of the LiDAR's frame: they are factors of (p, 1).
struct Residual<const N: usize> {
    distance: Vector4<f64>,
    jacobian: SMatrix<f64, N, 4>,
}

impl<const N: usize> Residual<N> {
    /// Equations 12 to 14.
    fn new(state: &State, plane: &PlaneObservation) -> Self {
        let on_imu = state.rotation.inverse() * plane.normal;
        let on_lidar = state.mount_rotation.inverse() * on_imu;
        let lidar = state.rotation * state.mount_position + state.position;
        let distance = on_lidar.push(plane.normal.dot(&lidar) - plane.offset);
        let mut jacobian = SMatrix::<f64, N, 4>::zeros();
        // p × n = -n × p.
        let mount = state.mount_rotation.to_rotation_matrix().into_inner();
        let turned: Matrix3<f64> = -hat(on_imu) * mount;
        let lever = state.mount_position.cross(&on_imu);
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
        jacobian.fixed_view_mut::<3, 1>(0, 3).copy_from(&lever);
        jacobian
            .fixed_view_mut::<3, 1>(3, 3)
            .copy_from(&plane.normal);
        // The LiDAR's pose on the IMU is estimated too.
        if N > 6 {
            jacobian.view_mut((6, 0), (3, 3)).copy_from(&-hat(on_lidar));
            jacobian.view_mut((9, 3), (3, 1)).copy_from(&on_imu);
        }
        Self { distance, jacobian }
    }
}
