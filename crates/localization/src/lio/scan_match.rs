//! How well a scan lies on the map.

use nalgebra::Vector3;

/// With fewer points on known planes a scan says nothing.
const MIN_POINTS: usize = 60;
/// Of the points where planes are known at least this share lies on them, or something is wrong.
const MIN_AGREEING: f64 = 0.5;

/// What an update by a scan came to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ScanMatch {
    /// Points that lie on known planes.
    pub(super) points: usize,
    /// Their share of the points where planes are known.
    pub(super) agreeing: f64,
    /// Mean square of their residuals in standard deviations: about 1 if the noise is as stated.
    pub(super) fit: f64,
    /// Directions in `odom` along which the scan is degenerate: unit vectors.
    pub(super) degenerate: Vec<Vector3<f64>>,
    /// Normalized innovation squared of the prediction by IMU and wheels, over its expected value:
    /// about 1 if prediction and scan are as uncertain as assumed.
    pub(super) innovation: f64,
}

impl ScanMatch {
    /// Whether the scan says something, and does not contradict the map.
    pub(super) fn is_good(&self) -> bool {
        self.points >= MIN_POINTS && self.agreeing >= MIN_AGREEING
    }
}
