//! How noisy an IMU and a LiDAR are, as their data sheets say.

use nalgebra::Vector3;

/// Noise density of a turn rate that is not measured, rad/s/√Hz: in a gap between samples, beyond
/// the IMU's limits, or during an impact.
pub(super) const UNMEASURED_GYRO: f64 = 0.3;
/// The same of a specific force, m/s²/√Hz.
pub(super) const UNMEASURED_ACCEL: f64 = 1.0;
/// Squared sine below which the incidence angle of a ray is not trusted.
const MIN_SINE_SQUARED: f64 = 1e-5;
/// Squared ranges below this are not divided by, m².
const MIN_SQUARED_RANGE_M2: f64 = 1e-6;

/// Noise of an IMU: densities of white noise, and of the random walks of its biases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuNoise {
    /// White noise of the turn rate, rad/s/√Hz.
    pub gyro: f64,
    /// White noise of the specific force, m/s²/√Hz.
    pub accel: f64,
    /// Random walk of the gyroscope's bias, rad/s²/√Hz.
    pub gyro_walk: f64,
    /// Random walk of the accelerometer's bias, m/s³/√Hz.
    pub accel_walk: f64,
}

/// Noise of a LiDAR: one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarNoise {
    /// Of a range, metres.
    pub range: f64,
    /// Of a ray's direction, radians.
    pub angle: f64,
}

/// A point as seen from the LiDAR, relative to a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incidence {
    /// Distance from the LiDAR along the plane's normal, metres.
    pub(super) along_normal: f64,
    /// Square of the whole distance, m².
    pub(super) squared_range: f64,
}

impl Incidence {
    /// Of a point in a frame whose origin is the LiDAR, and a plane's unit normal in that frame.
    pub(super) fn new(point: &Vector3<f64>, normal: &Vector3<f64>) -> Self {
        Self {
            along_normal: normal.dot(point),
            squared_range: point.norm_squared().max(MIN_SQUARED_RANGE_M2),
        }
    }
}

impl LidarNoise {
    /// Variance across a plane of a point on it, m².
    pub(super) fn variance_across(&self, incidence: Incidence) -> f64 {
        let Incidence {
            along_normal,
            squared_range,
        } = incidence;
        let sine_squared = along_normal * along_normal / squared_range;
        // A ray at the angle α to the plane: its range error counts by sin α, its sideways error by
        // cos α.
        sine_squared * self.range * self.range
            + (1.0 - sine_squared) * self.angle * self.angle * squared_range
    }

    /// The share by which points on a plane seem too far away, on average.
    ///
    /// A ray whose direction is off by ε meets a plane at the range h / sin(α + ε), where α is its
    /// angle to the plane and h the LiDAR's height above it. The point is placed
    /// sin α / sin(α + ε) times too far away: 1 + σ² / α² times on average. On distant level ground
    /// that is millimetres, always downwards, and the map would bend.
    pub(super) fn grazing_bias(&self, incidence: Incidence) -> f64 {
        let Incidence {
            along_normal,
            squared_range,
        } = incidence;
        let sine_squared = along_normal * along_normal / squared_range;
        self.angle * self.angle / sine_squared.max(MIN_SINE_SQUARED)
    }
}
