//! Registration of PP-OCR. Its readers share the networks, which are loaded once.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use openbench_core::registry::Entry;
use openbench_models::ModelStore;

use super::PpOcr;
use super::settings::PpOcrSettings;
use crate::error::Cause;
use crate::part::{ReaderContext, ReaderPart};

/// The name of the reader, and of the set of its model files.
const NAME: &str = "ppocr-v4";

/// The registration of the reader `ppocr-v4`.
pub fn entry() -> Entry<ReaderPart> {
    // Shared by all readers that this registration makes.
    let networks = Networks::default();
    let part = ReaderPart::new(move |_, context: &mut ReaderContext<'_>| {
        let store = match &context.store {
            Some(store) => store.clone(),
            None => ModelStore::from_environment()?,
        };
        let settings = PpOcrSettings {
            upper_part: context.settings.upper_part,
            ..PpOcrSettings::default()
        };
        let reader = networks.of(&store)?.with_settings(settings);
        Ok(Box::new(reader))
    });
    let about = "PP-OCR version 4 on the CPU";
    Entry::new(NAME, about, part.needing_files(NAME))
}

/// The networks that were loaded last.
#[derive(Default)]
struct Networks(Mutex<Option<Loaded>>);

struct Loaded {
    /// Their folder.
    folder: PathBuf,
    reader: PpOcr,
}

impl Networks {
    /// A reader with the networks of this folder, which are loaded unless they already are.
    fn of(&self, store: &ModelStore) -> Result<PpOcr, Cause> {
        // A panic while loading leaves the old value or none, both of which are valid.
        let mut loaded = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*loaded {
            // The clone shares the networks but has a thread of its own.
            Some(loaded) if loaded.folder == store.folder() => Ok(loaded.reader.clone()),
            _ => {
                let reader = PpOcr::from_store(store)?;
                let folder = store.folder().to_owned();
                *loaded = Some(Loaded {
                    folder,
                    reader: reader.clone(),
                });
                Ok(reader)
            }
        }
    }
}
