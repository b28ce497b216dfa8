//! Why an image was not read.

use std::path::PathBuf;

use openbench_models::ChatError;

/// An error of another library, kept as the source of ours.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why an image could not be read. An image without text is no error.
#[derive(Debug, thiserror::Error)]
pub enum ReaderError {
    /// The image is empty, too large, or its bytes do not fit its size.
    #[error("not an image: {detail}")]
    BadImage {
        /// What does not fit.
        detail: String,
    },
    /// The image cannot be written as a PNG file, in which form models see it.
    #[error("not an image: {0}")]
    Encoding(#[from] image::ImageError),
    /// A model file is missing, broken, or of another kind than expected.
    #[error("cannot use the model file {}: {source}; pull it again with `openbench models pull`", file.display())]
    Model {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: Cause,
    },
    /// The network failed on this image.
    #[error("text {stage} failed: {source}")]
    Inference {
        /// `detection` or `recognition`.
        stage: &'static str,
        /// What the runtime reported.
        source: Cause,
    },
    /// The chat model gave no answer.
    #[error("no reading from the vision-language model: {0}")]
    Chat(#[from] ChatError),
    /// The chat model's answer is not the list of plates that was asked for.
    #[error("{model} did not answer with a list of plates: {source}")]
    BadAnswer {
        /// The model's name.
        model: String,
        /// What is wrong with the answer.
        source: AnswerError,
    },
}

impl ReaderError {
    /// Whether the image is at fault, so that no other reader can read it either.
    pub(crate) fn is_about_image(&self) -> bool {
        matches!(self, Self::BadImage { .. } | Self::Encoding(_))
    }
}

/// What is wrong with a chat model's answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AnswerError {
    /// It holds no JSON.
    #[error("no JSON in `{quoted}`")]
    NoJson {
        /// The beginning of the answer.
        quoted: String,
    },
    /// Its JSON holds no list of plates.
    #[error("no list of plates in `{quoted}`")]
    NoList {
        /// The beginning of the answer.
        quoted: String,
    },
}
