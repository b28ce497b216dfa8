//! STL, binary and ASCII, through the crate `mesh-loader`. Colours are not read.

use std::path::Path;

use nalgebra::Point3;

use super::super::error::ImportError;
use super::part::{Mesh, Part};
use crate::scene::Corner;

/// Reads STL.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Mesh, ImportError> {
    if is_cut_short(bytes) {
        return Err(ImportError::asset(
            path,
            "this STL file ends before its last triangle",
        ));
    }
    let scene = mesh_loader::stl::from_slice(bytes).map_err(|source| ImportError::Stl {
        path: path.to_owned(),
        source,
    })?;
    let parts = scene.meshes.into_iter().map(part).collect();
    Ok(Mesh {
        parts,
        materials: Vec::new(),
    })
}

/// Whether binary STL has fewer triangles of 50 bytes than its header declares.
fn is_cut_short(bytes: &[u8]) -> bool {
    let promised = bytes
        .get(80..84)
        .and_then(|b| b.try_into().ok())
        .map(u32::from_le_bytes);
    let needed = promised.map_or(84, |n| 84 + 50 * u64::from(n));
    !bytes.trim_ascii_start().starts_with(b"solid") && (bytes.len() as u64) < needed
}

fn part(mesh: mesh_loader::Mesh) -> Part {
    let corner = |[x, y, z]: &[f32; 3]| {
        Corner::new(
            Point3::new(f64::from(*x), f64::from(*y), f64::from(*z)),
            [0.0; 2],
        )
    };
    Part {
        names: vec![mesh.name],
        material: None,
        corners: mesh.vertices.iter().map(corner).collect(),
        triangles: mesh.faces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ascii_triangle() {
        let text = b"solid one\nfacet normal 0 0 1\nouter loop\n\
            vertex 0 0 0\nvertex 2 0 0\nvertex 0 3 0\nendloop\n\
            endfacet\nendsolid one\n";
        let mesh = read(Path::new("a.stl"), text).unwrap();
        assert_eq!(mesh.parts[0].triangles.len(), 1);
        assert_eq!(
            mesh.parts[0].corners[2].position,
            Point3::new(0.0, 3.0, 0.0)
        );
    }

    #[test]
    fn a_binary_header_that_promises_too_much_is_an_error() {
        let mut bytes = vec![0u8; 80];
        bytes.extend(u32::MAX.to_le_bytes());
        bytes.extend([0u8; 50]);
        assert!(read(Path::new("a.stl"), &bytes).is_err());
    }
}
