//! The published data, which the project does not hold.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of the published data; without it the test that asked for it is skipped, and says so.
pub fn published(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(path);
    let here = path.exists();
    if !here {
        skipped(&format!("{} is not here", path.display()));
    }
    here.then_some(path)
}

/// Says that a test is skipped, past the harness, which keeps to itself what passing tests print.
pub fn skipped(reason: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {reason}");
}
