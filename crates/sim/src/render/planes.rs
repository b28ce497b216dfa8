//! The light of a picture.

use super::block::SIDE;
use super::view::ImageSize;

/// Pixels around a picture that repeat its edges, so that nothing is read outside.
pub(super) const MARGIN: usize = 16;

/// Light by pixel and channel, with a margin around the picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LightPlanes {
    pub(crate) size: ImageSize,
    /// Pixels from a row to the next.
    pub(super) stride: usize,
    pub(super) channels: [Vec<f32>; 3],
    /// For each block the mean of the inverse depths, 1/m.
    pub(super) nearness: Vec<f32>,
    /// Blocks in a row.
    pub(super) columns: usize,
}

impl LightPlanes {
    pub(super) fn new(size: ImageSize) -> Self {
        let blocks = |pixels: u32| (pixels as usize).div_ceil(SIDE);
        let (columns, rows) = (blocks(size.width), blocks(size.height));
        let stride = SIDE * columns + 2 * MARGIN;
        let pixels = stride * (SIDE * rows + 2 * MARGIN);
        Self {
            size,
            stride,
            channels: std::array::from_fn(|_| vec![0.0; pixels]),
            nearness: vec![0.0; columns * rows],
            columns,
        }
    }

    /// Index of a pixel in a channel.
    #[inline(always)]
    pub(super) fn index(&self, column: usize, row: usize) -> usize {
        (row + MARGIN) * self.stride + column + MARGIN
    }

    /// Mean of the grey values, 0 to 255, at `factor` times the light.
    pub(crate) fn mean_grey(&self, factor: f32) -> f64 {
        let [red, green, blue] = &self.channels;
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let mut sum = 0.0;
        for row in 0..height {
            let at = self.index(0, row);
            let rows = [red, green, blue].map(|channel| &channel[at..at + width]);
            for ((red, green), blue) in rows[0].iter().zip(rows[1]).zip(rows[2]) {
                // Weighted as in ITU-R BT.601; white does not become whiter.
                let light = factor * (0.299 * red + 0.587 * green + 0.114 * blue);
                sum += f64::from(light.min(1.0)).sqrt();
            }
        }
        255.0 * sum / (width * height).max(1) as f64
    }

    /// Repeats the picture's edges in its margin.
    pub(super) fn spread_edges(&mut self) {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        if width == 0 || height == 0 {
            return;
        }
        let (stride, first, last) = (self.stride, self.index(0, 0), self.index(0, height - 1));
        for channel in &mut self.channels {
            for row in channel.chunks_exact_mut(stride).skip(MARGIN).take(height) {
                let (left, right) = (row[MARGIN], row[MARGIN + width - 1]);
                row[..MARGIN].fill(left);
                row[MARGIN + width..].fill(right);
            }
            let (top, bottom) = (first - MARGIN, last - MARGIN);
            let rows = channel.len() / stride;
            for row in 0..MARGIN {
                channel.copy_within(top..top + stride, row * stride);
            }
            for row in MARGIN + height..rows {
                channel.copy_within(bottom..bottom + stride, row * stride);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_margin_repeats_the_edges() {
        let mut planes = LightPlanes::new(ImageSize::new(10, 5));
        for row in 0..5 {
            for column in 0..10 {
                let at = planes.index(column, row);
                planes.channels[1][at] = (10 * row + column) as f32;
            }
        }
        planes.spread_edges();
        let seen = |column: usize, row: usize| planes.channels[1][row * planes.stride + column];
        assert_eq!((seen(0, 0), seen(MARGIN + 3, 2)), (0.0, 3.0));
        assert_eq!(seen(planes.stride - 1, MARGIN + 20), 49.0);
    }

    #[test]
    fn the_mean_grey_grows_with_the_root_of_the_light() {
        let mut planes = LightPlanes::new(ImageSize::new(10, 5));
        planes
            .channels
            .iter_mut()
            .for_each(|channel| channel.fill(0.01));
        assert!((planes.mean_grey(1.0) - 25.5).abs() < 0.1);
        assert!((planes.mean_grey(4.0) - 51.0).abs() < 0.1);
        assert!((planes.mean_grey(1e6) - 255.0).abs() < 0.1);
    }
}
