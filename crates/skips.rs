//! What tests need that may be absent. Each test file includes this one with `#[path]`.

#![allow(dead_code, reason = "not every test needs all of it")]

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file or folder of the data beside the project. Where it is absent, the test that asks for it
/// is skipped, and says so.
pub fn shared_data(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(path);
    let here = path.exists();
    if !here {
        skipped(&format!("there is no {}", path.display()));
    }
    here.then_some(path)
}

/// Says that a test, or a part of it, is skipped. `.ci/run` lists these lines at its end.
pub fn skipped(reason: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // In one call, and not by `eprintln!`, which the harness keeps to itself if the test passes.
    let line = format!("\nSKIPPED {test}: {reason}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
}
