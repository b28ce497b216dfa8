//! Mesh files as triangles with materials: COLLADA, Wavefront OBJ, STL.
//!
//! Lengths are in metres where the file has a unit (COLLADA), else in the numbers of the file. z
//! points up where the file has an up axis (COLLADA). Normals are not read: triangles are flat.

mod dae;
mod dae_document;
mod dae_geometry;
mod dae_material;
mod obj;
mod part;
mod stl;

use std::path::Path;

use super::error::ImportError;
use super::xml::read_bytes;
use part::MAX_TRIANGLES;
pub(crate) use part::{Mesh, MeshMaterial, Part};

/// Reads a mesh file; the extension of its name tells the format.
pub(crate) fn read(path: &Path) -> Result<Mesh, ImportError> {
    let bytes = read_bytes(path)?;
    let ending = path
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase);
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
    // Readers that can stop earlier do; this is for those that cannot.
    let triangles: usize = mesh.parts.iter().map(|p| p.triangles.len()).sum();
    if triangles > MAX_TRIANGLES {
        return Err(ImportError::too_large(path, "triangles", MAX_TRIANGLES));
    }
    if triangles == 0 {
        return Err(ImportError::asset(
            path,
            "there is no triangle in this mesh",
        ));
    }
    Ok(mesh)
}
