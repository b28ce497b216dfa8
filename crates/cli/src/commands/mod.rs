//! One file a command.

pub mod bench;
mod bench_health;
mod bench_localization;
mod bench_motion;
mod bench_people;
mod bench_towns;
pub mod compare;
pub mod costmap;
pub mod data;
mod driving;
pub mod evaluate;
pub mod models;
pub mod odometry;
pub mod plan;
mod planned_targets;
pub mod prepare;
mod public_map;
pub mod record;
pub mod route;
pub mod run;
mod seeds;
pub mod serve;
pub mod show;
mod show_conditions;
pub mod srtp;
pub mod verify;
pub mod world;

use std::path::Path;

use anyhow::Context;
use openbench_agents::open::Models;
use openbench_core::Georeference;
use openbench_models::{Budget, Exchanges};
use openbench_osm::{OsmData, OsmMap, cut_out, default_georeference};

use crate::args::CutArgs;

/// Reads a map and says what was survived while reading.
pub fn read_data(path: &Path) -> anyhow::Result<OsmData> {
    let data = OsmData::read(path)?;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    data.report
        .notes()
        .iter()
        .for_each(|note| crate::outcome::tell(&format!("{file}: {note}")));
    Ok(data)
}

/// Reads the part of a map that is asked for, and says how it lies on the Earth.
pub fn read_part(path: &Path, cut: &CutArgs) -> anyhow::Result<(OsmData, Georeference)> {
    let (whole, window) = (read_data(path)?, cut.window()?);
    let map = match &window {
        Some(window) => cut_out(&whole, window),
        None => whole,
    };
    let file = path.display();
    if let Some(window) = window.filter(|_| map.nodes.is_empty()) {
        anyhow::bail!("{file}: nothing of the map lies in {window} (west, south, east, north)");
    }
    let georeference = match cut.georef {
        Some(georeference) => georeference,
        None => default_georeference(&map).with_context(|| file.to_string())?,
    };
    Ok((map, georeference))
}

/// The models of a command that plans: as much as it takes, recorded in a file if one is named,
/// which must be none that the command reads.
pub fn unbounded_models(
    planner: &str,
    read: &[&Path],
    exchanges: Option<&Path>,
) -> anyhow::Result<Models> {
    let files = planner.split(',').filter_map(|model| {
        let file = model.strip_prefix("replay:");
        file.or_else(|| model.strip_prefix("local:"))
    });
    let read: Vec<&Path> = read.iter().copied().chain(files.map(Path::new)).collect();
    spare_inputs(&read, exchanges.as_slice())?;
    let budget = Budget {
        calls: u32::MAX,
        tokens: u64::MAX,
        seconds: u32::MAX,
    };
    let exchanges = exchanges.map_or(Exchanges::Unkept, |path| Exchanges::Keep(path.to_owned()));
    Ok(Models::new(budget, exchanges))
}

/// Refuses to write a file that the command reads, or two results to one file.
pub fn spare_inputs(read: &[&Path], written: &[&Path]) -> anyhow::Result<()> {
    for (i, out) in written.iter().enumerate() {
        let others = read.iter().chain(&written[..i]);
        // By name as well: a file that does not exist yet has no canonical path.
        if let Some(same) = others
            .into_iter()
            .find(|path| *path == out || is_same_file(path, out))
        {
            anyhow::bail!(
                "{} would overwrite {}; name another file",
                out.display(),
                same.display()
            );
        }
    }
    Ok(())
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    one.canonicalize()
        .is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

/// Reads a map and lays it flat where it lies.
pub fn read_map(path: &Path) -> anyhow::Result<OsmMap> {
    let data = read_data(path)?;
    let georeference = default_georeference(&data).with_context(|| path.display().to_string())?;
    Ok(OsmMap::new(&data, georeference))
}
