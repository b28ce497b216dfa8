//! What is drawn: a pinhole camera, its range and its exposure.

use openbench_core::Pose3;

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl ImageSize {
    /// A size in columns and rows.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// Number of pixels.
    pub const fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// A pinhole camera in the axes of `camera_link`: x forward, y left, z up.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Pose in `map`.
    pub pose: Pose3,
    /// Size of the image.
    pub size: ImageSize,
    /// Focal length, pixels.
    pub focal_length: f64,
    /// Distance beyond which nothing is seen, metres. At this distance, half of a surface's
    /// colour has faded into the haze.
    pub range: f32,
    /// Whether objects cast shadows, at the cost of a second ray for each pixel.
    pub shadows: bool,
    /// Factor on the light of the scene; 1 shows the scene as it is.
    pub exposure: f32,
}
