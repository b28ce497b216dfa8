//! The sources and parameters of a world: the file `world.toml` of its folder.

use std::path::{Path, PathBuf};

use openbench_core::{Georeference, Pose2, input};
use openbench_osm::OsmData;
use openbench_scene::World;
use openbench_scene::generate::{Alterations, GenerateOptions, generate};
use openbench_scene::{ImportRequest, import_world};
use serde::{Deserialize, Serialize};

use crate::BenchError;

/// Name of the recipe's file.
pub(super) const RECIPE: &str = "world.toml";
/// Name of the map's file in the same folder.
pub(super) const MAP: &str = "map.osm";

/// The sources and parameters of a world. Relative paths count from its folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Recipe {
    /// Generated from a map and a seed.
    Generated {
        /// Version of OpenBench that wrote the recipe; another version may build another world.
        version: String,
        /// Name of the world in results.
        name: String,
        /// The OSM file.
        map: PathBuf,
        /// Seed of everything that the map does not determine.
        seed: u64,
        /// Georeference of the `map` frame, for example `utm:32N,-373000,-4844000`.
        georeference: String,
        /// Start pose of the robot: x, y in metres, yaw in degrees; by default free ground near the
        /// centre.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start: Option<[f64; 3]>,
        /// Share of the parking spaces with a parked car, 0 to 1.
        parked_cars: f64,
        /// Amount of vegetation added to the map's own.
        planting: f64,
        /// Whether buildings without a mapped entrance get doors.
        invent_doors: bool,
        /// Authors and licences of the map.
        attribution: Vec<String>,
    },
    /// A Gazebo world with an OSM map.
    Imported {
        /// Version of OpenBench that wrote the recipe.
        version: String,
        /// Name of the world in results.
        name: String,
        /// The SDF file.
        world: PathBuf,
        /// The OSM file.
        map: PathBuf,
        /// Folders that are searched for `model://` URIs.
        models: Vec<PathBuf>,
        /// Georeference of the `map` frame.
        georeference: String,
        /// Start pose of the robot: x, y in metres, yaw in degrees; by default the world's origin,
        /// or a free position in front of a door.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start: Option<[f64; 3]>,
    },
}

impl Recipe {
    /// Reads the recipe of the world in `folder`.
    ///
    /// # Errors
    /// [`BenchError::File`] or [`BenchError::WrongFormat`].
    pub fn read(folder: &Path) -> Result<Self, BenchError> {
        let path = folder.join(RECIPE);
        let text = input::read_text(&path).map_err(|e| BenchError::file(&path, e))?;
        toml::from_str(&text).map_err(|e| BenchError::wrong_format(&path, "recipe of a world", e))
    }

    /// The recipe of a world generated from the map in the same folder, with default options.
    pub fn generated(name: &str, georeference: Georeference, seed: u64) -> Self {
        let defaults = GenerateOptions::default();
        Self::Generated {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            name: name.to_owned(),
            map: Self::map_file(),
            seed,
            georeference: georeference.to_string(),
            start: None,
            parked_cars: defaults.parked_cars,
            planting: defaults.planting,
            invent_doors: defaults.invent_doors,
            attribution: vec!["Map: © OpenStreetMap contributors, ODbL 1.0".to_owned()],
        }
    }

    /// Builds the world; `folder` is the folder of the recipe.
    ///
    /// # Errors
    /// A georeference or map that cannot be read, or a world that cannot be built.
    pub fn build(&self, folder: &Path) -> Result<World, BenchError> {
        self.build_with(folder, Alterations::default())
    }

    /// Whether the world was made elsewhere.
    pub(super) fn is_imported(&self) -> bool {
        matches!(self, Self::Imported { .. })
    }

    /// Builds the world altered; imported worlds stay as they are.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn build_with(&self, folder: &Path, by: Alterations) -> Result<World, BenchError> {
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
                // Always present: only imported worlds have none.
                let options = self.options().unwrap_or_default().altered(by);
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
                    // `join` leaves absolute paths as they are.
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
        // No error: the world can be used, but its results are not comparable.
        if self.version() != env!("CARGO_PKG_VERSION") {
            world.warnings.push(format!(
                "{} was written by version {}, this is version {}; the world may differ",
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
            ..GenerateOptions::default()
        })
    }

    fn version(&self) -> &str {
        match self {
            Self::Generated { version, .. } | Self::Imported { version, .. } => version,
        }
    }

    /// Name of the world in results.
    pub fn name(&self) -> &str {
        match self {
            Self::Generated { name, .. } | Self::Imported { name, .. } => name,
        }
    }

    /// The path of the map in the folder.
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
    fn a_recipe_is_equal_after_writing_and_reading() {
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
