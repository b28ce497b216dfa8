//! Registration of plate readers: a name, a description and a constructor.

use openbench_models::{ChatModel, ModelStore};

use crate::error::Cause;
use crate::reader::PlateReader;

/// Settings for all readers. A reader ignores those that do not apply to it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReaderSettings {
    /// The fraction of the image, from the top, in which plates can be, 0 to 1.
    pub upper_part: f32,
}

impl Default for ReaderSettings {
    /// Plates can be anywhere in an image.
    fn default() -> Self {
        Self { upper_part: 1.0 }
    }
}

impl ReaderSettings {
    /// The same settings for plates in this fraction of the image, from the top.
    #[must_use]
    pub fn with_upper_part(mut self, fraction: f32) -> Self {
        self.upper_part = fraction;
        self
    }
}

/// Opens the chat model of a name that [`openbench_models::ModelSpec`] reads.
///
/// The caller decides whether its calls are counted, limited, recorded or repeated.
pub type OpenModel<'a> = dyn FnMut(&str) -> Result<Box<dyn ChatModel>, Cause> + 'a;

/// What constructors of readers get.
#[non_exhaustive]
pub struct ReaderContext<'a> {
    /// Settings for all readers.
    pub settings: ReaderSettings,
    /// The folder of model files; `None` for the user's folder.
    pub store: Option<ModelStore>,
    /// Opens a chat model by its name.
    pub open_model: &'a mut OpenModel<'a>,
}

impl<'a> ReaderContext<'a> {
    /// A context with default settings, the user's folder of model files, and `open_model`.
    pub fn new(open_model: &'a mut OpenModel<'a>) -> Self {
        Self {
            settings: ReaderSettings::default(),
            store: None,
            open_model,
        }
    }

    /// The same context with other settings.
    #[must_use]
    pub fn with_settings(mut self, settings: ReaderSettings) -> Self {
        self.settings = settings;
        self
    }

    /// The same context with another folder of model files.
    #[must_use]
    pub fn with_store(mut self, store: ModelStore) -> Self {
        self.store = Some(store);
        self
    }
}

type Accepts = Box<dyn Fn(&str) -> bool + Send + Sync>;
type Make =
    Box<dyn Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause> + Send + Sync>;

/// A plate reader with the name by which it is made.
///
/// ```
/// use openbench_vision::{ReaderEntry, VlmReader};
///
/// // A short name for a model on a server in the local network.
/// let entry = ReaderEntry::new("house-model", "the model of our office", |_, context| {
///     let model = (context.open_model)("openai:qwen2.5-vl@http://10.0.0.7:8000/v1")?;
///     Ok(Box::new(VlmReader::new(model)))
/// });
/// assert!(entry.matches("house-model") && !entry.matches("openai:gpt-4o"));
/// ```
pub struct ReaderEntry {
    name: String,
    description: String,
    model_files: Option<String>,
    accepts: Option<Accepts>,
    make: Make,
}

impl ReaderEntry {
    /// A reader with this name and one-line description. `make` gets the name in use, which differs
    /// from `name` for readers with [`ReaderEntry::accepting`].
    pub fn new<F>(name: impl Into<String>, description: impl Into<String>, make: F) -> Self
    where
        F: Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause>
            + Send
            + Sync
            + 'static,
    {
        Self {
            name: name.into(),
            description: description.into(),
            model_files: None,
            accepts: None,
            make: Box::new(make),
        }
    }

    /// The same reader, which requires the files of a set in the catalogue of models.
    #[must_use]
    pub fn needing_files(mut self, set: impl Into<String>) -> Self {
        self.model_files = Some(set.into());
        self
    }

    /// The same reader under each name that `accepts` accepts, instead of its own name. It is for
    /// readers whose name contains an argument, such as the name of a model.
    #[must_use]
    pub fn accepting(mut self, accepts: impl Fn(&str) -> bool + Send + Sync + 'static) -> Self {
        self.accepts = Some(Box::new(accepts));
        self
    }

    /// Its name, or the form of its names.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its description, one line.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The set of model files that the reader requires.
    pub fn model_files(&self) -> Option<&str> {
        self.model_files.as_deref()
    }

    /// Whether a name is that of the reader.
    pub fn matches(&self, name: &str) -> bool {
        match &self.accepts {
            Some(accepts) => accepts(name),
            None => name == self.name,
        }
    }

    /// Whether a list of names begins with that of the reader.
    pub(crate) fn begins(&self, list: &str) -> bool {
        match &self.accepts {
            Some(accepts) => accepts(list),
            None => list.starts_with(&self.name),
        }
    }

    /// Makes the reader of a name.
    ///
    /// # Errors
    /// Any error of its constructor.
    pub fn make(
        &self,
        name: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, Cause> {
        (self.make)(name, context)
    }
}
