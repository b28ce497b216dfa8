//! Plate readers by name: those of this crate, and those of a list in which each stands in for the
//! one before it.

use openbench_core::{Registry, UnknownName};

use crate::error::Cause;
use crate::in_turn::InTurn;
use crate::part::{ReaderContext, ReaderPart};
use crate::reader::PlateReader;
use crate::{ppocr, vlm};

/// Plate readers by name. [`built_in`] has those of this crate.
///
/// ```
/// use openbench_vision::readers::{built_in, model_files};
///
/// let readers = built_in();
/// let list = "ppocr-v4, openai:qwen2.5-vl@https://llm.example/v1";
/// assert_eq!(readers.split(list), ["ppocr-v4", "openai:qwen2.5-vl@https://llm.example/v1"]);
/// assert_eq!(model_files(&readers, list), ["ppocr-v4"]);
/// assert!(readers.find("tesseract").is_err());
/// ```
pub type Readers = Registry<ReaderPart>;

/// Why the readers of a list cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MakeReaderError {
    /// No reader has that name.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// The constructor of a reader fails.
    #[error("cannot make the plate reader `{name}`")]
    Make {
        /// The name.
        name: String,
        /// The error of the constructor.
        source: Cause,
    },
}

/// The readers of this crate. To add one, write a file with its entry and add it here.
pub fn built_in() -> Readers {
    Registry::new("plate reader")
        .with_entry(ppocr::entry())
        .with_entries(vlm::entries())
}

/// The sets of model files that the readers of a list require, without duplicates.
///
/// Names that are not registered require none.
pub fn model_files<'r>(readers: &'r Readers, list: &str) -> Vec<&'r str> {
    let mut sets: Vec<&str> = Vec::new();
    for name in readers.split(list) {
        let found = readers.find(name).ok();
        let set = found.and_then(|found| found.entry.part.model_files());
        if let Some(set) = set.filter(|set| !sets.contains(set)) {
            sets.push(set);
        }
    }
    sets
}

/// Makes the readers of a list. Several are combined by [`InTurn`]: the next one reads where one
/// fails.
///
/// # Errors
/// [`MakeReaderError`] of the first reader that cannot be made.
pub fn make(
    readers: &Readers,
    list: &str,
    context: &mut ReaderContext<'_>,
) -> Result<Box<dyn PlateReader>, MakeReaderError> {
    // An empty list yields an empty name, and so the error that names what there is.
    let mut names = readers.split(list).into_iter();
    let first = make_one(readers, names.next().unwrap_or_default(), context)?;
    let others: Vec<_> = names
        .map(|name| make_one(readers, name, context))
        .collect::<Result<_, _>>()?;
    Ok(if others.is_empty() {
        first
    } else {
        Box::new(InTurn::new(first, others))
    })
}

fn make_one(
    readers: &Readers,
    name: &str,
    context: &mut ReaderContext<'_>,
) -> Result<Box<dyn PlateReader>, MakeReaderError> {
    let found = readers.find(name)?;
    let made = found.entry.part.make(found.argument, context);
    made.map_err(|source| MakeReaderError::Make {
        name: name.to_owned(),
        source,
    })
}
