//! Images in the size that a policy takes.

use std::borrow::Cow;

use image::RgbImage;
use image::imageops::{overlay, thumbnail};
use openbench_core::Image;

/// The size of the images that a policy gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// That of the camera.
    Camera,
    /// A square of so many pixels: the image is made smaller as a whole, with black above and below
    /// it, as openpi's clients do.
    Square(u32),
}

impl Size {
    /// The image in this size.
    pub fn of(self, image: &Image) -> Cow<'_, Image> {
        let Self::Square(side) = self else {
            return Cow::Borrowed(image);
        };
        let whole = RgbImage::from_raw(image.width, image.height, image.rgb.clone());
        // An image has three bytes a pixel.
        let whole = whole.unwrap_or_default();
        let longest = image.width.max(image.height).max(1);
        let scaled = |length: u32| {
            let scaled = u64::from(length) * u64::from(side) / u64::from(longest);
            (scaled as u32).max(1)
        };
        let (width, height) = (scaled(image.width), scaled(image.height));
        let small = thumbnail(&whole, width, height);
        let mut square = RgbImage::new(side, side);
        let left = i64::from((side - width) / 2);
        let above = i64::from((side - height) / 2);
        overlay(&mut square, &small, left, above);
        Cow::Owned(Image {
            stamp: image.stamp,
            width: side,
            height: side,
            rgb: square.into_raw(),
        })
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn the_whole_image_is_seen_in_the_middle() {
        // The left half is red, the right half blue.
        let row = [[200, 0, 0].repeat(320), [0, 0, 100].repeat(320)].concat();
        let image = Image {
            stamp: SimTime::from_millis(50),
            width: 640,
            height: 480,
            rgb: row.repeat(480),
        };
        let square = Size::Square(224).of(&image);
        assert_eq!(
            (square.width, square.height, square.stamp),
            (224, 224, image.stamp)
        );
        let pixel = |column: usize, row: usize| {
            let at = 3 * (224 * row + column);
            &square.rgb[at..at + 3]
        };
        // 168 rows, with 28 above and below.
        for row in [0, 27, 196, 223] {
            assert_eq!(pixel(50, row), [0, 0, 0]);
        }
        for row in [28, 195] {
            assert_eq!(
                (pixel(111, row), pixel(112, row)),
                (&[200, 0, 0][..], &[0, 0, 100][..])
            );
        }
        assert_eq!(Size::Camera.of(&image).as_ref(), &image);
    }
}
