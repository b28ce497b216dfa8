//! What a plate reader registers with: a name, a line about it, and how it is made.

use std::sync::Arc;

use openbench_models::{ChatModel, ModelStore};

use crate::error::Cause;
use crate::reader::PlateReader;

/// Settings that any reader may be given; one that has no use for a setting ignores it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReaderSettings {
    /// The share of an image's rows, from the top, in which plates can be, 0 to 1.
    pub upper_part: f32,
}

impl Default for ReaderSettings {
    /// Plates can be anywhere in an image.
    fn default() -> Self {
        Self { upper_part: 1.0 }
    }
}

impl ReaderSettings {
    /// The same settings with plates in this share of an image's rows, from the top, only.
    #[must_use]
    pub fn with_upper_part(mut self, share: f32) -> Self {
        self.upper_part = share;
        self
    }
}

/// Opens the chat model that a text names, as [`openbench_models::ModelSpec`] reads it.
///
/// Whoever makes readers decides how: counted, bounded, recorded or repeated.
pub type OpenModel<'a> = dyn FnMut(&str) -> Result<Box<dyn ChatModel>, Cause> + 'a;

/// What a reader is made from.
#[non_exhaustive]
pub struct ReaderContext<'a> {
    /// Settings that hold for all readers.
    pub settings: ReaderSettings,
    /// Where model files lie; `None` stands for the user's folder.
    pub store: Option<ModelStore>,
    /// Opens chat models.
    pub open_model: &'a mut OpenModel<'a>,
}

impl<'a> ReaderContext<'a> {
    /// Default settings, model files from the user's folder, chat models by `open_model`.
    pub fn new(open_model: &'a mut OpenModel<'a>) -> Self {
        Self { settings: ReaderSettings::default(), store: None, open_model }
    }

    /// The same context with other settings.
    #[must_use]
    pub fn with_settings(mut self, settings: ReaderSettings) -> Self {
        self.settings = settings;
        self
    }

    /// The same context with model files from another folder than the user's.
    #[must_use]
    pub fn with_store(mut self, store: ModelStore) -> Self {
        self.store = Some(store);
        self
    }
}

type Accepts = Arc<dyn Fn(&str) -> bool + Send + Sync>;
type Make = Arc<dyn Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause> + Send + Sync>;

/// A plate reader that can be asked for by its name.
#[derive(Clone)]
pub struct ReaderEntry {
    name: String,
    description: String,
    model_files: Option<String>,
    accepts: Option<Accepts>,
    make: Make,
}

impl ReaderEntry {
    /// A reader that is asked for by `name`. `make` gets the text by which it was asked for.
    pub fn new<F>(name: impl Into<String>, description: impl Into<String>, make: F) -> Self
    where
        F: Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause> + Send + Sync + 'static,
    {
        Self {
            name: name.into(),
            description: description.into(),
            model_files: None,
            accepts: None,
            make: Arc::new(make),
        }
    }

    /// The same reader, which also needs the files of a set in OpenBench's catalogue of models.
    #[must_use]
    pub fn needing_files(mut self, set: impl Into<String>) -> Self {
        self.model_files = Some(set.into());
        self
    }

    /// The same reader, which is asked for by every text that `accepts` accepts, and by its name
    /// no more. For readers whose name holds an argument, such as a model's name.
    #[must_use]
    pub fn accepting(mut self, accepts: impl Fn(&str) -> bool + Send + Sync + 'static) -> Self {
        self.accepts = Some(Arc::new(accepts));
        self
    }

    /// The name by which it is asked for, or the form of such names.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it is, in one line.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The set of model files that must be in the folder before the reader is made.
    pub fn model_files(&self) -> Option<&str> {
        self.model_files.as_deref()
    }

    /// Whether this text asks for the reader.
    pub fn is_meant_by(&self, text: &str) -> bool {
        match &self.accepts {
            Some(accepts) => accepts(text),
            None => text == self.name,
        }
    }

    /// Whether this text asks for the reader, or for it and for others after it.
    pub fn begins(&self, text: &str) -> bool {
        match &self.accepts {
            Some(accepts) => accepts(text),
            None => text.starts_with(&self.name),
        }
    }

    /// Makes the reader that a text asks for.
    ///
    /// # Errors
    /// Whatever its constructor reports.
    pub fn make(&self, text: &str, context: &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause> {
        (self.make)(text, context)
    }
}
