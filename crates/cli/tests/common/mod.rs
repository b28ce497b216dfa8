//! Runs the real binary in a folder of its own.
#![allow(dead_code, unused_imports, reason = "no test file uses all of it")]

pub mod endpoint;
mod ran;
#[path = "../../../skips.rs"]
mod skips;
pub mod town;

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

pub use ran::Ran;
pub use skips::{shared_data, skipped};

/// A folder with the files of a test.
pub struct Place(TempDir);

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.path(name), content).unwrap();
        self
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Runs `openbench` with these words, here. No key of the user's reaches it.
    pub fn openbench(&self, words: &str) -> Ran {
        self.openbench_with(&words.split_whitespace().collect::<Vec<_>>())
    }

    pub fn openbench_with(&self, words: &[&str]) -> Ran {
        let mut command = Command::new(env!("CARGO_BIN_EXE_openbench"));
        for key in [
            "OPENBENCH_LOG",
            "OPENBENCH_API_BASE",
            "OPENBENCH_API_KEY",
            "OPENAI_API_KEY",
            "ANTHROPIC_API_KEY",
            "GEMINI_API_KEY",
        ] {
            command.env_remove(key);
        }
        command.env("OPENBENCH_API_TIMEOUT", "2");
        let output = command
            .args(words)
            .current_dir(self.0.path())
            .output()
            .unwrap();
        let ran = Ran::of(output);
        assert!(
            !ran.stderr.contains("panicked"),
            "{words:?}: {}",
            ran.stderr
        );
        ran
    }
}

/// Whether the files of the default reader have been pulled; they are not fetched for a test.
pub fn can_read(place: &Place) -> bool {
    let models = place.openbench("models list").stdout;
    let here = |line: &&str| line.starts_with("ppocr-v4") && !line.contains("not here");
    let all = models.lines().filter(here).count() >= 2;
    if !all {
        skipped("the model files of ppocr-v4 are not here");
    }
    all
}
