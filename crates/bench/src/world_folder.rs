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

use std::path::{Path, PathBuf};

use openbench_core::{Address, Georeference, Pose2};
use openbench_osm::{Location, OsmData, locate, write_atomically};
use openbench_scene::World;
use openbench_scene::generate::{GenerateOptions, generate};
use openbench_scene::import::{ImportRequest, import_world};
use openbench_sim::traffic::TrafficPlan;
use serde::{Deserialize, Serialize};

use crate::BenchError;
use crate::draw::Draw;
use crate::stage::Prepared;
use crate::suite::{Sensors, Suite, WorldSource};

const RECIPE: &str = "world.toml";
const MAP: &str = "map.osm";
const PUBLIC: &str = "public.osm";
const SUITE: &str = "suite.toml";

/// What a world is made from; paths count from its folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Recipe {
    /// Generated from a map and a seed.
    Generated {
        /// Version of OpenBench that wrote it; another one may build something else.
        version: String,
        /// Name of the world, as in results.
        name: String,
        /// The map.
        map: PathBuf,
        /// What the map leaves open is drawn from it.
        seed: u64,
        /// How the `map` frame lies on the Earth, in words.
        georeference: String,
        /// Where the robot starts: x, y in metres, yaw in degrees; by default a clear place near the middle.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start: Option<[f64; 3]>,
        /// Share of the parking places with a car in them.
        parked_cars: f64,
        /// How much greenery is added to the map's own.
        planting: f64,
        /// Whether buildings without a mapped entrance get doors.
        invent_doors: bool,
        /// Authors and licences of the map.
        attribution: Vec<String>,
    },
    /// A Gazebo world with an OSM map.
    Imported {
        /// Version of OpenBench that wrote it.
        version: String,
        /// Name of the world, as in results.
        name: String,
        /// The SDF file.
        world: PathBuf,
        /// The map.
        map: PathBuf,
        /// Folders in which `model://` is looked up.
        models: Vec<PathBuf>,
        /// How the world lies on the Earth, in words.
        georeference: String,
        /// Where the robot starts: x, y in metres, yaw in degrees; by default the world's origin, or before a door.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start: Option<[f64; 3]>,
    },
}

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

impl Recipe {
    /// The recipe of the world in `folder`.
    pub fn read(folder: &Path) -> Result<Self, BenchError> {
        let path = folder.join(RECIPE);
        let text = std::fs::read_to_string(&path).map_err(|e| BenchError::file(&path, e))?;
        toml::from_str(&text)
            .map_err(|e| BenchError::BadFile { path, problem: format!("this is no recipe of a world: {e}") })
    }

    /// The recipe of a world generated from the map beside it, with what is usual.
    pub fn generated(name: &str, georeference: Georeference, seed: u64) -> Self {
        let usual = GenerateOptions::default();
        Self::Generated {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            name: name.to_owned(),
            map: Self::map_file(),
            seed,
            georeference: georeference.to_string(),
            start: None,
            parked_cars: usual.parked_cars,
            planting: usual.planting,
            invent_doors: usual.invent_doors,
            attribution: vec!["Map: © OpenStreetMap contributors, ODbL 1.0".to_owned()],
        }
    }

    /// Builds the world; `folder` is where the recipe lies.
    pub fn build(&self, folder: &Path) -> Result<World, BenchError> {
        let bad = |problem: String| BenchError::BadFile { path: folder.join(RECIPE), problem };
        let place = |words: &str| words.parse::<Georeference>().map_err(|e| bad(e.to_string()));
        let mut world = match self {
            Self::Generated { map, seed, georeference, .. } => {
                let data = read_map(&folder.join(map))?;
                let options = self.options().unwrap_or_default();
                generate(&data, place(georeference)?, *seed, &options)
                    .map_err(|e| BenchError::World(e.to_string()))?
            }
            Self::Imported { name, world, map, models, georeference, start, .. } => {
                let request = ImportRequest {
                    world: folder.join(world),
                    map: folder.join(map),
                    models: models.iter().map(|m| folder.join(m)).collect(),
                    georeference: Some(place(georeference)?),
                    start: start.map(pose),
                };
                let mut world = import_world(&request).map_err(|e| BenchError::World(e.to_string()))?;
                world.name.clone_from(name);
                world
            }
        };
        if self.version() != env!("CARGO_PKG_VERSION") {
            world.warnings.push(format!(
                "{} was written by version {}, this is {}; the world may have changed",
                folder.display(),
                self.version(),
                env!("CARGO_PKG_VERSION")
            ));
        }
        Ok(world)
    }

    fn options(&self) -> Option<GenerateOptions> {
        let Self::Generated { name, start, parked_cars, planting, invent_doors, attribution, .. } = self
        else {
            return None;
        };
        Some(GenerateOptions {
            name: name.clone(),
            start: start.map(pose),
            parked_cars: *parked_cars,
            planting: *planting,
            invent_doors: *invent_doors,
            attribution: attribution.clone(),
        })
    }

    fn version(&self) -> &str {
        match self {
            Self::Generated { version, .. } | Self::Imported { version, .. } => version,
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Generated { name, .. } | Self::Imported { name, .. } => name,
        }
    }

    /// The map's file in the folder.
    pub fn map_file() -> PathBuf {
        MAP.into()
    }
}

