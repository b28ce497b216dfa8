//! Triangles with materials: the common result of all mesh formats.

use std::collections::BTreeMap;

use crate::scene::Corner;

/// Triangles of a mesh file at most.
pub(super) const MAX_TRIANGLES: usize = 5_000_000;

/// A mesh file.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Its parts in the order of the file.
    pub(crate) parts: Vec<Part>,
    /// Materials that the parts refer to.
    pub(crate) materials: Vec<MeshMaterial>,
}

/// Triangles of one material.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Part {
    /// Names by which `<submesh>` can refer to it.
    pub(crate) names: Vec<String>,
    /// Index into [`Mesh::materials`].
    pub(crate) material: Option<usize>,
    /// Position and texture coordinates.
    pub(crate) corners: Vec<Corner>,
    /// Counter-clockwise from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The material of a part in a mesh file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshMaterial {
    /// sRGB colour; white under an image.
    pub(crate) color: [f32; 3],
    /// Path of the image as in the file.
    pub(crate) image: Option<String>,
    /// Whether transparent texels are holes.
    pub(crate) cutout: bool,
}

impl Default for MeshMaterial {
    fn default() -> Self {
        Self {
            color: [1.0; 3],
            image: None,
            cutout: false,
        }
    }
}

/// A corner by its indices in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CornerKey {
    pub(super) position: usize,
    /// Of its texture coordinates; 0 for corners without any.
    pub(super) uv: usize,
}

/// Joins corners that share position and texture coordinates, by their indices in the file.
#[derive(Debug, Default)]
pub(super) struct Joiner {
    known: BTreeMap<CornerKey, u32>,
    pub(super) part: Part,
}

impl Joiner {
    /// The number of the corner with these indices, which `make` makes when it is new.
    pub(super) fn corner(&mut self, key: CornerKey, make: impl FnOnce() -> Corner) -> u32 {
        let corners = &mut self.part.corners;
        *self.known.entry(key).or_insert_with(|| {
            corners.push(make());
            corners.len() as u32 - 1
        })
    }

    /// Adds a polygon as a fan of triangles.
    pub(super) fn fan(&mut self, corners: &[u32]) {
        for pair in corners.windows(2).skip(1) {
            self.part.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }
}
