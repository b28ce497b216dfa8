//! Images in the size that a policy takes.

use std::borrow::Cow;

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
        let longest = image.width.max(image.height).max(1);
        let scaled = |length: u32| {
            let scaled = u64::from(length) * u64::from(side) / u64::from(longest);
            (scaled as usize).max(1)
        };
        let (width, height) = (scaled(image.width), scaled(image.height));
        let side = side as usize;
        let (left, above) = ((side - width) / 2, (side - height) / 2);
        let mut rgb = vec![0; 3 * side * side];
        let rows = Boxes::new(image.height as usize, height);
        let columns = Boxes::new(image.width as usize, width);
        let row_bytes = 3 * image.width as usize;
        // Sums of the bytes of the source rows that make a row of the square.
        let mut sums = vec![0_u32; row_bytes];
        for row in 0..height {
            sums.fill(0);
            for source in rows.of(row) {
                let bytes = &image.rgb[source * row_bytes..][..row_bytes];
                for (sum, byte) in sums.iter_mut().zip(bytes) {
                    *sum += u32::from(*byte);
                }
            }
            let to = &mut rgb[3 * (side * (above + row) + left)..][..3 * width];
            for (column, pixel) in to.chunks_exact_mut(3).enumerate() {
                let sources = columns.of(column);
                let count = (rows.of(row).len() * sources.len()) as u32;
                let mut totals = [0; 3];
                for source in sums[3 * sources.start..3 * sources.end].chunks_exact(3) {
                    (0..3).for_each(|channel| totals[channel] += source[channel]);
                }
                for (to, total) in pixel.iter_mut().zip(totals) {
                    *to = (total / count) as u8;
                }
            }
        }
        Cow::Owned(Image {
            stamp: image.stamp,
            width: side as u32,
            height: side as u32,
            rgb,
        })
    }
}

/// A row of pixels that are made fewer, each the mean of its neighbours.
#[derive(Debug, Clone, Copy)]
struct Boxes {
    from: usize,
    to: usize,
}

impl Boxes {
    fn new(from: usize, to: usize) -> Self {
        Self { from, to }
    }

    /// The pixels that make a pixel: at least one, also where pixels become more.
    fn of(self, pixel: usize) -> std::ops::Range<usize> {
        let start = pixel * self.from / self.to;
        start..((pixel + 1) * self.from / self.to).max(start + 1)
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
        // 168 rows, with 28 above and below them.
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

    #[test]
    fn each_pixel_is_the_mean_of_those_it_is_made_of() {
        let bytes: Vec<u8> = (0..3 * 32 * 32).map(|i| (i % 251) as u8).collect();
        let image = Image {
            stamp: SimTime::ZERO,
            width: 32,
            height: 32,
            rgb: bytes.clone(),
        };
        let half = Size::Square(16).of(&image);
        let byte = |column: usize, row: usize| u32::from(bytes[3 * (32 * row + column) + 1]);
        let mean = (byte(10, 20) + byte(11, 20) + byte(10, 21) + byte(11, 21)) / 4;
        assert_eq!(u32::from(half.rgb[3 * (16 * 10 + 5) + 1]), mean);
        // Larger than the image: each pixel is one of its pixels.
        assert_eq!(Size::Square(64).of(&image).rgb[..3], bytes[..3]);
    }
}
