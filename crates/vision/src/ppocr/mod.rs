//! Plate reading with PP-OCR: a network that finds lines of text, another that reads them, both run by `rten`.
//!
//! Follows the published inference recipe of PP-OCR (differentiable binarisation for detection, CTC for recognition) with
//! two changes that suit plates and a level camera: a line's box has vertical sides (see `boxes.rs`), and no classifier turns
//! upside-down text. Text that runs down the image is left out.
//!
//! A reading is not proof: a box that misses the last stroke of a number gives a shorter number with a clear conscience, so ask for two views.
//!
//! Every line is recognised on its own, at its own width, so a reading does not depend on what else is in the image; one thread
//! computes everything, so it does not depend on the number of cores either. The low bits depend on the processor's instruction set.

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

/// A [`PlateReader`] with PP-OCR's mobile networks. A clone shares them but has a thread of its own, so that two read at once.
pub struct PpOcr {
    detector: Arc<Detector>,
    recogniser: Arc<Recogniser>,
    thread: Arc<ThreadPool>,
    settings: PpOcrSettings,
}

impl PpOcr {
    /// Loads both networks. `keys` is the alphabet, one character a line, the first line standing for CTC's blank; networks of version 4
    /// have theirs inside.
    ///
    /// # Errors
    /// [`ReaderError::Model`] names the file that is missing or broken.
    pub fn load(detection: &Path, recognition: &Path, keys: Option<&Path>) -> Result<Self, ReaderError> {
        let detector = Arc::new(Detector::load(detection)?);
        let recogniser = Arc::new(Recogniser::load(recognition, keys)?);
        Ok(Self { detector, recogniser, thread: one_thread(), settings: PpOcrSettings::default() })
    }

    /// Loads the files of the set `ppocr-v4` from `store`, where they have been pulled.
    ///
    /// # Errors
    /// [`ReaderError::Model`] names the file that is missing or broken.
    pub fn from_store(store: &ModelStore) -> Result<Self, ReaderError> {
        let [detection, recognition] =
            ["ppocr-v4-det", "ppocr-v4-rec"].map(|name| store.folder().join(format!("{name}.onnx")));
        Self::load(&detection, &recognition, None)
    }

    /// The same reader with other settings.
    #[must_use]
    pub fn with_settings(mut self, settings: PpOcrSettings) -> Self {
        self.settings = settings;
        self
    }

    fn read_box(&self, image: &Image, text_box: &TextBox) -> Result<Option<PlateReading>, ReaderError> {
        if text_box.runs_down() {
            return Ok(None);
        }
        let strip = crop::strip(image, &text_box.corners);
        let Line { text, confidence } = self.recogniser.read(strip, &self.thread)?;
        let text = text.trim();
        let legible = !text.is_empty() && confidence >= self.settings.min_confidence;
        Ok(legible.then(|| PlateReading { text: text.into(), confidence, corners: text_box.corners }))
    }
}

impl Clone for PpOcr {
    fn clone(&self) -> Self {
        let (detector, recogniser) = (self.detector.clone(), self.recogniser.clone());
        Self { detector, recogniser, thread: one_thread(), settings: self.settings }
    }
}

/// One thread: sums that are split over several depend on their number.
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
