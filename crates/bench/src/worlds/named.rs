//! The suite that a user names.

use std::path::Path;

use super::{builtin_suite, folder};
use crate::BenchError;
use crate::suite::Suite;
use crate::suite::builtin::builtin_suites;

/// The suite that a word names: a built-in one, a suite file (`.toml`), or the folder of a world.
///
/// # Errors
/// A file that is no suite, a folder without a world, or a name that is unknown.
pub fn suite_named(name: &str) -> Result<Suite, BenchError> {
    let path = Path::new(name);
    if folder::is_world(path) {
        return folder::suite_of(path);
    }
    // A folder that happens to be called as a built-in suite does not hide the suite.
    if path.is_dir() && !builtin_suites().iter().any(|known| known == name) {
        return Err(BenchError::world(format!(
            "{name}: the folder has no world.toml; make a world with `openbench world generate`"
        )));
    }
    if path.extension().is_some_and(|e| e == "toml") {
        Suite::read(path)
    } else {
        builtin_suite(name)
    }
}
