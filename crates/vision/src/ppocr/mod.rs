//! Plate reading with PP-OCR: one network detects lines of text, another recognizes them.
//!
//! The method is the published inference of PP-OCR: differentiable binarization for detection, CTC
//! for recognition. Two changes suit plates and a level camera. The box of a line has vertical
//! sides (see `boxes.rs`), and no classifier corrects upside-down text. Vertical text is ignored.
//!
//! A single reading is no proof: a box without the last stroke of a number yields a shorter number
//! with high confidence. Compare readings of two views.
//!
//! Each line is recognized separately, at its own width, so a reading does not depend on other
//! texts of the image. One thread computes all sums, so a reading does not depend on the number of
//! cores. The last bits depend on the instruction set of the processor.

mod boxes;
mod crop;
mod detect;
mod entry;
mod keys;
mod network;
mod pixels;
mod recognise;
mod settings;

use std::path::Path;
use std::sync::Arc;

use openbench_core::Image;
use openbench_models::ModelStore;
use rten::ThreadPool;

use crate::error::ReaderError;
use crate::reader::{PlateReader, PlateReading, check_image, sort_readings};
use boxes::TextBox;
use detect::Detector;
use recognise::{Line, Recogniser};

pub use entry::entry;
pub use settings::PpOcrSettings;

/// A [`PlateReader`] with the mobile networks of PP-OCR.
///
/// Clones share the networks, but each has its own thread, so that clones can read at the same
/// time.
///
/// ```no_run
/// use openbench_models::ModelStore;
/// use openbench_vision::{PpOcr, PpOcrSettings};
///
/// let store = ModelStore::from_environment()?;
/// // A level camera sees plates above the horizon only.
/// let settings = PpOcrSettings { upper_part: 0.6, ..PpOcrSettings::default() };
/// let reader = PpOcr::from_store(&store)?.with_settings(settings);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PpOcr {
    detector: Arc<Detector>,
    recogniser: Arc<Recogniser>,
    thread: Arc<ThreadPool>,
    settings: PpOcrSettings,
}

impl PpOcr {
    /// Loads both networks. `keys` is the file of the alphabet: one character on each line, after a
    /// first line for the blank of CTC. Networks of version 4 contain their alphabet.
    ///
    /// # Errors
    /// [`ReaderError::Model`] with the file that is missing or damaged.
    pub fn load(
        detection: &Path,
        recognition: &Path,
        keys: Option<&Path>,
    ) -> Result<Self, ReaderError> {
        let detector = Arc::new(Detector::load(detection)?);
        let recogniser = Arc::new(Recogniser::load(recognition, keys)?);
        Ok(Self {
            detector,
            recogniser,
            thread: one_thread(),
            settings: PpOcrSettings::default(),
        })
    }

    /// Loads the files of the set `ppocr-v4` from `store`, which must contain them.
    ///
    /// # Errors
    /// [`ReaderError::Model`] with the file that is missing or damaged.
    pub fn from_store(store: &ModelStore) -> Result<Self, ReaderError> {
        let [detection, recognition] = ["ppocr-v4-det", "ppocr-v4-rec"]
            .map(|name| store.folder().join(format!("{name}.onnx")));
        Self::load(&detection, &recognition, None)
    }

    /// The same reader with other settings.
    #[must_use]
    pub fn with_settings(mut self, settings: PpOcrSettings) -> Self {
        self.settings = settings;
        self
    }

    fn read_box(
        &self,
        image: &Image,
        text_box: &TextBox,
    ) -> Result<Option<PlateReading>, ReaderError> {
        // The recognition network reads horizontal lines; on a vertical one it would yield a false
        // text.
        if text_box.is_vertical() {
            return Ok(None);
        }
        let strip = crop::strip(image, &text_box.corners);
        let Line { text, confidence } = self.recogniser.read(strip, &self.thread)?;
        let text = text.trim();
        let legible = !text.is_empty() && confidence >= self.settings.min_confidence;
        Ok(legible.then(|| PlateReading {
            text: text.into(),
            confidence,
            corners: text_box.corners,
        }))
    }
}

impl Clone for PpOcr {
    fn clone(&self) -> Self {
        let (detector, recogniser) = (self.detector.clone(), self.recogniser.clone());
        Self {
            detector,
            recogniser,
            thread: one_thread(),
            settings: self.settings,
        }
    }
}

/// A pool of one thread: sums over several threads depend on their number.
fn one_thread() -> Arc<ThreadPool> {
    Arc::new(ThreadPool::with_num_threads(1))
}

impl PlateReader for PpOcr {
    fn name(&self) -> &str {
        "ppocr"
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        check_image(image)?;
        let boxes = self.detector.find(image, &self.settings, &self.thread)?;
        let mut readings = Vec::new();
        for text_box in &boxes {
            readings.extend(self.read_box(image, text_box)?);
        }
        sort_readings(&mut readings);
        Ok(readings)
    }
}
