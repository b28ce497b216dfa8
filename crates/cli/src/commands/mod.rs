//! One file a command.

pub mod bench;
mod bench_motion;
mod bench_people;
pub mod evaluate;
pub mod models;
pub mod odometry;
pub mod plan;
pub mod prepare;
pub mod record;
pub mod route;
pub mod run;
pub mod serve;
pub mod show;
pub mod verify;
pub mod world;

use std::path::Path;

use openbench_osm::{OsmData, OsmMap, default_georeference};

/// Reads a map and says what was survived while reading.
pub fn read_data(path: &Path) -> anyhow::Result<OsmData> {
    let data = OsmData::read(path)?;
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    data.report.notes().iter().for_each(|note| crate::outcome::tell(&format!("{file}: {note}")));
    Ok(data)
}

/// Reads a map and lays it flat where it lies.
pub fn read_map(path: &Path) -> anyhow::Result<OsmMap> {
    let data = read_data(path)?;
    let georeference = default_georeference(&data).map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?;
    Ok(OsmMap::new(&data, georeference))
}
