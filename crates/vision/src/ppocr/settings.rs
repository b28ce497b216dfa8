//! What can be set of PP-OCR.

/// What may be traded between speed and reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PpOcrSettings {
    /// The image is scaled so that its longer side has this many pixels before text is looked for, but never enlarged. Time grows with its square.
    pub detection_side: u32,
    /// The share of the image's rows, from the top, in which text is looked for. A robot's camera sees plates above the horizon only.
    pub upper_part: f32,
    /// A pixel belongs to text from this probability on.
    pub pixel_threshold: f32,
    /// A box is text from this mean probability on.
    pub box_threshold: f32,
    /// How far a box is widened: its area times this, divided by its circumference, to each side.
    pub unclip_ratio: f32,
    /// Readings below this confidence are dropped.
    pub min_confidence: f32,
    /// At most this many boxes of an image are read, the likeliest first. It bounds the time for an image full of letters.
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
