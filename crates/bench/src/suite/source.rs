//! The source of a world, as data; nothing is loaded here.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// The source of a world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WorldSource {
    /// A built-in world, generated from its map and a seed.
    Builtin {
        /// Name of the world: `small`, `medium` or `large`.
        name: String,
        /// Seed of its facades, trees and cars.
        seed: u64,
    },
    /// A neighbourhood that is drawn by its seed.
    Drawn {
        /// The kind: `small`, `medium` or `large`.
        kind: String,
        /// Seed of the map, and of facades, trees and cars.
        seed: u64,
    },
    /// A Gazebo world with an OSM map.
    Imported {
        /// The SDF file.
        world: PathBuf,
        /// The OSM file.
        map: PathBuf,
        /// Folders that are searched for `model://` URIs.
        models: Vec<PathBuf>,
        /// Georeference, for example `utm:50N,-500000,-4483000`; by default from the map.
        georeference: Option<String>,
    },
    /// A world folder, see [`worlds::folder`](crate::worlds::folder).
    Folder {
        /// The folder.
        path: PathBuf,
    },
}

impl WorldSource {
    /// The files, and the folders with all their files, that the world is made of.
    pub fn paths(&self) -> Vec<&Path> {
        match self {
            Self::Builtin { .. } | Self::Drawn { .. } => Vec::new(),
            Self::Imported {
                world, map, models, ..
            } => [world, map]
                .into_iter()
                .chain(models)
                .map(PathBuf::as_path)
                .collect(),
            Self::Folder { path } => vec![path],
        }
    }
}