/// A pose from x, y in metres and yaw in degrees.
fn pose([x, y, yaw]: [f64; 3]) -> Pose2 {
    Pose2::new(x, y, yaw.to_radians())
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
pub fn write(folder: &Path, recipe: &Recipe, map: &OsmData, wanted: Wanted) -> Result<Written, BenchError> {
    refuse_others(folder)?;
    let beside = Beside::new(folder)?;
    beside.put(MAP, &map.to_xml())?;
    let text = toml::to_string_pretty(recipe).map_err(|e| beside.bad(RECIPE, e.to_string()))?;
    beside.put(RECIPE, text.as_bytes())?;
    let source = WorldSource::Folder { path: beside.path.clone() };
    let suite = Suite {
        name: recipe.name().to_owned(),
        world: source,
        traffic: TrafficPlan::default(),
        episodes: Vec::new(),
        sensors: Sensors::default(),
    };
    let mut prepared = Prepared::world_of(suite)?;
    beside.put(PUBLIC, &prepared.world.map.to_xml())?;
    let (reachable, candidates) = draw(&mut prepared, wanted);
    if prepared.suite.episodes.is_empty() {
        return Err(BenchError::World(format!(
            "no door can be delivered to: of {} doors a robot gets to {reachable}, and none of these has an address of its own \
             within {} m of the start; take a larger part of the map, another --start or a longer --reach",
            prepared.world.scene.doors.len(),
            wanted.reach
        )));
    }
    prepared.suite.world = WorldSource::Folder { path: ".".into() };
    beside.put(SUITE, prepared.suite.to_toml().as_bytes())?;
    beside.move_to(folder)?;
    prepared.suite = suite_of(folder)?;
    Ok(Written { prepared, reachable, candidates })
}

/// Draws the suite's episodes; counts the doors that can be reached, and those that were drawn from.
fn draw(prepared: &mut Prepared, wanted: Wanted) -> (usize, usize) {
    let (map, start) = (prepared.osm_map(), prepared.world.start.point());
    let doors = prepared.world.scene.doors.iter().zip(&prepared.approach);
    let reachable: Vec<_> = doors.filter(|(_, approach)| approach.is_some()).map(|(door, _)| door).collect();
    let is_known = |a: &Address| matches!(locate(&map, a), Location::Building(_) | Location::Unit { .. });
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

fn read_map(path: &Path) -> Result<OsmData, BenchError> {
    OsmData::read(path).map_err(|e| BenchError::World(e.to_string()))
}

fn refuse_others(folder: &Path) -> Result<(), BenchError> {
    let bad = |problem: &str| Err(BenchError::BadFile { path: folder.to_owned(), problem: problem.into() });
    let Ok(entries) = std::fs::read_dir(folder) else {
        return if folder.exists() { bad("this is a file; name a folder") } else { Ok(()) };
    };
    let ours = [RECIPE, MAP, PUBLIC, SUITE];
    let foreign = entries.filter_map(Result::ok).any(|e| !ours.iter().any(|name| e.file_name() == *name));
    if foreign { bad("the folder holds other things than a world; name another one") } else { Ok(()) }
}

/// A folder beside the one that is wanted; gone again unless it was moved there.
struct Beside {
    path: PathBuf,
}

impl Beside {
    fn new(folder: &Path) -> Result<Self, BenchError> {
        let absolute = std::path::absolute(folder).map_err(|e| BenchError::file(folder, e))?;
        let name = absolute.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let path = absolute.with_file_name(format!(".{name}.{}.part", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| BenchError::file(&path, e))?;
        Ok(Self { path })
    }

    fn put(&self, name: &str, bytes: &[u8]) -> Result<(), BenchError> {
        write_atomically(&self.path.join(name), bytes).map_err(|e| self.bad(name, e.to_string()))
    }

    fn bad(&self, name: &str, problem: String) -> BenchError {
        BenchError::BadFile { path: self.path.join(name), problem }
    }

    fn move_to(&self, folder: &Path) -> Result<(), BenchError> {
        let old = self.path.with_extension("old");
        let failed = |e| BenchError::file(folder, e);
        if folder.exists() {
            std::fs::rename(folder, &old).map_err(failed)?;
        }
        std::fs::rename(&self.path, folder).map_err(failed)?;
        if old.exists() { std::fs::remove_dir_all(&old).map_err(failed) } else { Ok(()) }
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // Moved away already if all went well.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipes_survive_their_file() {
        let recipe = Recipe::Generated {
            version: "0.1.0".into(),
            name: "hill".into(),
            map: Recipe::map_file(),
            seed: 7,
            georeference: "utm:32N,-373000,-4844000".into(),
            start: Some([1.0, 2.5, 90.0]),
            parked_cars: 1.0,
            planting: 0.0,
            invent_doors: true,
            attribution: vec!["somebody".into()],
        };
        let text = toml::to_string_pretty(&recipe).unwrap();
        assert!(text.starts_with("kind = \"generated\""), "{text}");
        assert_eq!(toml::from_str::<Recipe>(&text).unwrap(), recipe);
        assert!(toml::from_str::<Recipe>(&text.replace("planting", "plantings")).is_err());
    }

    #[test]
    fn what_is_no_world_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(refuse_others(&folder.path().join("new")).is_ok());
        std::fs::write(folder.path().join("thesis.tex"), "").unwrap();
        assert!(refuse_others(folder.path()).unwrap_err().to_string().contains("other things"));
        assert!(refuse_others(&folder.path().join("thesis.tex")).unwrap_err().to_string().contains("a file"));
    }
}
