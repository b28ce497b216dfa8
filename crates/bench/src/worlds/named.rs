//! The suite that a user names.

use std::path::Path;

use openbench_neighbourhoods::Kind;

use super::neighbourhoods::{kind_and_seed, name_and_seed, neighbourhood_suite};
use super::{builtin_suite, folder};
use crate::BenchError;
use crate::suite::builtin::builtin_suites;
use crate::suite::{Suite, Track, WorldSource, tracks};

/// The suite that a word names: a built-in one, a track, that of a drawn neighbourhood
/// (`medium-7`), a suite file (`.toml`), or the folder of a world.
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
    match (track_and_seed(name), kind_and_seed(name)) {
        (Some((track, seed)), _) => suite_of_track(track, seed),
        (None, Some((kind, seed))) => neighbourhood_suite(kind, seed),
        (None, None) => builtin_suite(name),
    }
}

/// The track and seed in a name such as `street-7`; a track alone has the seed 0.
fn track_and_seed(name: &str) -> Option<(&'static Track, u64)> {
    if let Some(track) = Track::named(name) {
        return Some((track, 0));
    }
    let (track, seed) = name_and_seed(name)?;
    Some((Track::named(track)?, seed))
}

/// The suite of a track for the seed of a run.
fn suite_of_track(track: &Track, seed: u64) -> Result<Suite, BenchError> {
    let suite = suite_of_seed(tracks::KIND, seed)?;
    Ok(Suite {
        name: match seed {
            0 => track.name.to_owned(),
            _ => format!("{}-{seed}", track.name),
        },
        conditions: track.conditions(seed).map_err(BenchError::world)?,
        traffic: track.traffic,
        ..suite
    })
}

/// The world of a name that [`is_name`]: that of its suite. For others the error comes from
/// [`load`](super::load).
pub fn source_named(name: &str) -> WorldSource {
    // A track has the world of its kind.
    let name = match track_and_seed(name) {
        Some((_, 0)) => tracks::KIND.to_owned(),
        Some((_, seed)) => format!("{}-{seed}", tracks::KIND),
        None => name.to_owned(),
    };
    match kind_and_seed(&name) {
        Some((kind, seed)) => WorldSource::Drawn {
            kind: kind.name().to_owned(),
            seed,
        },
        None => WorldSource::Builtin {
            name,
            // That of the built-in suites.
            seed: 1,
        },
    }
}

/// Whether a word names a suite that is read from no file.
pub fn is_name(name: &str) -> bool {
    let is_built_in = builtin_suites().iter().any(|known| known == name);
    is_built_in || kind_and_seed(name).is_some() || track_and_seed(name).is_some()
}

/// Whether a word names a suite that has another world for each seed of a run.
pub fn is_drawn_by_seed(name: &str) -> bool {
    let is_drawn = name.parse::<Kind>().is_ok() || Track::named(name).is_some();
    is_drawn && !folder::is_world(Path::new(name))
}

/// The suite that a word names, for the seed of a run: a seed other than 0 turns a built-in suite
/// into that of another neighbourhood. Other suites are the same for all seeds.
///
/// # Errors
/// As [`suite_named`].
pub fn suite_of_seed(name: &str, seed: u64) -> Result<Suite, BenchError> {
    if seed == 0 || !is_drawn_by_seed(name) {
        return suite_named(name);
    }
    match (Track::named(name), name.parse::<Kind>()) {
        (Some(track), _) => suite_of_track(track, seed),
        (None, Ok(kind)) => neighbourhood_suite(kind, seed),
        (None, Err(_)) => suite_named(name),
    }
}
