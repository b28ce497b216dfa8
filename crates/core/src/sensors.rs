//! What the robot's sensors deliver.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// One sample of the inertial measurement unit, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// When it was taken.
    pub stamp: SimTime,
    /// Angular velocity, rad/s.
    pub gyro: [f64; 3],
    /// Specific force, m/s²: at rest it is +9.8 upwards.
    pub accel: [f64; 3],
}

/// Angles of the wheels since the start, as encoders count them: a slipping wheel turns without moving the robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WheelSample {
    /// When it was taken.
    pub stamp: SimTime,
    /// Mean angle of the two left wheels, radians.
    pub left: f64,
    /// Mean angle of the two right wheels, radians.
    pub right: f64,
}

/// A position from satellites. Robots of the benchmark have no receiver unless a suite gives them one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GnssFix {
    /// When it was measured.
    pub stamp: SimTime,
    /// Where the antenna is in `map`, metres: what the receiver says in degrees, brought into the map by its georeference.
    pub position: [f64; 3],
    /// What the receiver believes of its error: covariance of the position, m², east, north, up.
    pub covariance: [[f64; 3]; 3],
    /// Satellites used.
    pub satellites: u8,
}

/// One return of the LiDAR.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LidarPoint {
    /// Position in `livox_frame` at the instant this point was measured, metres.
    pub xyz: [f32; 3],
    /// Nanoseconds from the scan's stamp to the instant this point was measured.
    pub offset_ns: u32,
    /// Reflectivity of the surface, 0 to 255.
    pub reflectivity: u8,
    /// Laser line that measured it.
    pub line: u8,
}

/// The returns of one scan. Rays that hit nothing have no point. Points are in the order they were measured, each in
/// the sensor's frame of its own instant: a moving robot's scan is distorted, as a real one is.
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

/// A pinhole camera without distortion. Optical axes: x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraIntrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Horizontal field of view, radians.
    pub horizontal_fov: f64,
}

impl CameraIntrinsics {
    /// Focal length in pixels, the same for both axes.
    pub fn focal_length(&self) -> f64 {
        self.width as f64 / 2.0 / libm::tan(self.horizontal_fov / 2.0)
    }

    /// The direction that pixel (`u`, `v`) looks in, in `camera_link` (x forward, y left, z up), with x = 1.
    pub fn ray(&self, u: f64, v: f64) -> [f64; 3] {
        let f = self.focal_length();
        [
            1.0,
            (self.width as f64 / 2.0 - u) / f,
            (self.height as f64 / 2.0 - v) / f,
        ]
    }

    /// Where a point in `camera_link` appears, in pixels; `None` if it is behind the camera or outside the image.
    pub fn project(&self, point: [f64; 3]) -> Option<(f64, f64)> {
        let [x, y, z] = point;
        if x <= 1e-6 {
            return None;
        }
        let f = self.focal_length();
        let (u, v) = (
            self.width as f64 / 2.0 - f * y / x,
            self.height as f64 / 2.0 - f * z / x,
        );
        let inside =
            (0.0..self.width as f64).contains(&u) && (0.0..self.height as f64).contains(&v);
        inside.then_some((u, v))
    }
}

/// A handle to the camera. An image costs something only when it is asked for.
pub trait Camera {
    /// The image of this instant, or `None` if the camera's rate does not allow another one yet.
    fn image(&self) -> Option<Arc<Image>>;
}
