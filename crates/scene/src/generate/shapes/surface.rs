//! Surfaces of materials, and the corners of what is built of them.

use nalgebra::Point3;
use openbench_core::MapPoint;

use crate::material::MaterialId;

/// A material, and how many metres its image covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    pub material: MaterialId,
    pub tile: f64,
}

/// Corner with texture coordinates in tiles.
pub(crate) type Corner = (Point3<f64>, [f32; 2]);

/// A point at a height.
pub(crate) fn at(p: MapPoint, z: f64) -> Point3<f64> {
    Point3::new(p.x, p.y, z)
}
