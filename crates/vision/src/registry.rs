//! Plate readers by name: those of this crate and any that are added.

use crate::entry::{ReaderContext, ReaderEntry};
use crate::error::Cause;
use crate::in_turn::InTurn;
use crate::reader::PlateReader;
use crate::{ppocr, vlm};

/// Plate readers that can be asked for by name.
#[derive(Clone)]
pub struct ReaderRegistry {
    /// Later ones come first where two mean the same text.
    entries: Vec<ReaderEntry>,
}

/// Why no reader was made.
#[derive(Debug, thiserror::Error)]
pub enum RegistryError {
    /// No reader has that name.
    #[error("there is no plate reader `{text}`; there are {known}")]
    Unknown {
        /// What was asked for.
        text: String,
        /// The names that there are.
        known: String,
    },
    /// A reader's model, its files or its settings cannot be used.
    #[error("the plate reader `{text}` cannot be made: {source}")]
    Make {
        /// What was asked for.
        text: String,
        /// What its constructor reported.
        source: Cause,
    },
}

impl Default for ReaderRegistry {
    /// The readers of this crate. A new one is a file with an entry, and a line here.
    fn default() -> Self {
        Self::empty().with(ppocr::entry()).with(vlm::entry())
    }
}

impl ReaderRegistry {
    /// No readers.
    pub fn empty() -> Self {
        Self { entries: Vec::new() }
    }

    /// Adds a reader, which goes before those that are there where both mean the same text.
    #[must_use]
    pub fn with(mut self, entry: ReaderEntry) -> Self {
        self.entries.push(entry);
        self
    }

    /// All readers, in the order in which they were added.
    pub fn entries(&self) -> &[ReaderEntry] {
        &self.entries
    }

    /// The reader that a text asks for.
    pub fn get(&self, text: &str) -> Option<&ReaderEntry> {
        self.entries.iter().rev().find(|entry| entry.is_meant_by(text))
    }

    /// The parts of a list of readers with commas between them.
    ///
    /// A comma parts two readers only where a reader's name begins after it: names of models and
    /// of files may hold commas themselves.
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

    /// The sets of model files that a list of readers needs, each once.
    pub fn model_files(&self, list: &str) -> Vec<&str> {
        let entries = self.split(list).into_iter().filter_map(|text| self.get(text));
        let mut sets: Vec<&str> = Vec::new();
        for set in entries.filter_map(ReaderEntry::model_files) {
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
        sets
    }

    /// Makes the readers of a list; of several the next is asked where one fails ([`InTurn`]).
    ///
    /// # Errors
    /// [`RegistryError`], of the first reader that cannot be made.
    pub fn make(
        &self,
        list: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, RegistryError> {
        let mut parts = self.split(list).into_iter();
        let first = self.make_one(parts.next().unwrap_or_default(), context)?;
        let others: Vec<_> = parts.map(|text| self.make_one(text, context)).collect::<Result<_, _>>()?;
        Ok(if others.is_empty() { first } else { Box::new(InTurn::new(first, others)) })
    }

    fn make_one(
        &self,
        text: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, RegistryError> {
        let Some(entry) = self.get(text) else {
            let names: Vec<&str> = self.entries.iter().map(ReaderEntry::name).collect();
            return Err(RegistryError::Unknown { text: text.to_owned(), known: names.join(", ") });
        };
        entry.make(text, context).map_err(|source| RegistryError::Make { text: text.to_owned(), source })
    }
}
