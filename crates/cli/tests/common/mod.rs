//! Runs the real binary in a folder of its own.
#![allow(dead_code, reason = "no test file uses all of it")]

pub mod town;
pub mod vlm;

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// A folder with the files of a test.
pub struct Place(TempDir);

/// What the binary did.
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

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
        for key in ["OPENBENCH_LOG", "OPENBENCH_API_BASE", "OPENBENCH_API_KEY", "OPENAI_API_KEY"] {
            command.env_remove(key);
        }
        let output = command.args(words).current_dir(self.0.path()).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let ran = Ran {
            code: output.status.code().unwrap_or(-1),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        };
        assert!(!ran.stderr.contains("panicked"), "{words:?}: {}", ran.stderr);
        ran
    }
}

impl Ran {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}{}", self.stdout, self.stderr))
    }

    /// Refused with exit code 2, nothing on stdout, and a message with all of these parts.
    pub fn refused_with(&self, parts: &[&str]) {
        assert_eq!((self.code, self.stdout.as_str()), (2, ""), "{}", self.stderr);
        parts
            .iter()
            .for_each(|part| assert!(self.stderr.contains(part), "{part:?} is not in: {}", self.stderr));
    }

    pub fn succeeded(&self) -> &Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }
}

/// The published data, which the project does not hold.
pub fn published(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    let here = path.exists();
    if !here {
        eprintln!("skipped: {} is not here", path.display());
    }
    here.then_some(path)
}
