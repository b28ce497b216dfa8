//! From a suite's [`WorldSource`] to the world.

use std::path::PathBuf;

use openbench_core::Georeference;
use openbench_neighbourhoods::{Kind, draw};
use openbench_scene::World;
use openbench_scene::generate::{self, Alterations};
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
    load_with(source, Alterations::default())
}

/// Builds a world that is altered.
///
/// # Errors
/// As [`load`], and [`BenchError::World`] for doors or plates in an imported world: where they are
/// is part of it.
pub fn load_with(source: &WorldSource, by: Alterations) -> Result<World, BenchError> {
    let is_imported = match source {
        WorldSource::Imported { .. } => true,
        WorldSource::Folder { path } => Recipe::read(path)?.is_imported(),
        WorldSource::Builtin { .. } | WorldSource::Drawn { .. } => false,
    };
    if is_imported {
        refuse_alterations(by)?;
    }
    match source {
        WorldSource::Builtin { name, seed } => builtin(name, *seed, by),
        WorldSource::Drawn { kind, seed } => drawn(kind, *seed, by),
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
        WorldSource::Folder { path } => Recipe::read(path)?.build_with(path, by),
    }
}

/// Refuses what an imported world brings itself.
fn refuse_alterations(by: Alterations) -> Result<(), BenchError> {
    let own = [
        ("plates", by.plates.shares.real),
        ("doors", by.drawn_doors.is_some()),
        ("scenery", !by.scenery.amounts.is_plain()),
    ];
    match own.into_iter().find(|(_, is_altered)| *is_altered) {
        None => Ok(()),
        Some((what, _)) => Err(BenchError::world(format!(
            "{what}: an imported world keeps its own {what}; leave the condition `{what}` out, or \
             generate a world from the map (openbench world generate)"
        ))),
    }
}

fn builtin(name: &str, seed: u64, by: Alterations) -> Result<World, BenchError> {
    let unknown = || BenchError::UnknownSuite {
        name: name.to_owned(),
        known: builtin_suites(),
    };
    if let Some(place) = Place::named(name) {
        return place.world(seed, by);
    }
    let world = generate::builtin_with(name, seed, by).ok_or_else(unknown)?;
    world.map_err(BenchError::world)
}

fn drawn(kind: &str, seed: u64, by: Alterations) -> Result<World, BenchError> {
    let kind: Kind = kind.parse().map_err(BenchError::world)?;
    let here = draw(kind, seed);
    let options = generate::GenerateOptions {
        name: here.name(),
        start: Some(here.start),
        // The map has all doors.
        invent_doors: false,
        attribution: vec![here.attribution()],
        ..generate::GenerateOptions::default()
    }
    .altered(by);
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
    use super::*;
    use crate::suite::Conditions;

    #[test]
    fn an_imported_world_keeps_its_doors_plates_and_streets() {
        let source = WorldSource::Imported {
            world: "any.world".into(),
            map: "any.osm".into(),
            models: Vec::new(),
            georeference: None,
        };
        for (key, level) in [
            ("plates", "real"),
            ("doors", "drawn"),
            ("scenery", "varied"),
        ] {
            let mut conditions = Conditions::default();
            conditions.set(key, level).unwrap();
            let refused = load_with(&source, conditions.alterations(1));
            let error = refused.unwrap_err().to_string();
            let expected = format!("leave the condition `{key}` out");
            assert!(error.contains(&expected), "{error}");
        }
    }
}
