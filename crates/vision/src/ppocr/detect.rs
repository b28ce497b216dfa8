//! Where text is: the detection network and its input, values -1 to 1. (PaddleOCR itself feeds ImageNet's mean and deviation; on drawn plates
//! that found fewer of the far and the oblique ones.)

use std::path::Path;
use std::sync::Arc;

use openbench_core::Image;
use rten::ThreadPool;
use rten_tensor::NdTensor;
use rten_tensor::prelude::*;

use super::boxes::{self, TextBox};
use super::network::Network;
use super::pixels::bgr_at;
use super::settings::PpOcrSettings;
use crate::error::ReaderError;

/// What errors call this network's work.
const STAGE: &str = "detection";
/// The network halves its input five times, so sides are multiples of this.
const STRIDE: u32 = 32;

/// Finds lines of text.
pub(super) struct Detector {
    network: Network,
}

impl Detector {
    pub(super) fn load(file: &Path) -> Result<Self, ReaderError> {
        Ok(Self { network: Network::load(file, STAGE)? })
    }

    /// Boxes around lines of text in image pixels, the likeliest first.
    pub(super) fn find(
        &self,
        image: &Image,
        settings: &PpOcrSettings,
        thread: &Arc<ThreadPool>,
    ) -> Result<Vec<TextBox>, ReaderError> {
        let view = View::new(image, settings);
        let map: NdTensor<f32, 4> = self.network.run(view.tensor(image), thread)?;
        if map.shape() != [1, 1, view.rows, view.columns] {
            let detail = format!("a map of {:?} for {} x {} pixels", map.shape(), view.columns, view.rows);
            return Err(ReaderError::Inference { stage: STAGE, source: detail.into() });
        }
        let found = boxes::in_map(map.slice((0, 0)), settings);
        Ok(found.into_iter().map(|text_box| text_box.scaled(view.scale)).collect())
    }
}

/// The part of the image that the network sees.
struct View {
    columns: usize,
    rows: usize,
    /// Image pixels per network pixel, along x and y.
    scale: [f32; 2],
}

impl View {
    fn new(image: &Image, settings: &PpOcrSettings) -> Self {
        let share = if settings.upper_part.is_finite() { settings.upper_part.clamp(0.0, 1.0) } else { 1.0 };
        let (width, height) = (image.width as f32, (image.height as f32 * share).max(1.0));
        let shrink = (settings.detection_side.max(STRIDE) as f32 / width.max(height)).min(1.0);
        let (columns, rows) = (network_side(width, shrink), network_side(height, shrink));
        Self { columns, rows, scale: [width / columns as f32, height / rows as f32] }
    }

    fn tensor(&self, image: &Image) -> NdTensor<f32, 4> {
        let mut tensor = NdTensor::zeros([1, 3, self.rows, self.columns]);
        let Some(data) = tensor.data_mut() else { return tensor };
        let plane = self.rows * self.columns;
        for index in 0..plane {
            let (row, column) = (index / self.columns, index % self.columns);
            let bgr =
                bgr_at(image, (column as f32 + 0.5) * self.scale[0], (row as f32 + 0.5) * self.scale[1]);
            for channel in 0..3 {
                data[channel * plane + index] = bgr[channel] / 127.5 - 1.0;
            }
        }
        tensor
    }
}

/// A length of the image in pixels of the network: shrunk, and a multiple of its stride.
fn network_side(length: f32, shrink: f32) -> usize {
    let strides = (length * shrink / STRIDE as f32).round() as u32;
    (strides.max(1) * STRIDE) as usize
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    fn view(width: u32, height: u32, settings: PpOcrSettings) -> View {
        let image = Image { stamp: SimTime::default(), width, height, rgb: Vec::new() };
        View::new(&image, &settings)
    }

    #[test]
    fn sides_are_multiples_of_the_stride_and_scales_lead_back() {
        let whole = view(640, 480, PpOcrSettings::default());
        assert_eq!((whole.columns, whole.rows, whole.scale), (640, 480, [1.0, 1.0]));
        let odd = view(1000, 10, PpOcrSettings::default());
        assert_eq!((odd.columns, odd.rows), (640, 32));
        assert_eq!([odd.columns as f32 * odd.scale[0], odd.rows as f32 * odd.scale[1]], [1000.0, 10.0]);
    }

    #[test]
    fn the_upper_part_is_cut_not_squeezed() {
        let part = view(640, 480, PpOcrSettings { upper_part: 0.6, ..PpOcrSettings::default() });
        assert_eq!((part.columns, part.rows, part.scale), (640, 288, [1.0, 1.0]));
    }

    #[test]
    fn small_images_are_not_enlarged_and_silly_settings_survived() {
        assert_eq!(view(64, 64, PpOcrSettings::default()).columns, 64);
        let silly = PpOcrSettings { detection_side: 0, upper_part: f32::NAN, ..PpOcrSettings::default() };
        assert_eq!((view(640, 480, silly).columns, view(640, 480, silly).rows), (32, 32));
    }
}
