//! What plate readers are made from, and how.

use std::sync::Arc;

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

type Make =
    dyn Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause> + Send + Sync;

/// A registered plate reader: its constructor, and the files that it requires.
///
/// ```
/// use openbench_vision::{ReaderPart, VlmReader, readers};
///
/// // A short name for the models on a server in the local network: `house:MODEL`.
/// let house = ReaderPart::new(|model, context| {
///     let model = (context.open_model)(&format!("openai:{model}@http://10.0.0.7:8000/v1"))?;
///     Ok(Box::new(VlmReader::new(model)))
/// });
/// let readers = readers::built_in().with("house:MODEL", "the models of our office", house);
/// assert_eq!(readers.find("house:qwen2.5-vl")?.argument, "qwen2.5-vl");
/// # Ok::<(), openbench_core::UnknownName>(())
/// ```
#[derive(Clone)]
pub struct ReaderPart {
    make: Arc<Make>,
    model_files: Option<String>,
}

impl ReaderPart {
    /// A reader with this constructor. It gets the argument, which is what follows the colon of
    /// `reader=NAME:ARGUMENT`, else nothing.
    pub fn new<F>(make: F) -> Self
    where
        F: Fn(&str, &mut ReaderContext<'_>) -> Result<Box<dyn PlateReader>, Cause>
            + Send
            + Sync
            + 'static,
    {
        Self {
            make: Arc::new(make),
            model_files: None,
        }
    }

    /// The same reader, which requires the files of a set in the catalogue of models.
    #[must_use]
    pub fn needing_files(mut self, set: impl Into<String>) -> Self {
        self.model_files = Some(set.into());
        self
    }

    /// The set of model files that the reader requires.
    pub fn model_files(&self) -> Option<&str> {
        self.model_files.as_deref()
    }

    /// Makes a reader with this argument.
    ///
    /// # Errors
    /// Any error of its constructor.
    pub fn make(
        &self,
        argument: &str,
        context: &mut ReaderContext<'_>,
    ) -> Result<Box<dyn PlateReader>, Cause> {
        (self.make)(argument, context)
    }
}
