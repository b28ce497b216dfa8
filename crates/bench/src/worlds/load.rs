//! From a suite's [`WorldSource`] to the world.

use std::path::PathBuf;

use openbench_core::Georeference;
use openbench_neighbourhoods::{Kind, draw};
use openbench_scene::World;
use openbench_scene::generate;
use openbench_scene::{ImportRequest, import_world};

use super::places::Place;
use super::recipe::Recipe;
use crate::BenchError;
use crate::suite::WorldSource;
use crate::suite::builtin::builtin_suites;

/// Builds a world.
///
/// # Errors
/// An unknown name, a file that cannot be used, or a world that cannot be built.
pub fn load(source: &WorldSource) -> Result<World, BenchError> {
    match source {
        WorldSource::Builtin { name, seed } => builtin(name, *seed),
        WorldSource::Drawn { kind, seed } => drawn(kind, *seed),
        WorldSource::Imported {
            world,
            map,
            models,
            georeference,
        } => imported(
            world.clone(),
            map.clone(),
            models.clone(),
            georeference.as_deref(),
        ),
        WorldSource::Folder { path } => Recipe::read(path)?.build(path),
    }
}

fn builtin(name: &str, seed: u64) -> Result<World, BenchError> {
    let unknown = || BenchError::UnknownSuite {
        name: name.to_owned(),
        known: builtin_suites(),
    };
    if let Some(place) = Place::named(name) {
        return place.world(seed);
    }
    let world = generate::builtin(name, seed).ok_or_else(unknown)?;
    world.map_err(BenchError::world)
}

fn drawn(kind: &str, seed: u64) -> Result<World, BenchError> {
    let kind: Kind = kind.parse().map_err(BenchError::world)?;
    let here = draw(kind, seed);
    let options = generate::GenerateOptions {
        name: here.name(),
        start: Some(here.start),
        // The map has all doors.
        invent_doors: false,
        attribution: vec![here.attribution()],
        ..generate::GenerateOptions::default()
    };
    let world = generate::generate(&here.map, here.georeference, seed, &options);
    world.map_err(BenchError::world)
}

fn imported(
    world: PathBuf,
    map: PathBuf,
    models: Vec<PathBuf>,
    georeference: Option<&str>,
) -> Result<World, BenchError> {
    let georeference = georeference
        .map(str::parse::<Georeference>)
        .transpose()
        .map_err(BenchError::world)?;
    let request = ImportRequest {
        world,
        map,
        models,
        georeference,
        start: None,
    };
    import_world(&request).map_err(BenchError::world)
}
