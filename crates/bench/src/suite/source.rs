//! Where a world comes from, as data: nothing is loaded here.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Where a world comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WorldSource {
    /// One of our own, generated from its map and a seed.
    Builtin {
        /// Its name.
        name: String,
        /// What its facades, trees and cars are drawn from.
        seed: u64,
    },
    /// A Gazebo world with an OSM map.
    Imported {
        /// The SDF file.
        world: PathBuf,
        /// The OSM file.
        map: PathBuf,
        /// Folders in which `model://` is looked up.
        models: Vec<PathBuf>,
        /// How the world lies on the Earth, in words; by default from the map.
        georeference: Option<String>,
    },
    /// A folder with a recipe, see [`worlds::folder`](crate::worlds::folder).
    Folder {
        /// The folder.
        path: PathBuf,
    },
}
