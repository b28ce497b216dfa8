//! From a suite's [`WorldSource`] to the world.

use std::path::PathBuf;

use openbench_core::Georeference;
use openbench_neighbourhoods::{Kind, draw};
use openbench_scene::World;
use openbench_scene::generate::{self, WorldConditions};
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
    load_with(source, WorldConditions::default())
}

/// Builds a world under conditions.
///
/// # Errors
/// As [`load`], and [`BenchError::World`] for conditions that change an imported world: where its
/// plates hang, and what stands in its streets, is part of it.
pub fn load_with(source: &WorldSource, conditions: WorldConditions) -> Result<World, BenchError> {
    let is_imported = match source {
        WorldSource::Imported { .. } => true,
        WorldSource::Folder { path } => Recipe::read(path)?.is_imported(),
        WorldSource::Builtin { .. } | WorldSource::Drawn { .. } => false,
    };
    if is_imported && !conditions.scenery.amounts.is_plain() {
        return Err(BenchError::world(
            "scenery: an imported world keeps its own streets; leave the condition `scenery` out, \
             or generate a world from the map (openbench world generate)",
        ));
    }
    if is_imported && conditions.plates.shares.real {
        return Err(BenchError::world(
            "plates: an imported world keeps its own plates; leave the condition `plates` out, or \
             generate a world from the map (openbench world generate)",
        ));
    }
    match source {
        WorldSource::Builtin { name, seed } => builtin(name, *seed, conditions),
        WorldSource::Drawn { kind, seed } => drawn(kind, *seed, conditions),
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
        WorldSource::Folder { path } => Recipe::read(path)?.build_with(path, conditions),
    }
}

fn builtin(name: &str, seed: u64, conditions: WorldConditions) -> Result<World, BenchError> {
    let unknown = || BenchError::UnknownSuite {
        name: name.to_owned(),
        known: builtin_suites(),
    };
    if let Some(place) = Place::named(name) {
        return place.world(seed, conditions);
    }
    let world = generate::builtin_with(name, seed, conditions).ok_or_else(unknown)?;
    world.map_err(BenchError::world)
}

fn drawn(kind: &str, seed: u64, conditions: WorldConditions) -> Result<World, BenchError> {
    let kind: Kind = kind.parse().map_err(BenchError::world)?;
    let here = draw(kind, seed);
    let options = generate::GenerateOptions {
        name: here.name(),
        start: Some(here.start),
        // The map has all doors.
        invent_doors: false,
        attribution: vec![here.attribution()],
        ..generate::GenerateOptions::default().with(conditions)
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

#[cfg(test)]
mod tests {
    use openbench_scene::generate::{PlateOptions, SceneryOptions};
    use openbench_scene::plates::StreetPlates;
    use openbench_scene::scenery::Scenery;

    use super::*;

    #[test]
    fn an_imported_world_keeps_its_plates_and_streets() {
        let source = WorldSource::Imported {
            world: "any.world".into(),
            map: "any.osm".into(),
            models: Vec::new(),
            georeference: None,
        };
        let plates = WorldConditions {
            plates: PlateOptions {
                shares: StreetPlates::REAL,
                seed: 1,
            },
            ..WorldConditions::default()
        };
        let scenery = WorldConditions {
            scenery: SceneryOptions {
                amounts: Scenery::VARIED,
                seed: 1,
            },
            ..WorldConditions::default()
        };
        for (conditions, name) in [(plates, "plates"), (scenery, "scenery")] {
            let error = load_with(&source, conditions).unwrap_err().to_string();
            let expected = format!("leave the condition `{name}` out");
            assert!(error.contains(&expected), "{error}");
        }
    }
}
