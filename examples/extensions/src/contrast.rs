//! A plate reader: PP-OCR on an image whose contrast is stretched, for plates in shadow.

use openbench::PartError;
use openbench_core::Image;
use openbench_models::ModelStore;
use openbench_vision::{PlateReader, PlateReading, PpOcr, ReaderContext, ReaderError, ReaderPart};

/// Share of the darkest pixels that become black, and of the brightest that become white.
const CLIPPED: f64 = 0.01;

/// The reader by its name: `--set reader=contrast`. Its networks are downloaded before a run.
pub fn part() -> ReaderPart {
    ReaderPart::new(|_, context: &mut ReaderContext<'_>| make(context)).needing_files("ppocr-v4")
}

fn make(context: &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, PartError> {
    let store = match &context.store {
        Some(store) => store.clone(),
        None => ModelStore::from_environment()?,
    };
    Ok(Box::new(Contrast {
        reader: PpOcr::from_store(&store)?,
    }))
}

/// Stretches the contrast of an image, then reads it.
struct Contrast {
    reader: PpOcr,
}

impl PlateReader for Contrast {
    fn name(&self) -> &str {
        "contrast"
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        self.reader.read(&stretched(image))
    }
}

/// The image with its brightness spread over the whole range.
fn stretched(image: &Image) -> Image {
    let (dark, bright) = range(&image.rgb);
    let width = f64::from(bright - dark).max(1.0);
    let stretch = |v: &u8| (255.0 * (f64::from(*v) - f64::from(dark)) / width).clamp(0.0, 255.0);
    Image {
        rgb: image.rgb.iter().map(|v| stretch(v) as u8).collect(),
        ..image.clone()
    }
}

/// Brightness of the darkest and of the brightest values that are not clipped.
fn range(values: &[u8]) -> (u8, u8) {
    let mut counts = [0_usize; 256];
    for value in values {
        counts[usize::from(*value)] += 1;
    }
    let clipped = (CLIPPED * values.len() as f64) as usize;
    let at = |rank: usize| {
        let mut seen = 0;
        (0..=255_u8).find(|v| {
            seen += counts[usize::from(*v)];
            seen > rank
        })
    };
    let brightest = values.len().saturating_sub(1 + clipped);
    (at(clipped).unwrap_or(0), at(brightest).unwrap_or(255))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dull_image_uses_the_whole_range() {
        let values: Vec<u8> = (100..150).flat_map(|v| [v; 30]).collect();
        assert_eq!(range(&values), (100, 149));
    }
}
