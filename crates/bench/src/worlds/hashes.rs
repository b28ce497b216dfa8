//! Hashes of what a run was made in: BLAKE3, hexadecimal.

use std::path::Path;

use openbench_core::input;
use openbench_scene::{Material, Scene, World};
use serde::{Deserialize, Serialize};

use super::Prepared;
use crate::BenchError;

/// What a run was made in. Equal hashes mean equal inputs, wherever their files lie.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub struct Hashes {
    /// Instructions, doors, their order, traffic, sensors and conditions.
    pub suite: String,
    /// Surfaces, doors, light, and the start.
    pub world: String,
    /// The public map.
    pub map: String,
    /// The file of true positions; null if none was given.
    pub truth: Option<String>,
}

impl Hashes {
    /// Whether they say nothing, as in results of older versions.
    pub fn are_unknown(&self) -> bool {
        self.suite.is_empty() || self.world.is_empty() || self.map.is_empty()
    }

    /// The hashes of a suite that is ready to run.
    ///
    /// # Errors
    /// A file of true positions that has gone.
    pub fn of(prepared: &Prepared) -> Result<Self, BenchError> {
        let suite = &prepared.suite;
        // Without paths, so that a suite is the same in another folder.
        let parts = (
            &suite.name,
            &suite.episodes,
            suite.traffic,
            suite.sensors,
            prepared.target_source(),
        );
        // Strings, numbers and lists: every value has a JSON form.
        let mut bytes = serde_json::to_vec(&parts).unwrap_or_default();
        if !suite.conditions.are_off() {
            let conditions = (suite.conditions, suite.seed);
            bytes.extend(serde_json::to_vec(&conditions).unwrap_or_default());
        }
        Ok(Self {
            suite: hash_bytes(&bytes),
            world: hash_world(&prepared.world),
            map: hash_bytes(&prepared.public_data().to_xml()),
            truth: prepared.truth.as_deref().map(hash_file).transpose()?,
        })
    }
}

/// The hash of some bytes.
pub fn hash_bytes(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// The hash of a file, which may be larger than the memory.
///
/// # Errors
/// [`BenchError::File`].
pub fn hash_file(path: &Path) -> Result<String, BenchError> {
    let mut hasher = blake3::Hasher::new();
    input::open(path)
        .and_then(|file| hasher.update_reader(file).map(drop))
        .map_err(|e| BenchError::file(path, e))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Takes the parts of a world one by one, so that no copy of it is made.
struct Parts(blake3::Hasher);

impl Parts {
    /// Lists begin with their length, or two of them could be divided elsewhere.
    fn length(&mut self, length: usize) {
        self.0.update(&(length as u64).to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.length(text.len());
        self.0.update(text.as_bytes());
    }

    fn doubles(&mut self, values: &[f64]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }

    fn singles(&mut self, values: &[f32]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }

    fn numbers(&mut self, values: &[u32]) {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
    }
}

fn hash_world(world: &World) -> String {
    let mut parts = Parts(blake3::Hasher::new());
    parts.text(&world.name);
    parts.text(&world.georeference.to_string());
    parts.doubles(&[world.start.x, world.start.y, world.start.yaw]);
    visible(&mut parts, &world.scene);
    solid(&mut parts, &world.scene);
    doors(&mut parts, &world.scene);
    parts.0.finalize().to_hex().to_string()
}

fn visible(parts: &mut Parts, scene: &Scene) {
    parts.length(scene.vertices.len());
    for vertex in &scene.vertices {
        parts.singles(&vertex.position);
        parts.singles(&vertex.uv);
    }
    parts.length(scene.triangles.len());
    for triangle in &scene.triangles {
        parts.numbers(&triangle.corners);
        parts.numbers(&[triangle.material.0]);
    }
    parts.length(scene.materials.len());
    scene.materials.iter().for_each(|m| material(parts, m));
    parts.length(scene.textures.len());
    for texture in &scene.textures {
        parts.numbers(&[texture.width, texture.height]);
        parts.0.update(&texture.rgba);
    }
    parts.length(scene.objects.len());
    for object in &scene.objects {
        parts.text(&object.name);
        parts.0.update(&[object.class.coarse() as u8]);
    }
    parts.length(scene.object_numbers.len());
    parts.numbers(&scene.object_numbers);
    parts.singles(&scene.sun.direction);
    parts.singles(&[scene.sun.diffuse, scene.sun.ambient]);
}

fn material(parts: &mut Parts, material: &Material) {
    parts.singles(&material.color);
    // No scene has 2^32 textures, so the largest number stands for none.
    parts.numbers(&[material.texture.map_or(u32::MAX, |texture| texture.0)]);
    parts.0.update(&[
        u8::from(material.cutout),
        material.class.coarse() as u8,
        material.reflectivity,
    ]);
}

fn solid(parts: &mut Parts, scene: &Scene) {
    parts.length(scene.solid.positions.len());
    scene.solid.positions.iter().for_each(|p| parts.singles(p));
    parts.length(scene.solid.triangles.len());
    scene
        .solid
        .triangles
        .iter()
        .for_each(|corners| parts.numbers(corners));
    for class in &scene.solid.classes {
        parts.0.update(&[*class as u8]);
    }
}

fn doors(parts: &mut Parts, scene: &Scene) {
    parts.length(scene.doors.len());
    for door in &scene.doors {
        parts.text(&door.address.building);
        parts.text(door.address.unit.as_deref().unwrap_or_default());
        parts.text(&door.text);
        parts.doubles(&door.plate);
        parts.doubles(&[door.facing]);
        let doorway = door.doorway.map_or([f64::NAN; 3], |d| [d.x, d.y, d.yaw]);
        parts.doubles(&doorway);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worlds::builtin_suite;

    #[test]
    fn hashes_tell_worlds_suites_and_traffic_apart() {
        let hashes = |change: &dyn Fn(&mut Prepared)| {
            let mut prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
            change(&mut prepared);
            Hashes::of(&prepared).unwrap()
        };
        let plain = hashes(&|_| {});
        assert_eq!(plain, hashes(&|_| {}));
        let other_door = hashes(&|p| p.world.scene.doors[0].plate[2] += 1e-9);
        assert_ne!(other_door.world, plain.world);
        assert_eq!(other_door.suite, plain.suite);
        let crowded = hashes(&|p| p.suite.traffic.cars += 1);
        assert_ne!(crowded.suite, plain.suite);
        assert_eq!(crowded.world, plain.world);
        let emptied = hashes(&|p| p.world.map.nodes.clear());
        assert_ne!(emptied.map, plain.map);
    }
}
