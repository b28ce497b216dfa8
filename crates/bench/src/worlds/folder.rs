//! Worlds as folders.
//!
//! | file | content |
//! |---|---|
//! | `world.toml` | the [`Recipe`]: sources and parameters of the world |
//! | `map.osm` | the complete map with doors, from which the recipe builds the world |
//! | `public.osm` | the map for agents, without doors |
//! | `suite.toml` | the deliveries, see [`Suite`] |
//!
//! The world itself is not stored: within one version, recipe and map give the same world, byte by
//! byte. A folder is written to a staging directory and renamed, so it is complete or absent.

use std::error::Error;
use std::path::{Path, PathBuf};

use openbench_osm::{OsmData, write_atomically};
use openbench_sim::traffic::TrafficPlan;

use super::prepared::Prepared;
use super::recipe::{MAP, RECIPE, Recipe};
use crate::BenchError;
use crate::suite::draw::Draw;
use crate::suite::{Conditions, GoalKind, Sensors, Suite, TargetSource, WorldSource};

const PUBLIC: &str = "public.osm";
const SUITE: &str = "suite.toml";

/// The number and range of the deliveries to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawRequest {
    /// Number of single deliveries.
    pub singles: usize,
    /// Number of sequences.
    pub sequences: usize,
    /// Number of doors in each sequence.
    pub sequence_length: usize,
    /// Maximum straight-line distance of a door from the start, metres.
    pub max_distance_m: f64,
    /// Seed of the draw.
    pub seed: u64,
}

/// A world folder that was written.
pub struct WrittenWorld {
    /// The world, ready to run, with the drawn suite.
    pub prepared: Prepared,
    /// Number of doors that a robot can reach.
    pub reachable: usize,
    /// Number of doors from which deliveries are drawn: reachable, within the distance, and with an
    /// address that is unique on the map.
    pub candidates: usize,
}

/// Whether `path` is a world folder.
pub fn is_world(path: &Path) -> bool {
    path.join(RECIPE).is_file()
}

/// The suite of the world in `folder`.
///
/// # Errors
/// As [`Suite::read`].
pub fn suite_of(folder: &Path) -> Result<Suite, BenchError> {
    Suite::read(&folder.join(SUITE))
}

/// Writes a world folder. `map` is the complete map, which the recipe names as
/// [`Recipe::map_file`].
///
/// An existing world folder is replaced; a folder with other files is not.
///
/// # Errors
/// A folder with other files, a world that cannot be built or has no door for a delivery, or a file
/// that cannot be written.
pub fn write(
    folder: &Path,
    recipe: &Recipe,
    map: &OsmData,
    request: DrawRequest,
) -> Result<WrittenWorld, BenchError> {
    refuse_others(folder)?;
    let staging = StagingFolder::new(folder)?;
    staging.put(MAP, &map.to_xml())?;
    let text = toml::to_string_pretty(recipe).map_err(|e| staging.bad(RECIPE, e))?;
    staging.put(RECIPE, text.as_bytes())?;
    let source = WorldSource::Folder {
        path: staging.path.clone(),
    };
    let suite = Suite {
        goal: GoalKind::default(),
        name: recipe.name().to_owned(),
        world: source,
        targets: TargetSource::World,
        traffic: TrafficPlan::default(),
        episodes: Vec::new(),
        sensors: Sensors::default(),
        conditions: Conditions::default(),
        seed: 0,
    };
    // Built from the files that were just written, so that what is checked is what a later run
    // reads.
    let mut prepared = Prepared::world_of(suite)?;
    staging.put(PUBLIC, &prepared.world.map.to_xml())?;
    let DoorCounts {
        reachable,
        candidates,
    } = draw(&mut prepared, request);
    if prepared.suite.episodes.is_empty() {
        return Err(BenchError::world(format!(
            "no door can be delivered to: a robot can reach {reachable} of {} doors, and none of \
             these has a unique address within {} m of the start; use a larger part of the map, \
             another --start or a longer --reach",
            prepared.world.scene.doors.len(),
            request.max_distance_m
        )));
    }
    // Relative to the file, so that the folder can be moved.
    prepared.suite.world = WorldSource::Folder { path: ".".into() };
    staging.put(SUITE, prepared.suite.to_toml().as_bytes())?;
    staging.move_to(folder)?;
    // The paths of the staging folder no longer exist.
    prepared.suite = suite_of(folder)?;
    Ok(WrittenWorld {
        prepared,
        reachable,
        candidates,
    })
}

