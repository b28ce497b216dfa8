//! The solid part of a world in the form of the physics engine.

use std::fmt;
use std::sync::Arc;

use openbench_scene::{Scene, SemanticClass};
use rapier3d_f64::prelude::{SharedShape, TriMeshFlags, Vector};

use crate::error::SimError;

/// The solid triangles of a world: prepared once, shared by all episodes in it.
#[derive(Clone)]
pub(crate) struct Solids {
    pub(crate) mesh: SharedShape,
    /// Class of each triangle.
    pub(crate) classes: Arc<[SemanticClass]>,
}

impl Solids {
    /// The solid triangles of a scene.
    pub(crate) fn new(scene: &Scene) -> Result<Self, SimError> {
        let solid = &scene.solid;
        if solid.triangles.is_empty() {
            return Err(SimError::NothingSolid);
        }
        let vertices = solid
            .positions
            .iter()
            .map(|p| Vector::from_array(p.map(f64::from)));
        let triangles = solid.triangles.clone();
        let flags = TriMeshFlags::empty();
        let mesh = SharedShape::trimesh_with_flags(vertices.collect(), triangles, flags)
            .map_err(SimError::Mesh)?;
        Ok(Self {
            mesh,
            classes: solid.classes.as_slice().into(),
        })
    }
}

impl fmt::Debug for Solids {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Solids({} triangles)", self.classes.len())
    }
}
