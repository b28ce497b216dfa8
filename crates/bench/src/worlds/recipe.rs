//! What a world is made from, as the file `world.toml` of its folder.

use std::path::{Path, PathBuf};

use openbench_core::{Georeference, Pose2};
use openbench_osm::OsmData;
use openbench_scene::World;
use openbench_scene::generate::{GenerateOptions, generate};
use openbench_scene::import::{ImportRequest, import_world};
use serde::{Deserialize, Serialize};

use crate::BenchError;

/// Name of a recipe's file.
pub(super) const RECIPE: &str = "world.toml";
/// Name of the map's file beside it.
pub(super) const MAP: &str = "map.osm";

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

impl Recipe {
    /// The recipe of the world in `folder`.
    pub fn read(folder: &Path) -> Result<Self, BenchError> {
        let path = folder.join(RECIPE);
        let text = std::fs::read_to_string(&path).map_err(|e| BenchError::file(&path, e))?;
        toml::from_str(&text).map_err(|e| BenchError::wrong_format(&path, "recipe of a world", e))
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
        let recipe = folder.join(RECIPE);
        let place = |words: &str| {
            words
                .parse::<Georeference>()
                .map_err(|e| BenchError::bad_file(&recipe, e))
        };
        let mut world = match self {
            Self::Generated {
                map,
                seed,
                georeference,
                ..
            } => {
                let data = read_map(&folder.join(map))?;
                let options = self.options().unwrap_or_default();
                generate(&data, place(georeference)?, *seed, &options).map_err(BenchError::world)?
            }
            Self::Imported {
                name,
                world,
                map,
                models,
                georeference,
                start,
                ..
            } => {
                let request = ImportRequest {
                    world: folder.join(world),
                    map: folder.join(map),
                    models: models.iter().map(|m| folder.join(m)).collect(),
                    georeference: Some(place(georeference)?),
                    start: start.map(pose),
                };
                let mut world = import_world(&request).map_err(BenchError::world)?;
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
        let Self::Generated {
            name,
            start,
            parked_cars,
            planting,
            invent_doors,
            attribution,
            ..
        } = self
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

    /// Name of the world, as in results.
    pub fn name(&self) -> &str {
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

fn read_map(path: &Path) -> Result<OsmData, BenchError> {
    OsmData::read(path).map_err(BenchError::world)
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
}
