//! Detection of lines of text.
//!
//! The input of the network has values from -1 to 1. PaddleOCR normalizes with the mean and
//! standard deviation of ImageNet, which found fewer distant and oblique plates on drawn images.

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

/// The name of this stage in errors.
const STAGE: &str = "detection";
/// Sides of the input are multiples of this, since the network halves them five times, pixels.
const STRIDE_PX: u32 = 32;

/// Detects lines of text.
pub(super) struct Detector {
    network: Network,
}

impl Detector {
    pub(super) fn load(file: &Path) -> Result<Self, ReaderError> {
        Ok(Self {
            network: Network::load(file, STAGE)?,
        })
    }

    /// Boxes around lines of text, in pixels of the image, the most probable first.
    pub(super) fn find(
        &self,
        image: &Image,
        settings: &PpOcrSettings,
        thread: &Arc<ThreadPool>,
    ) -> Result<Vec<TextBox>, ReaderError> {
        let view = View::new(image, settings);
        let map: NdTensor<f32, 4> = self.network.run(view.tensor(image), thread)?;
        // A network that returns a map of another scale would put all boxes in the wrong places.
        if map.shape() != [1, 1, view.rows, view.columns] {
            let detail = format!(
                "a map of {:?} for {} x {} pixels",
                map.shape(),
                view.columns,
                view.rows
            );
            return Err(ReaderError::Inference {
                stage: STAGE,
                source: detail.into(),
            });
        }
        let found = boxes::in_map(map.slice((0, 0)), settings);
        Ok(found
            .into_iter()
            .map(|text_box| text_box.scaled(view.scale))
            .collect())
    }
}

/// The part of the image in the input of the network.
struct View {
    columns: usize,
    rows: usize,
    /// Pixels of the image per pixel of the input, along x and y.
    scale: [f32; 2],
}

impl View {
    fn new(image: &Image, settings: &PpOcrSettings) -> Self {
        // `clamp` keeps NaN, so it is excluded first.
        let share = if settings.upper_part.is_finite() {
            settings.upper_part.clamp(0.0, 1.0)
        } else {
            1.0
        };
        let (width, height) = (image.width as f32, (image.height as f32 * share).max(1.0));
        // Scaling up adds no detail, only time.
        let shrink = (settings.detection_side.max(STRIDE_PX) as f32 / width.max(height)).min(1.0);
        let (columns, rows) = (network_side(width, shrink), network_side(height, shrink));
        Self {
            columns,
            rows,
            // The sides are rounded to strides one by one, so the scales differ a little along x
            // and y.
            scale: [width / columns as f32, height / rows as f32],
        }
    }

    fn tensor(&self, image: &Image) -> NdTensor<f32, 4> {
        let mut tensor = NdTensor::zeros([1, 3, self.rows, self.columns]);
        // A new tensor is contiguous, so the data are there.
        let Some(data) = tensor.data_mut() else {
            return tensor;
        };
        let plane = self.rows * self.columns;
        for index in 0..plane {
            let (row, column) = (index / self.columns, index % self.columns);
            let bgr = bgr_at(
                image,
                (column as f32 + 0.5) * self.scale[0],
                (row as f32 + 0.5) * self.scale[1],
            );
            for channel in 0..3 {
                data[channel * plane + index] = bgr[channel] / 127.5 - 1.0;
            }
        }
        tensor
    }
}

/// The side of the input for a length of the image: scaled, and a multiple of the stride.
fn network_side(length: f32, shrink: f32) -> usize {
    let strides = (length * shrink / STRIDE_PX as f32).round() as u32;
    (strides.max(1) * STRIDE_PX) as usize
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    fn view(width: u32, height: u32, settings: PpOcrSettings) -> View {
        let image = Image {
            stamp: SimTime::default(),
            width,
            height,
            rgb: Vec::new(),
        };
        View::new(&image, &settings)
    }

    #[test]
    fn sides_are_multiples_of_the_stride() {
        let whole = view(640, 480, PpOcrSettings::default());
        assert_eq!(
            (whole.columns, whole.rows, whole.scale),
            (640, 480, [1.0, 1.0])
        );
        let odd = view(1000, 10, PpOcrSettings::default());
        assert_eq!((odd.columns, odd.rows), (640, 32));
        assert_eq!(
            [
                odd.columns as f32 * odd.scale[0],
                odd.rows as f32 * odd.scale[1]
            ],
            [1000.0, 10.0]
        );
    }

    #[test]
    fn the_upper_part_is_cropped_and_not_scaled() {
        let part = view(
            640,
            480,
            PpOcrSettings {
                upper_part: 0.6,
                ..PpOcrSettings::default()
            },
        );
        assert_eq!(
            (part.columns, part.rows, part.scale),
            (640, 288, [1.0, 1.0])
        );
    }

    #[test]
    fn small_images_are_not_enlarged_and_invalid_settings_are_corrected() {
        assert_eq!(view(64, 64, PpOcrSettings::default()).columns, 64);
        let invalid = PpOcrSettings {
            detection_side: 0,
            upper_part: f32::NAN,
            ..PpOcrSettings::default()
        };
        assert_eq!(
            (
                view(640, 480, invalid).columns,
                view(640, 480, invalid).rows
            ),
            (32, 32)
        );
    }
}
