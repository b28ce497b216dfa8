//! Sampling of 8-bit RGB images.

use openbench_core::Image;

/// The colour at (`x`, `y`), pixels, interpolated bilinearly between centres of pixels.
///
/// Centres are at half coordinates; points outside the image have the colour of its border.
/// Channels are blue, green, red, 0 to 255: the order in which PP-OCR was trained.
pub(super) fn bgr_at(image: &Image, x: f32, y: f32) -> [f32; 3] {
    let columns = Neighbours::at(x, image.width);
    let rows = Neighbours::at(y, image.height);
    let row_at = |row: usize| {
        let left = pixel(image, columns.first, row);
        let right = pixel(image, columns.second, row);
        mix(left, right, columns.fraction)
    };
    mix(row_at(rows.first), row_at(rows.second), rows.fraction)
}

fn pixel(image: &Image, column: usize, row: usize) -> [f32; 3] {
    let start = 3 * (row * image.width as usize + column);
    [2, 1, 0].map(|channel| f32::from(image.rgb[start + channel]))
}

/// The two pixels between whose centres a coordinate lies.
struct Neighbours {
    first: usize,
    second: usize,
    /// Fraction of the distance from the first to the second, 0 to 1.
    fraction: f32,
}

impl Neighbours {
    fn at(position: f32, count: u32) -> Self {
        let last = (count - 1) as f32;
        // In units of pixel centres. The clamp repeats the border outside and keeps both indices
        // valid.
        let place = (position - 0.5).clamp(0.0, last);
        let first = place as usize;
        Self {
            first,
            second: (first + 1).min(last as usize),
            fraction: place - first as f32,
        }
    }
}

fn mix(a: [f32; 3], b: [f32; 3], fraction: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * fraction)
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn colours_are_interpolated_inside_and_clamped_outside() {
        let image = Image {
            stamp: SimTime::default(),
            width: 2,
            height: 1,
            rgb: vec![0, 10, 20, 100, 110, 120],
        };
        assert_eq!(bgr_at(&image, 0.5, 0.5), [20.0, 10.0, 0.0]);
        assert_eq!(bgr_at(&image, 1.0, 0.5), [70.0, 60.0, 50.0]);
        assert_eq!(bgr_at(&image, -9.0, 9.0), [20.0, 10.0, 0.0]);
        assert_eq!(bgr_at(&image, 9.0, -9.0), [120.0, 110.0, 100.0]);
    }
}
