//! PP-OCR as a registered reader: networks are loaded once and shared by all readers made later.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use openbench_models::ModelStore;

use super::PpOcr;
use super::settings::PpOcrSettings;
use crate::entry::{ReaderContext, ReaderEntry};
use crate::error::Cause;

/// The name of the reader, and of the set of its model files.
const NAME: &str = "ppocr-v4";

/// The reader `ppocr-v4`.
pub fn entry() -> ReaderEntry {
    let networks = Networks::default();
    let make = move |_: &str, context: &mut ReaderContext<'_>| {
        let store = match &context.store {
            Some(store) => store.clone(),
            None => ModelStore::from_environment()?,
        };
        let settings = PpOcrSettings { upper_part: context.settings.upper_part, ..PpOcrSettings::default() };
        let reader = networks.of(&store)?.with_settings(settings);
        Ok(Box::new(reader) as _)
    };
    let description = "PP-OCR version 4 on the CPU: finds lines of text and reads them";
    ReaderEntry::new(NAME, description, make).needing_files(NAME)
}

/// The networks that were loaded last, and the folder that they are from.
#[derive(Default)]
struct Networks(Mutex<Option<(PathBuf, PpOcr)>>);

impl Networks {
    /// The networks in this folder, loaded if they are not yet.
    fn of(&self, store: &ModelStore) -> Result<PpOcr, Cause> {
        let mut loaded = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*loaded {
            Some((folder, reader)) if folder == store.folder() => Ok(reader.clone()),
            _ => {
                let reader = PpOcr::from_store(store)?;
                *loaded = Some((store.folder().to_owned(), reader.clone()));
                Ok(reader)
            }
        }
    }
}
