//! Triangles and rays of a measurement as files for other ray casters: little-endian numbers
//! without headers, and `meta.json`.
//!
//! | file | content |
//! |---|---|
//! | `triangles.f32` | the three corners of each visible triangle, metres |
//! | `origins.f32`, `directions.f32` | the rays in the order of the sensor's firings; unit directions |
//! | `ranges.f32` | our ranges, metres, 0 without a hit; transparent parts of textures are ignored |

use std::path::Path;

use openbench_core::Pose3;
use openbench_scene::bvh::{LANES, MISS};
use openbench_scene::{RayPacket, Scene};
use openbench_sim::Stage;
use openbench_sim::lidar::{LINES, MAX_RANGE_M, Pattern, RAYS_PER_SCAN};
use serde_json::{Value, json};

use openbench_bench::BenchError;

/// Writes the files into `folder`, with one scan from each pose. `measured`, a JSON object, is
/// extended and written to `meta.json`.
pub(super) fn write(
    folder: &Path,
    stage: &Stage,
    poses: &[Pose3],
    measured: Value,
) -> Result<(), BenchError> {
    std::fs::create_dir_all(folder).map_err(|e| BenchError::file(folder, e))?;
    let (origins, directions) = rays(poses);
    let ranges = ranges(stage, &origins, &directions);
    let mut meta = measured;
    meta["max_range"] = json!(MAX_RANGE_M);
    meta["rays"] = json!(ranges.len());
    meta["scans"] = json!(poses.len());
    let save = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        let bad = |e: openbench_osm::OsmError| BenchError::bad_file(&path, e);
        openbench_osm::write_atomically(&path, bytes).map_err(bad)
    };
    save("triangles.f32", &bytes(corners(stage.caster().scene())))?;
    save("origins.f32", &bytes(origins.into_iter().flatten()))?;
    save("directions.f32", &bytes(directions.into_iter().flatten()))?;
    save("ranges.f32", &bytes(ranges.into_iter()))?;
    save("meta.json", meta.to_string().as_bytes())
}

fn corners(scene: &Scene) -> impl Iterator<Item = f32> {
    scene
        .standing()
        .iter()
        .flat_map(|t| t.corners)
        .flat_map(|c| scene.vertices[c as usize].position)
}

fn bytes(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

fn rays(poses: &[Pose3]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let pattern = Pattern::new();
    let firings = (RAYS_PER_SCAN / LINES) as u64;
    let (mut origins, mut directions) = (Vec::new(), Vec::new());
    for (scan, pose) in (0..).zip(poses) {
        let origin = pose.translation.vector.cast::<f32>();
        let turn = pose.rotation.cast::<f32>();
        for firing in scan * firings..(scan + 1) * firings {
            for aim in pattern.firing(firing) {
                let direction = (turn * nalgebra::Vector3::from(aim.direction)).normalize();
                origins.push(origin.into());
                directions.push(direction.into());
            }
        }
    }
    (origins, directions)
}

fn ranges(stage: &Stage, origins: &[[f32; 3]], directions: &[[f32; 3]]) -> Vec<f32> {
    let mut ranges = Vec::with_capacity(origins.len());
    for (origins, directions) in origins.chunks(LANES).zip(directions.chunks(LANES)) {
        // Lanes beyond the last ray stay idle.
        let mut packet = RayPacket::idle();
        for (lane, (origin, direction)) in origins.iter().zip(directions).enumerate() {
            packet.set(lane, *origin, *direction, MAX_RANGE_M);
        }
        let hits = stage.caster().visible().cast_packet(&packet);
        let range = |lane: usize| {
            if hits.triangle[lane] == MISS {
                0.0
            } else {
                hits.distance[lane]
            }
        };
        ranges.extend((0..origins.len()).map(range));
    }
    ranges
}
