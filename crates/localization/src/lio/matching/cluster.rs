//! Points of a scan in one cube of the map.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::lio::moments::Moments;
use crate::lio::planes::Place;

/// Points of a scan in one cube, in the LiDAR's frame.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Which cube.
    pub place: Place,
    /// Each with weight 1.
    pub points: Moments,
    /// The plane that they lie on, if there is one.
    pub plane: Option<PlaneObservation>,
    /// Whether the cube takes no more points.
    pub(super) is_full: bool,
}

/// A plane as a scan sees it.
#[derive(Debug, Clone)]
pub struct PlaneObservation {
    /// Unit vector in `odom`.
    pub normal: Vector3<f64>,
    /// Distance of the plane from the origin of `odom` along its normal, metres.
    pub offset: f64,
    /// The points, each weighted by the inverse of its variance across the plane, 1/m².
    pub weighted: Moments,
    /// Variance that all of them share: that of the plane at their place, m².
    pub shared: f64,
    /// How a plane that is shifted or tilted moves under a point: rows that (p, 1) is multiplied
    /// by.
    pub(in crate::lio) errors: SMatrix<f64, 3, 4>,
    /// Inverse variances of these errors, 1/m².
    pub(in crate::lio) known: Vector3<f64>,
    /// Covariance of the normal.
    pub(in crate::lio) normal_covariance: Matrix3<f64>,
}
