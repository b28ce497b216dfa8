//! Where the answers of models go, or come from.

use std::path::PathBuf;

/// Where what language and vision models answer in an episode goes, or comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Exchanges {
    /// Models are asked, and nothing is kept.
    #[default]
    Unkept,
    /// Models are asked, and their answers are kept in this file. Without models there is none.
    Keep(PathBuf),
    /// No model is asked: the answers are those in this file.
    Repeat(PathBuf),
}
