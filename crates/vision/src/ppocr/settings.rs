//! Settings of PP-OCR.

/// Settings of [`crate::PpOcr`], which trade speed for distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PpOcrSettings {
    /// Longer side of the input of the detection network, pixels. Images are scaled down to it, but
    /// not up. Time grows with its square.
    pub detection_side: u32,
    /// The fraction of the image, from the top, in which text is detected. A level camera of a
    /// robot sees plates above the horizon only.
    pub upper_part: f32,
    /// Minimum probability of a pixel of text.
    pub pixel_threshold: f32,
    /// Minimum mean probability of a box.
    pub box_threshold: f32,
    /// Expansion of a box on each side: its area times this, divided by its perimeter.
    pub unclip_ratio: f32,
    /// Minimum confidence of a reading.
    pub min_confidence: f32,
    /// Maximum number of boxes of an image, the most probable first. It limits the time for images
    /// full of letters.
    pub max_boxes: usize,
}

impl Default for PpOcrSettings {
    fn default() -> Self {
        Self {
            detection_side: 640,
            upper_part: 1.0,
            pixel_threshold: 0.3,
            box_threshold: 0.5,
            unclip_ratio: 1.8,
            min_confidence: 0.5,
            max_boxes: 16,
        }
    }
}
