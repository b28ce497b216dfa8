//! Random windows of maps.

use std::path::{Path, PathBuf};

use openbench_core::{Georeference, LonLat};
use openbench_osm::{OsmData, Window, cut_out};
use rand::RngExt;
use rand_pcg::Pcg32;
use serde::{Deserialize, Serialize};

use super::plan::TownsPlan;
use openbench_bench::worlds::Recipe;
use openbench_bench::worlds::folder::{DrawRequest, write};
use openbench_bench::{BenchError, Prepared};

/// Minimum number of doors to deliver to in a window.
const MIN_DOORS: usize = 10;
/// Maximum number of positions of a map that are tried for one window.
const MAX_TRIES: usize = 60;
/// Minimum number of buildings in a window.
const MIN_BUILDINGS: usize = 6;
/// Length of a degree of latitude.
const METRES_PER_DEGREE: f64 = 111_320.0;

/// The position of a window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindowPlace {
    /// Index of the map in the plan.
    pub map: usize,
    /// Name of the map and number of the window.
    pub name: String,
    /// Centre of the window.
    pub around: LonLat,
}

/// A window with its world, ready to run.
pub struct DrawnWorld {
    /// Position of the window.
    pub place: WindowPlace,
    /// Its world.
    pub prepared: Prepared,
}

/// Maps with the positions of their buildings.
pub struct Maps(Vec<Map>);

struct Map {
    name: String,
    data: OsmData,
    /// A corner of each building, in the order of their OSM ids.
    buildings: Vec<LonLat>,
}

impl Maps {
    /// Reads maps.
    ///
    /// # Errors
    /// [`BenchError::World`] for a map that cannot be read.
    pub fn read(paths: &[PathBuf]) -> Result<Self, BenchError> {
        let maps: Result<Vec<Map>, BenchError> = paths.iter().map(|path| Map::read(path)).collect();
        Ok(Self(maps?))
    }

    /// Draws window `number` of a plan, which overlaps none of the `taken` ones, and writes its
    /// world to `folder`.
    ///
    /// If its map has no space for another window, the next map is used; `None` if no map has.
    ///
    /// # Errors
    /// A world that cannot be written.
    pub fn draw(
        &self,
        plan: &TownsPlan,
        number: usize,
        taken: &[&WindowPlace],
        folder: &Path,
    ) -> Result<Option<DrawnWorld>, BenchError> {
        for turn in 0..self.0.len() {
            let map = (number + turn) % self.0.len();
            let drawn = self.draw_from(map, plan, number, taken, folder)?;
            if drawn.is_some() {
                return Ok(drawn);
            }
        }
        Ok(None)
    }

    fn draw_from(
        &self,
        map: usize,
        plan: &TownsPlan,
        number: usize,
        taken: &[&WindowPlace],
        folder: &Path,
    ) -> Result<Option<DrawnWorld>, BenchError> {
        let Map {
            name,
            data,
            buildings,
        } = &self.0[map];
        // A stream for each window: windows do not depend on how many tries earlier ones took.
        let mut random = Pcg32::new(plan.seed, number as u64);
        let mut tried: Vec<LonLat> = Vec::new();
        for _ in 0..MAX_TRIES.min(buildings.len()) {
            // Around a building: other positions of a map may be far from any door.
            let around = buildings[random.random_range(0..buildings.len())];
            let overlaps = taken.iter().any(|window| {
                window.map == map && metres(around, window.around) < 2.0 * plan.radius
            });
            // A centre near one that did not suit will hardly suit.
            let is_known = |other: &LonLat| metres(around, *other) < plan.radius / 2.0;
            if overlaps || tried.iter().any(is_known) {
                continue;
            }
            tried.push(around);
            let Ok(window) = Window::around(around, plan.radius) else {
                continue;
            };
            // Before the map is cut and a world is built, which takes much longer.
            if buildings.iter().filter(|at| window.contains(**at)).count() < MIN_BUILDINGS {
                continue;
            }
            let part = cut_out(data, &window);
            let place = WindowPlace {
                map,
                name: format!("{name}-{number:03}"),
                around,
            };
            if let Some(prepared) = write_world(plan, number, &place, &part, folder)? {
                return Ok(Some(DrawnWorld { place, prepared }));
            }
        }
        Ok(None)
    }
}

impl Map {
    fn read(path: &Path) -> Result<Self, BenchError> {
        let data = OsmData::read(path).map_err(BenchError::world)?;
        let corner = |way: &openbench_osm::Way| {
            let first = way.nodes.iter().find_map(|id| data.nodes.get(id));
            first.map(|node| node.position)
        };
        let houses = data.ways.values().filter(|way| way.tags.says("building"));
        let buildings = houses.filter_map(corner).collect();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let name = file.split('.').next().unwrap_or_default().to_owned();
        Ok(Self {
            name,
            data,
            buildings,
        })
    }
}

/// Distance between two positions in a town, metres, on an equirectangular projection.
fn metres(a: LonLat, b: LonLat) -> f64 {
    let east = (a.lon - b.lon) * libm::cos(a.lat.to_radians());
    METRES_PER_DEGREE * libm::hypot(east, a.lat - b.lat)
}

/// Writes the world of a window; `None` if a robot cannot start there or reaches too few doors.
fn write_world(
    plan: &TownsPlan,
    number: usize,
    place: &WindowPlace,
    map: &OsmData,
    folder: &Path,
) -> Result<Option<Prepared>, BenchError> {
    // The centre has x = -false_origin, so the origin lies that far to the east.
    let georeference = Georeference::TangentPlane {
        at: place.around,
        offset_x: -plan.false_origin,
        offset_y: 0.0,
    };
    let seed = plan.window_seed(number);
    let recipe = Recipe::generated(&place.name, georeference, seed);
    let request = DrawRequest {
        singles: 4,
        sequences: 1,
        sequence_length: 3,
        max_distance_m: 2.0 * plan.radius,
        seed,
    };
    match write(folder, &recipe, map, request) {
        Ok(written) if written.candidates >= MIN_DOORS => {
            Ok(Some(written.prepared.with_episodes(None)?))
        }
        // No free ground at the start, or no doors: not suitable for a robot.
        Ok(_) | Err(BenchError::World(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_in_metres() {
        let (a, b) = (LonLat::new(8.0, 60.0), LonLat::new(8.001, 60.0));
        assert!((metres(a, b) - 55.66).abs() < 0.1);
        assert!((metres(a, LonLat::new(8.0, 60.001)) - 111.32).abs() < 0.1);
    }
}