/// Numbers of doors, see [`WrittenWorld`].
struct DoorCounts {
    reachable: usize,
    candidates: usize,
}

/// Draws the suite's episodes.
fn draw(prepared: &mut Prepared, request: DrawRequest) -> DoorCounts {
    let candidates = prepared.deliverable(request.max_distance_m);
    let counts = DoorCounts {
        reachable: prepared.approach.iter().flatten().count(),
        candidates: candidates.len(),
    };
    let mut draw = Draw::new(candidates, request.seed);
    // No door is drawn twice, and no sequence has only one door unless requested.
    let mut episodes = draw.singles(request.singles.min(counts.candidates));
    if counts.candidates > 1 || request.sequence_length == 1 {
        episodes.extend(draw.sequences(request.sequences, request.sequence_length));
    }
    prepared.suite.episodes = episodes;
    counts
}

fn refuse_others(folder: &Path) -> Result<(), BenchError> {
    let bad = |problem: &str| Err(BenchError::bad_file(folder, problem));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() {
            bad("this is a file; use a folder")
        } else {
            Ok(())
        };
    };
    let ours = [RECIPE, MAP, PUBLIC, SUITE];
    let names: Vec<_> = entries.flatten().map(|e| e.file_name()).collect();
    let has_recipe = names.iter().any(|name| name == RECIPE);
    let are_ours = names.iter().all(|name| ours.iter().any(|our| name == our));
    // Without a recipe, files with our names are somebody's own.
    let may_go = names.is_empty() || (has_recipe && are_ours);
    if !may_go {
        bad("the folder contains files that do not belong to a world; use another folder")
    } else {
        Ok(())
    }
}

/// A temporary folder next to the final one. It is removed when dropped, unless it was moved.
struct StagingFolder {
    path: PathBuf,
}

impl StagingFolder {
    fn new(folder: &Path) -> Result<Self, BenchError> {
        let absolute = std::path::absolute(folder).map_err(|e| BenchError::file(folder, e))?;
        let name = absolute
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        // Beside the final folder, since a rename does not cross file systems. With the number of
        // the process, since another one may write the same world.
        let path = absolute.with_file_name(format!(".{name}.{}.part", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| BenchError::file(&path, e))?;
        Ok(Self { path })
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), BenchError> {
        write_atomically(&self.path.join(name), bytes).map_err(|e| self.bad(name, e))
    }

    fn bad(&self, name: &str, problem: impl Into<Box<dyn Error + Send + Sync>>) -> BenchError {
        BenchError::bad_file(&self.path.join(name), problem)
    }

    fn move_to(&self, folder: &Path) -> Result<(), BenchError> {
        // A rename does not replace a folder that contains files.
        let old = self.path.with_extension("old");
        let failed = |e| BenchError::file(folder, e);
        if folder.exists() {
            std::fs::rename(folder, &old).map_err(failed)?;
        }
        std::fs::rename(&self.path, folder).map_err(failed)?;
        // Only now: if the renaming above fails, the old world still exists.
        if old.exists() {
            std::fs::remove_dir_all(&old).map_err(failed)
        } else {
            Ok(())
        }
    }
}

impl Drop for StagingFolder {
    fn drop(&mut self) {
        // It no longer exists if it was moved.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::with_causes;

    #[test]
    fn only_a_world_folder_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(refuse_others(&folder.path().join("new")).is_ok());
        std::fs::write(folder.path().join("thesis.tex"), "").unwrap();
        let problem = |path: &Path| with_causes(&refuse_others(path).unwrap_err());
        assert!(problem(folder.path()).contains("do not belong to a world"));
        assert!(problem(&folder.path().join("thesis.tex")).contains("this is a file"));
    }
}
