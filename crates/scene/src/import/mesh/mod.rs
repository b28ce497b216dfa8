//! Mesh files as triangles with materials: COLLADA, Wavefront OBJ, STL.
//!
//! Lengths come out in metres where the file has a unit (COLLADA), else in the file's own numbers, and z points up where the
//! file says what is up (COLLADA). Normals are not read: triangles are flat.

mod dae;
mod dae_geometry;
mod dae_material;
mod obj;
mod stl;

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Point3;

use super::error::ImportError;
use super::xml::read_bytes;

const MAX_TRIANGLES: usize = 5_000_000;

/// A mesh file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Its parts in the order of the file.
    pub(crate) parts: Vec<Part>,
    /// What the parts' indices name.
    pub(crate) materials: Vec<MeshMaterial>,
}

/// Triangles of one material.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Part {
    /// Names by which `<submesh>` can ask for it.
    pub(crate) names: Vec<String>,
    /// Index into [`Mesh::materials`].
    pub(crate) material: Option<usize>,
    /// Position and texture coordinates.
    pub(crate) corners: Vec<Corner>,
    /// Counter-clockwise from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Position and texture coordinates.
pub(crate) type Corner = (Point3<f64>, [f32; 2]);

/// How a mesh file paints a part.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshMaterial {
    /// sRGB colour; white under an image.
    pub(crate) color: [f32; 3],
    /// The image as the file names it.
    pub(crate) image: Option<String>,
    /// Whether transparent texels are holes.
    pub(crate) cutout: bool,
}

impl Default for MeshMaterial {
    fn default() -> Self {
        Self { color: [1.0; 3], image: None, cutout: false }
    }
}

/// Reads a mesh file; its name's ending tells the format.
pub(crate) fn read(path: &Path) -> Result<Mesh, ImportError> {
    let bytes = read_bytes(path)?;
    let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let mesh = match ending.as_deref() {
        Some("dae") => dae::read(path, &String::from_utf8_lossy(&bytes))?,
        Some("obj") => obj::read(path, &String::from_utf8_lossy(&bytes))?,
        Some("stl") => stl::read(path, &bytes)?,
        _ => {
            return Err(ImportError::asset(
                path,
                "this mesh format is not supported; use .dae, .obj or .stl",
            ));
        }
    };
    let triangles: usize = mesh.parts.iter().map(|p| p.triangles.len()).sum();
    if triangles > MAX_TRIANGLES {
        return Err(ImportError::too_large(path, "triangles", MAX_TRIANGLES));
    }
    if triangles == 0 {
        return Err(ImportError::asset(path, "there is no triangle in this mesh"));
    }
    Ok(mesh)
}

/// Joins corners that share position and texture coordinates, by their indices in the file.
#[derive(Debug, Default)]
struct Joiner {
    known: BTreeMap<(usize, usize), u32>,
    part: Part,
}

impl Joiner {
    /// The number of the corner with these indices, which `make` makes when it is new.
    fn corner(&mut self, key: (usize, usize), make: impl FnOnce() -> Corner) -> u32 {
        let corners = &mut self.part.corners;
        *self.known.entry(key).or_insert_with(|| {
            corners.push(make());
            corners.len() as u32 - 1
        })
    }

    /// Adds a polygon as a fan of triangles.
    fn fan(&mut self, corners: &[u32]) {
        for pair in corners.windows(2).skip(1) {
            self.part.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }
}
