//! What results were made from and with.

use serde::{Deserialize, Serialize};

use crate::worlds::Hashes;

/// A setting of an agent that was in force.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    /// Its value.
    pub value: String,
    /// Whether this is the value that it has if nothing is set.
    pub default: bool,
}

impl Setting {
    /// The value of a setting beside its default.
    pub fn new(value: impl Into<String>, default: &str) -> Self {
        let value = value.into();
        Self {
            default: value == default,
            value,
        }
    }
}

/// A model file that an agent used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelDigest {
    /// Its name in the catalogue of models; the name of its file for an agent in a file.
    pub name: String,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

/// The program that made a run.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Build {
    /// Commit of its source, with `-dirty` if that was edited; `unknown` outside a repository.
    pub commit: String,
    /// BLAKE3 of the program's file, hexadecimal: two builds of an edited source differ; empty if
    /// the file cannot be read.
    #[serde(default)]
    pub program: String,
    /// Target triple, such as `x86_64-unknown-linux-gnu`.
    pub target: String,
}

/// What a run was made from and with.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Provenance {
    /// The program.
    pub build: Build,
    /// Model name of the processor, if the system tells. Networks may differ in the last bits
    /// between processors.
    pub processor: Option<String>,
    /// BLAKE3 of suite, world, public map and true positions.
    pub hashes: Hashes,
    /// The model files that the agent used.
    pub models: Vec<ModelDigest>,
    /// Whether the agent, or a part of it, was told the truth about its episodes.
    #[serde(default)]
    pub uses_truth: bool,
    /// Why `verify --agent` cannot make this run again; null if it can.
    pub cannot_repeat: Option<String>,
}
