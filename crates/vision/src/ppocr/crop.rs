//! Crops one line of text from an image: without shear, scaled to the height of the recognition
//! network's input.

use openbench_core::Image;
use rten_tensor::NdTensor;

use super::boxes::distance;
use super::pixels::bgr_at;

/// Height of a strip, pixels.
pub(super) const HEIGHT_PX: usize = 48;
/// Widths of strips are multiples of this, pixels.
const WIDTH_STEP_PX: usize = 8;
/// Minimum width of a strip, pixels: narrower text is padded with grey.
const MIN_WIDTH_PX: usize = 48;
/// Maximum width of a strip, pixels: wider text is compressed.
const MAX_WIDTH_PX: usize = 960;
/// Maximum number of samples along x and along y whose mean is a pixel of a strip.
const MAX_SAMPLES: usize = 4;

/// The strip inside `corners` (clockwise from the top left).
///
/// The shape is `[1, 3, 48, width]`: one image, blue, green and red, rows, columns. Values are -1
/// to 1, and 0 (grey) beyond the text.
pub(super) fn strip(image: &Image, corners: &[[f32; 2]; 4]) -> NdTensor<f32, 4> {
    let (across, down) = (
        distance(corners[0], corners[1]),
        distance(corners[0], corners[3]).max(1.0),
    );
    // The aspect ratio of the text is kept, as PP-OCR does.
    let text_width = ((HEIGHT_PX as f32 * across / down).round() as usize).clamp(1, MAX_WIDTH_PX);
    let width = text_width.max(MIN_WIDTH_PX).next_multiple_of(WIDTH_STEP_PX);
    // About one sample for each pixel of the image: a strip of large text sampled once a pixel
    // would alias.
    let samples = ((down / HEIGHT_PX as f32).ceil() as usize).clamp(1, MAX_SAMPLES);
    let mut strip = NdTensor::zeros([1, 3, HEIGHT_PX, width]);
    for row in 0..HEIGHT_PX {
        for column in 0..text_width {
            let bgr = mean_colour(image, corners, [column, row], text_width, samples);
            for (channel, value) in bgr.into_iter().enumerate() {
                strip[[0, channel, row, column]] = value / 127.5 - 1.0;
            }
        }
    }
    strip
}

fn mean_colour(
    image: &Image,
    corners: &[[f32; 2]; 4],
    cell: [usize; 2],
    text_width: usize,
    samples: usize,
) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for index in 0..samples * samples {
        let u = (cell[0] as f32 + offset(index % samples, samples)) / text_width as f32;
        let v = (cell[1] as f32 + offset(index / samples, samples)) / HEIGHT_PX as f32;
        let [x, y] = within(corners, u, v);
        let colour = bgr_at(image, x, y);
        (0..3).for_each(|channel| sum[channel] += colour[channel]);
    }
    sum.map(|total| total / (samples * samples) as f32)
}

/// Position of a sample inside a pixel, 0 to 1.
fn offset(index: usize, samples: usize) -> f32 {
    (index as f32 + 0.5) / samples as f32
}

/// The point of a box at fractions `u` across and `v` down.
fn within(corners: &[[f32; 2]; 4], u: f32, v: f32) -> [f32; 2] {
    let [a, b, c, d] = corners;
    std::array::from_fn(|i| {
        // Upper and lower border at the same fraction. Boxes have vertical sides, so the line
        // between both points is vertical and the shear is gone.
        let (top, bottom) = (a[i] + (b[i] - a[i]) * u, d[i] + (c[i] - d[i]) * u);
        top + (bottom - top) * v
    })
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;
    use rten_tensor::prelude::*;

    use super::*;

    /// An image whose red increases to the right and whose green increases downwards.
    fn ramp() -> Image {
        let rgb = (0..100_u32 * 200)
            .flat_map(|i| [(i % 200) as u8, (i / 200) as u8, 0])
            .collect();
        Image {
            stamp: SimTime::default(),
            width: 200,
            height: 100,
            rgb,
        }
    }

    #[test]
    fn upright_boxes_keep_their_proportions() {
        let strip = strip(
            &ramp(),
            &[[20.0, 10.0], [120.0, 10.0], [120.0, 34.0], [20.0, 34.0]],
        );
        assert_eq!(strip.shape(), [1, 3, 48, 200]);
        let red = |column| (strip[[0, 2, 24, column]] + 1.0) * 127.5;
        assert!(
            (red(0) - 19.75).abs() < 0.3 && (red(199) - 119.25).abs() < 0.3,
            "{} {}",
            red(0),
            red(199)
        );
    }

    #[test]
    fn sloping_boxes_are_levelled() {
        // The text rises to the right.
        let strip = strip(
            &ramp(),
            &[[40.0, 60.0], [100.0, 20.0], [110.0, 35.0], [50.0, 75.0]],
        );
        let green = |column, row| (strip[[0, 1, row, column]] + 1.0) * 127.5;
        assert!(
            (green(0, 0) - 59.5).abs() < 1.0 && (green(190, 0) - 19.5).abs() < 1.5,
            "{}",
            green(190, 0)
        );
        assert!((green(0, 47) - 74.5).abs() < 1.0);
    }

    #[test]
    fn boxes_outside_the_image_or_without_extent_are_valid() {
        assert_eq!(strip(&ramp(), &[[-50.0, -50.0]; 4]).shape(), [1, 3, 48, 48]);
        let long = [[0.0, 0.0], [9000.0, 0.0], [9000.0, 2.0], [0.0, 2.0]];
        assert_eq!(strip(&ramp(), &long).shape(), [1, 3, 48, 960]);
    }
}
