//! Plate readers by name: those of this crate, and those that other crates add.

use crate::entry::{ReaderContext, ReaderEntry};
use crate::error::Cause;
use crate::in_turn::InTurn;
use crate::reader::PlateReader;
use crate::{ppocr, vlm};

/// Plate readers by name.
///
/// ```
/// use openbench_vision::ReaderRegistry;
///
/// let readers = ReaderRegistry::default();
/// let list = "ppocr-v4, openai:qwen2.5-vl@https://llm.example/v1";
/// assert_eq!(readers.split(list), ["ppocr-v4", "openai:qwen2.5-vl@https://llm.example/v1"]);
/// assert_eq!(readers.model_files(list), ["ppocr-v4"]);
/// assert!(readers.get("tesseract").is_none());
/// ```
#[derive(Clone)]
pub struct ReaderRegistry {
    /// If several match a name, the last one counts.
    entries: Vec<ReaderEntry>,
}

/// Why a reader cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// No reader has that name.
    #[error("unknown plate reader `{name}`; known are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
    /// The constructor of a reader fails.
    #[error("cannot make the plate reader `{name}`")]
    Make {
        /// The name.
        name: String,
        /// The error of the constructor.
        source: Cause,
    },
}

impl Default for ReaderRegistry {
    /// The readers of this crate. To add one, write a file with its entry and add it here.
    fn default() -> Self {
        Self::empty().with(ppocr::entry()).with(vlm::entry())
    }
}

impl ReaderRegistry {
    /// A registry without readers.
    pub fn empty() -> Self {
        Self {
            entries: Vec::new(),
        }
    }

    /// Adds a reader. It takes precedence over earlier ones that match the same name.
    #[must_use]
    pub fn with(mut self, entry: ReaderEntry) -> Self {
        self.entries.push(entry);
        self
    }

    /// All readers, in the order in which they were added.
    pub fn entries(&self) -> &[ReaderEntry] {
        &self.entries
    }

    /// The reader with this name.
    pub fn get(&self, name: &str) -> Option<&ReaderEntry> {
        self.entries.iter().rev().find(|entry| entry.matches(name))
    }

    /// Splits a list of names at its commas.
    ///
    /// A comma is a separator only if the name of a reader follows it, since names of models and of
    /// files may contain commas.
    pub fn split<'t>(&self, list: &'t str) -> Vec<&'t str> {
        let mut parts = Vec::new();
        let mut start = 0;
        for (at, _) in list.match_indices(',') {
            let rest = list[at + 1..].trim_start();
            if self.entries.iter().any(|entry| entry.begins(rest)) {
                parts.push(list[start..at].trim());
                start = at + 1;
            }
        }
        parts.push(list[start..].trim());
        parts
    }

    /// The sets of model files that the readers of a list require, without duplicates.
    pub fn model_files(&self, list: &str) -> Vec<&str> {
        let entries = self
            .split(list)
            .into_iter()
            .filter_map(|name| self.get(name));
        let mut sets: Vec<&str> = Vec::new();
        for set in entries.filter_map(ReaderEntry::model_files) {
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
        sets
    }

    /// Makes the readers of a list. Several are combined by [`InTurn`]: the next one reads where
    /// one fails.
    ///
    /// # Errors
    /// [`RegistryError`] of the first reader that cannot be made.
    pub fn make(
        &self,
        list: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, RegistryError> {
        let mut parts = self.split(list).into_iter();
        let first = self.make_one(parts.next().unwrap_or_default(), context)?;
        let others: Vec<_> = parts
            .map(|name| self.make_one(name, context))
            .collect::<Result<_, _>>()?;
        Ok(if others.is_empty() {
            first
        } else {
            Box::new(InTurn::new(first, others))
        })
    }

    fn make_one(
        &self,
        name: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, RegistryError> {
        let Some(entry) = self.get(name) else {
            let names: Vec<&str> = self.entries.iter().map(ReaderEntry::name).collect();
            return Err(RegistryError::Unknown {
                name: name.to_owned(),
                known: names.join(", "),
            });
        };
        entry
            .make(name, context)
            .map_err(|source| RegistryError::Make {
                name: name.to_owned(),
                source,
            })
    }
}
