//! Worlds as folders.
//!
//! | file | what |
//! |---|---|
//! | `world.toml` | the [`Recipe`]: what the world is made from |
//! | `map.osm` | the whole map, doors included: what the recipe builds on |
//! | `public.osm` | the map that agents get, doors left out |
//! | `suite.toml` | the deliveries, see [`Suite`] |
//!
//! The world itself is not stored: recipe and map give the same bytes within one version. A folder appears whole or not at all.

use std::error::Error;
use std::path::{Path, PathBuf};

use openbench_core::Address;
use openbench_osm::{Location, OsmData, locate, write_atomically};
use openbench_sim::traffic::TrafficPlan;

use super::prepared::Prepared;
use super::recipe::{MAP, RECIPE, Recipe};
use crate::BenchError;
use crate::suite::draw::Draw;
use crate::suite::{Sensors, Suite, WorldSource};

const PUBLIC: &str = "public.osm";
const SUITE: &str = "suite.toml";

/// How many deliveries are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Single deliveries.
    pub singles: usize,
    /// Sequences, and doors in each.
    pub sequences: (usize, usize),
    /// Doors further than this from the start in a straight line are not drawn, metres.
    pub reach: f64,
    /// What they are drawn from.
    pub seed: u64,
}

/// A world that was written, and what there is to say about it.
pub struct Written {
    /// The world, ready to run, with the suite that was drawn.
    pub prepared: Prepared,
    /// Doors that a robot can get to.
    pub reachable: usize,
    /// Doors that deliveries could be drawn from: reachable, near enough, and of an address that the map has once.
    pub candidates: usize,
}

/// Whether `path` is the folder of a world.
pub fn is_world(path: &Path) -> bool {
    path.join(RECIPE).is_file()
}

/// The suite of the world in `folder`.
pub fn suite_of(folder: &Path) -> Result<Suite, BenchError> {
    Suite::read(&folder.join(SUITE))
}

/// Writes a world's folder: `map` is the whole map, which the recipe names as [`Recipe::map_file`]. An earlier world there is
/// replaced; anything else is not.
pub fn write(
    folder: &Path,
    recipe: &Recipe,
    map: &OsmData,
    wanted: Wanted,
) -> Result<Written, BenchError> {
    refuse_others(folder)?;
    let staging = StagingFolder::new(folder)?;
    staging.put(MAP, &map.to_xml())?;
    let text = toml::to_string_pretty(recipe).map_err(|e| staging.bad(RECIPE, e))?;
    staging.put(RECIPE, text.as_bytes())?;
    let source = WorldSource::Folder {
        path: staging.path.clone(),
    };
    let suite = Suite {
        name: recipe.name().to_owned(),
        world: source,
        traffic: TrafficPlan::default(),
        episodes: Vec::new(),
        sensors: Sensors::default(),
    };
    let mut prepared = Prepared::world_of(suite)?;
    staging.put(PUBLIC, &prepared.world.map.to_xml())?;
    let (reachable, candidates) = draw(&mut prepared, wanted);
    if prepared.suite.episodes.is_empty() {
        return Err(BenchError::world(format!(
            "no door can be delivered to: of {} doors a robot gets to {reachable}, and none of these has an address of its own \
             within {} m of the start; take a larger part of the map, another --start or a longer --reach",
            prepared.world.scene.doors.len(),
            wanted.reach
        )));
    }
    prepared.suite.world = WorldSource::Folder { path: ".".into() };
    staging.put(SUITE, prepared.suite.to_toml().as_bytes())?;
    staging.move_to(folder)?;
    prepared.suite = suite_of(folder)?;
    Ok(Written {
        prepared,
        reachable,
        candidates,
    })
}

/// Draws the suite's episodes; counts the doors that can be reached, and those that were drawn from.
fn draw(prepared: &mut Prepared, wanted: Wanted) -> (usize, usize) {
    let (map, start) = (prepared.osm_map(), prepared.world.start.point());
    let doors = prepared.world.scene.doors.iter().zip(&prepared.approach);
    let reachable: Vec<_> = doors
        .filter(|(_, approach)| approach.is_some())
        .map(|(door, _)| door)
        .collect();
    let is_known = |a: &Address| {
        matches!(
            locate(&map, a),
            Location::Building(_) | Location::Unit { .. }
        )
    };
    let candidates: Vec<Address> = reachable
        .iter()
        .filter(|d| d.point().distance(start) <= wanted.reach && is_known(&d.address))
        .map(|d| d.address.clone())
        .collect();
    let counts = (reachable.len(), candidates.len());
    let mut draw = Draw::new(candidates, wanted.seed);
    // No door twice, and no sequence of one.
    let mut episodes = draw.singles(wanted.singles.min(counts.1));
    if counts.1 > 1 || wanted.sequences.1 == 1 {
        episodes.extend(draw.sequences(wanted.sequences.0, wanted.sequences.1));
    }
    prepared.suite.episodes = episodes;
    counts
}

fn refuse_others(folder: &Path) -> Result<(), BenchError> {
    let bad = |problem: &str| Err(BenchError::bad_file(folder, problem));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() {
            bad("this is a file; name a folder")
        } else {
            Ok(())
        };
    };
    let ours = [RECIPE, MAP, PUBLIC, SUITE];
    let foreign = entries
        .filter_map(Result::ok)
        .any(|e| !ours.iter().any(|name| e.file_name() == *name));
    if foreign {
        bad("the folder holds other things than a world; name another one")
    } else {
        Ok(())
    }
}

/// A temporary folder beside the final one. It is removed unless it was moved there.
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
        let old = self.path.with_extension("old");
        let failed = |e| BenchError::file(folder, e);
        if folder.exists() {
            std::fs::rename(folder, &old).map_err(failed)?;
        }
        std::fs::rename(&self.path, folder).map_err(failed)?;
        if old.exists() {
            std::fs::remove_dir_all(&old).map_err(failed)
        } else {
            Ok(())
        }
    }
}

impl Drop for StagingFolder {
    fn drop(&mut self) {
        // Moved away already if all went well.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_world_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(refuse_others(&folder.path().join("new")).is_ok());
        std::fs::write(folder.path().join("thesis.tex"), "").unwrap();
        assert!(
            refuse_others(folder.path())
                .unwrap_err()
                .to_string()
                .contains("other things")
        );
        assert!(
            refuse_others(&folder.path().join("thesis.tex"))
                .unwrap_err()
                .to_string()
                .contains("a file")
        );
    }
}
