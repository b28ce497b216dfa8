//! Sampling of 8-bit RGB images.

use openbench_core::Image;

/// Colour at (`x`, `y`), bilinear between pixel centres (which lie at half coordinates); beyond the border, the border's.
/// Channels are blue, green, red, 0 to 255: the order in which PP-OCR was trained.
pub(super) fn bgr_at(image: &Image, x: f32, y: f32) -> [f32; 3] {
    let columns = Neighbours::at(x, image.width);
    let rows = Neighbours::at(y, image.height);
    let row_at = |row: usize| {
        let left = pixel(image, columns.first, row);
        let right = pixel(image, columns.second, row);
        mix(left, right, columns.share)
    };
    mix(row_at(rows.first), row_at(rows.second), rows.share)
}

fn pixel(image: &Image, column: usize, row: usize) -> [f32; 3] {
    let start = 3 * (row * image.width as usize + column);
    [2, 1, 0].map(|channel| f32::from(image.rgb[start + channel]))
}

/// The two pixels between whose centres a position lies.
struct Neighbours {
    first: usize,
    second: usize,
    /// How far it is from the first to the second, 0 to 1.
    share: f32,
}

impl Neighbours {
    fn at(position: f32, count: u32) -> Self {
        let last = (count - 1) as f32;
        let place = (position - 0.5).clamp(0.0, last);
        let first = place as usize;
        Self { first, second: (first + 1).min(last as usize), share: place - first as f32 }
    }
}

fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn samples_between_pixel_centres_and_clamps_outside() {
        let image =
            Image { stamp: SimTime::default(), width: 2, height: 1, rgb: vec![0, 10, 20, 100, 110, 120] };
        assert_eq!(bgr_at(&image, 0.5, 0.5), [20.0, 10.0, 0.0]);
        assert_eq!(bgr_at(&image, 1.0, 0.5), [70.0, 60.0, 50.0]);
        assert_eq!(bgr_at(&image, -9.0, 9.0), [20.0, 10.0, 0.0]);
        assert_eq!(bgr_at(&image, 9.0, -9.0), [120.0, 110.0, 100.0]);
    }
}
