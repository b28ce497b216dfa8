//! Messages of the robot's sensors.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::distortion::{Distortion, PlanePoint};
use crate::time::SimTime;

/// A sample of the inertial measurement unit, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// When it was taken.
    pub stamp: SimTime,
    /// Angular velocity, rad/s.
    pub gyro: [f64; 3],
    /// Specific force, m/s²: +9.8 upwards at rest.
    pub accel: [f64; 3],
}

/// Angles of the wheels since the start, as counted by encoders. A slipping wheel turns without
/// moving the robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WheelSample {
    /// When it was taken.
    pub stamp: SimTime,
    /// Mean angle of the two left wheels, radians.
    pub left: f64,
    /// Mean angle of the two right wheels, radians.
    pub right: f64,
}

/// A position from satellites. Robots of the benchmark have no receiver unless a suite gives them
/// one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GnssFix {
    /// When it was measured.
    pub stamp: SimTime,
    /// Position of the antenna in `map`, metres: the receiver's degrees, projected by the map's
    /// georeference.
    pub position: [f64; 3],
    /// Covariance of the position as reported by the receiver, m²: east, north, up.
    pub covariance: [[f64; 3]; 3],
    /// Number of satellites used.
    pub satellites: u8,
}

/// A return of the LiDAR.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LidarPoint {
    /// Position in `livox_frame` at the instant of this point's measurement, metres.
    pub xyz: [f32; 3],
    /// Nanoseconds from the scan's stamp to the instant of this point's measurement.
    pub offset_ns: u32,
    /// Reflectivity of the surface, 0 to 255.
    pub reflectivity: u8,
    /// Number of the laser line.
    pub line: u8,
}

/// The returns of one scan. Rays that hit nothing have no point. Points are in the order of
/// measurement, each in the sensor's frame of its own instant: the scan of a moving robot is
/// distorted, as a real one is.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LidarScan {
    /// When the first ray was cast.
    pub stamp: SimTime,
    /// The returns.
    pub points: Vec<LidarPoint>,
}

/// An 8-bit RGB image, rows from the top, three bytes a pixel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// When it was exposed.
    pub stamp: SimTime,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

/// A camera with square pixels and its principal point in the middle. Optical axes: x right, y
/// down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraIntrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Horizontal field of view, radians.
    pub horizontal_fov: f64,
    /// Distortion of the lens; the field of view is that without it.
    #[serde(default, skip_serializing_if = "Distortion::is_none")]
    pub distortion: Distortion,
}

impl CameraIntrinsics {
    /// Focal length in pixels, the same for both axes.
    pub fn focal_length(&self) -> f64 {
        // Half of the width is seen under half of the field of view.
        self.width as f64 / 2.0 / libm::tan(self.horizontal_fov / 2.0)
    }

    /// Direction of the ray through pixel (`u`, `v`) in `camera_link` (x forward, y left, z up),
    /// with x = 1.
    pub fn ray(&self, u: f64, v: f64) -> [f64; 3] {
        let f = self.focal_length();
        let seen = PlanePoint {
            x: (u - self.width as f64 / 2.0) / f,
            y: (v - self.height as f64 / 2.0) / f,
        };
        let straight = self.distortion.undistort(seen);
        // Pixels count to the right and down, `camera_link` to the left and up.
        [1.0, -straight.x, -straight.y]
    }

    /// Pixel (column, row) of a point in `camera_link`; `None` if it is behind the camera or
    /// outside the image.
    pub fn project(&self, point: [f64; 3]) -> Option<(f64, f64)> {
        let [x, y, z] = point;
        // In the plane of the camera too, where the quotient would be huge or undefined.
        if x <= 1e-6 {
            return None;
        }
        let f = self.focal_length();
        // Pixels count to the right and down, `camera_link` to the left and up.
        let (mut u, mut v) = (
            self.width as f64 / 2.0 - f * y / x,
            self.height as f64 / 2.0 - f * z / x,
        );
        // Without distortion exactly the same, whatever the rounding of products.
        if !self.distortion.is_none() {
            let straight = PlanePoint {
                x: -y / x,
                y: -z / x,
            };
            let seen = self.distortion.distort(straight)?;
            u = self.width as f64 / 2.0 + f * seen.x;
            v = self.height as f64 / 2.0 + f * seen.y;
        }
        let inside =
            (0.0..self.width as f64).contains(&u) && (0.0..self.height as f64).contains(&v);
        inside.then_some((u, v))
    }
}

/// A handle to the camera. Images are rendered only on request.
pub trait Camera {
    /// The image of this instant, or `None` if the camera's rate does not allow another yet.
    fn image(&self) -> Option<Arc<Image>>;
}
