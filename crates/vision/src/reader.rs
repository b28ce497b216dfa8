//! The contract of a plate reader: an image in, its texts out.

use std::cmp::Ordering;

use openbench_core::Image;

use crate::error::ReaderError;

/// Limit for the sides of an image, pixels. It limits the memory of readers.
pub const MAX_SIDE_PX: u32 = 8192;

/// Finds and reads texts in a camera image.
///
/// Equal images have equal readings, whatever was read before. Readings are in order of decreasing
/// confidence. Readers return all texts; the caller selects those of plates
/// ([`crate::parse_unit`]).
pub trait PlateReader: Send {
    /// The name of the reader in results.
    fn name(&self) -> &str;

    /// All legible texts in `image`.
    ///
    /// # Errors
    /// [`ReaderError::BadImage`] if the size of the image and its number of bytes differ, and the
    /// errors of the reader's model.
    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError>;

    /// Whether the robot's own computer reads, and not a model that is asked elsewhere.
    fn computes_here(&self) -> bool {
        true
    }
}

impl<R: PlateReader + ?Sized> PlateReader for Box<R> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        (**self).read(image)
    }

    fn computes_here(&self) -> bool {
        (**self).computes_here()
    }
}

/// One text in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateReading {
    /// The text without surrounding white space; never empty.
    pub text: String,
    /// Confidence of the reader in the text, 0 to 1.
    pub confidence: f32,
    /// Corners `[x, y]`, pixels, clockwise from the top left of the text. The x axis points right,
    /// the y axis down; the origin is the outer corner of the first pixel.
    pub corners: [[f32; 2]; 4],
}

impl PlateReading {
    /// The mean of the corners `[x, y]`, pixels.
    pub fn centre(&self) -> [f32; 2] {
        let mut sum = [0.0, 0.0];
        for [x, y] in self.corners {
            sum[0] += x;
            sum[1] += y;
        }
        [sum[0] / 4.0, sum[1] / 4.0]
    }
}

/// Checks that an image is not empty, has no side above the limit, and has three bytes for each
/// pixel.
pub(crate) fn check_image(image: &Image) -> Result<(), ReaderError> {
    let (width, height) = (image.width, image.height);
    // In 64 bits, which hold any product of two sides.
    let expected = 3 * u64::from(width) * u64::from(height);
    let detail = if width == 0 || height == 0 {
        format!("{width} x {height} pixels")
    } else if width.max(height) > MAX_SIDE_PX {
        format!("{width} x {height} pixels, but no side may exceed {MAX_SIDE_PX}")
    } else if image.rgb.len() as u64 != expected {
        format!(
            "{width} x {height} pixels need {expected} bytes, there are {}",
            image.rgb.len()
        )
    } else {
        return Ok(());
    };
    Err(ReaderError::BadImage { detail })
}

/// Sorts by decreasing confidence; equal ones by their corners, which is from left to right.
pub(crate) fn sort_readings(readings: &mut [PlateReading]) {
    readings.sort_by(|a, b| {
        b.confidence
            .total_cmp(&a.confidence)
            // A total order, so that equal images have equal readings whatever the order of
            // detection.
            .then_with(|| by_place(&a.corners, &b.corners))
    });
}

fn by_place(a: &[[f32; 2]; 4], b: &[[f32; 2]; 4]) -> Ordering {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs
        .map(|(a, b)| a.total_cmp(b))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn invalid_images_are_refused() {
        let image = |width, height, bytes| Image {
            stamp: SimTime::default(),
            width,
            height,
            rgb: vec![0; bytes],
        };
        assert!(check_image(&image(2, 3, 18)).is_ok());
        for bad in [
            image(0, 3, 0),
            image(2, 3, 17),
            image(2, 3, 19),
            image(MAX_SIDE_PX + 1, 1, 3 * 8193),
        ] {
            assert!(
                matches!(check_image(&bad), Err(ReaderError::BadImage { .. })),
                "{} x {}",
                bad.width,
                bad.height
            );
        }
    }

    #[test]
    fn readings_are_sorted_by_confidence_then_place() {
        let at = |confidence, x: f32| PlateReading {
            text: "a".into(),
            confidence,
            corners: [[x, 0.0]; 4],
        };
        let mut readings = [at(0.5, 1.0), at(0.9, 7.0), at(0.5, 0.0)];
        sort_readings(&mut readings);
        assert_eq!(readings.map(|r| r.corners[0][0]), [7.0, 0.0, 1.0]);
    }
}
