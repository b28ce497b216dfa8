//! The suite that a user names.

use std::path::Path;

use openbench_neighbourhoods::Kind;

use super::neighbourhoods::{kind_and_seed, neighbourhood_suite};
use super::{builtin_suite, folder};
use crate::BenchError;
use crate::suite::builtin::builtin_suites;
use crate::suite::{Suite, WorldSource};

/// The suite that a word names: a built-in one, that of a drawn neighbourhood (`medium-7`), a suite
/// file (`.toml`), or the folder of a world.
///
/// # Errors
/// A file that is no suite, a folder without a world, or a name that is unknown.
pub fn suite_named(name: &str) -> Result<Suite, BenchError> {
    let path = Path::new(name);
    if folder::is_world(path) {
        return folder::suite_of(path);
    }
    // A folder that happens to be called as a built-in suite does not hide the suite.
    if path.is_dir() && !is_name(name) {
        return Err(BenchError::world(format!(
            "{name}: the folder has no world.toml; make a world with `openbench world generate`"
        )));
    }
    if path.extension().is_some_and(|e| e == "toml") {
        return Suite::read(path);
    }
    match kind_and_seed(name) {
        Some((kind, seed)) => neighbourhood_suite(kind, seed),
        None => builtin_suite(name),
    }
}

/// The world of a name that [`is_name`]: that of its suite. For others the error comes from
/// [`load`](super::load).
pub fn source_named(name: &str) -> WorldSource {
    match kind_and_seed(name) {
        Some((kind, seed)) => WorldSource::Drawn {
            kind: kind.name().to_owned(),
            seed,
        },
        None => WorldSource::Builtin {
            name: name.to_owned(),
            // That of the built-in suites.
            seed: 1,
        },
    }
}

/// Whether a word names a suite that is read from no file.
pub fn is_name(name: &str) -> bool {
    kind_and_seed(name).is_some() || builtin_suites().iter().any(|known| known == name)
}

/// Whether a word names a suite that has another world for each seed of a run.
pub fn is_drawn_by_seed(name: &str) -> bool {
    name.parse::<Kind>().is_ok() && !folder::is_world(Path::new(name))
}

/// The suite that a word names, for the seed of a run: a seed other than 0 turns a built-in suite
/// into that of another neighbourhood. Other suites are the same for all seeds.
///
/// # Errors
/// As [`suite_named`].
pub fn suite_of_seed(name: &str, seed: u64) -> Result<Suite, BenchError> {
    match name.parse::<Kind>() {
        Ok(kind) if seed > 0 && is_drawn_by_seed(name) => neighbourhood_suite(kind, seed),
        _ => suite_named(name),
    }
}
