//! Errors of reading an image.
//!
//! No text repeats its source: `openbench_core::with_causes` prints both.

use std::path::PathBuf;

use openbench_models::ChatError;

/// An error of another library, kept as the source of an error of this crate.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why an image cannot be read. An image without text is not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReaderError {
    /// The image is empty, too large, or its size and its number of bytes differ.
    #[error("not a valid image: {detail}")]
    BadImage {
        /// What is wrong with the image.
        detail: String,
    },
    /// The image cannot be encoded as PNG, the format for vision-language models.
    #[error("the image cannot be encoded as PNG")]
    Encoding(#[from] image::ImageError),
    /// A model file is missing, damaged, or of another kind than expected.
    #[error(
        "cannot use the model file {}; download it with `openbench models pull`",
        file.display()
    )]
    Model {
        /// The file.
        file: PathBuf,
        /// What is wrong with the file.
        source: Cause,
    },
    /// A network fails on this image.
    #[error("text {stage} failed")]
    Inference {
        /// `detection` or `recognition`.
        stage: &'static str,
        /// The error of the runtime.
        source: Cause,
    },
    /// The vision-language model does not answer.
    #[error("no answer of the vision-language model")]
    Chat(#[from] ChatError),
    /// The answer of the vision-language model is not a list of plates.
    #[error("{model} did not answer with a list of plates")]
    BadAnswer {
        /// Name of the model.
        model: String,
        /// What is wrong with the answer.
        source: AnswerError,
    },
}

impl ReaderError {
    /// Whether the cause is the image, so that no other reader can read it either.
    pub(crate) fn is_about_image(&self) -> bool {
        matches!(self, Self::BadImage { .. } | Self::Encoding(_))
    }
}

/// What is wrong with the answer of a vision-language model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnswerError {
    /// It contains no JSON.
    #[error("no JSON in `{quoted}`")]
    NoJson {
        /// The beginning of the answer.
        quoted: String,
    },
    /// Its JSON contains no list of plates.
    #[error("no list of plates in `{quoted}`")]
    NoList {
        /// The beginning of the answer.
        quoted: String,
    },
}
