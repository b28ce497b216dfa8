//! The contract with a plate reader: an image in, the texts on it out.

use std::cmp::Ordering;

use openbench_core::Image;

use crate::error::ReaderError;

/// The longest side of an image that readers accept, pixels. It bounds their memory.
pub const MAX_SIDE: u32 = 8192;

/// Something that finds and reads texts in a camera image.
///
/// The same image gives the same readings, whatever was read before. Readings stand in the order of falling confidence. What is no
/// text at all gives no reading; what is text but no plate is the caller's to leave out ([`crate::parse_unit`]).
pub trait PlateReader: Send {
    /// The reader's name as results report it.
    fn name(&self) -> &str;

    /// All texts that are legible in `image`.
    ///
    /// # Errors
    /// [`ReaderError::BadImage`] if the image's bytes do not fit its size; else what the reader's model reports.
    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError>;
}

impl<R: PlateReader + ?Sized> PlateReader for Box<R> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        (**self).read(image)
    }
}

/// One text in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateReading {
    /// The text as it was read, without white space at its ends; never empty.
    pub text: String,
    /// How sure the reader is of the text, 0 to 1.
    pub confidence: f32,
    /// Corners in pixels (x right, y down, the first pixel's outer corner is the origin), clockwise from the top left of the text.
    pub corners: [[f32; 2]; 4],
}

impl PlateReading {
    /// The mean of the corners, pixels.
    pub fn centre(&self) -> [f32; 2] {
        let mut sum = [0.0, 0.0];
        for [x, y] in self.corners {
            sum[0] += x;
            sum[1] += y;
        }
        [sum[0] / 4.0, sum[1] / 4.0]
    }
}

/// Whether the image is one: not empty, no side longer than [`MAX_SIDE`], three bytes a pixel.
pub(crate) fn check_image(image: &Image) -> Result<(), ReaderError> {
    let (width, height) = (image.width, image.height);
    let expected = 3 * width as usize * height as usize;
    let detail = if width == 0 || height == 0 {
        format!("{width} x {height} pixels")
    } else if width.max(height) > MAX_SIDE {
        format!("{width} x {height} pixels, but no side may exceed {MAX_SIDE}")
    } else if image.rgb.len() != expected {
        format!("{width} x {height} pixels need {expected} bytes, there are {}", image.rgb.len())
    } else {
        return Ok(());
    };
    Err(ReaderError::BadImage { detail })
}

/// Falling confidence; equal ones from left to right, then from top to bottom.
pub(crate) fn sort_readings(readings: &mut [PlateReading]) {
    readings
        .sort_by(|a, b| b.confidence.total_cmp(&a.confidence).then_with(|| by_place(&a.corners, &b.corners)));
}

fn by_place(a: &[[f32; 2]; 4], b: &[[f32; 2]; 4]) -> Ordering {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn images_whose_bytes_do_not_fit_are_refused() {
        let image =
            |width, height, bytes| Image { stamp: SimTime::default(), width, height, rgb: vec![0; bytes] };
        assert!(check_image(&image(2, 3, 18)).is_ok());
        for bad in [image(0, 3, 0), image(2, 3, 17), image(2, 3, 19), image(MAX_SIDE + 1, 1, 3 * 8193)] {
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
        let at = |confidence, x: f32| PlateReading { text: "a".into(), confidence, corners: [[x, 0.0]; 4] };
        let mut readings = [at(0.5, 1.0), at(0.9, 7.0), at(0.5, 0.0)];
        sort_readings(&mut readings);
        assert_eq!(readings.map(|r| r.corners[0][0]), [7.0, 0.0, 1.0]);
    }
}
