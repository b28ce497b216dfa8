//! Surfaces of materials, and points at a height.

use nalgebra::Point3;
use openbench_core::MapPoint;

use crate::material::MaterialId;

/// A material, and how many metres its image covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    pub material: MaterialId,
    pub tile: f64,
}

/// A point at a height.
pub(crate) fn at(p: MapPoint, z: f64) -> Point3<f64> {
    Point3::new(p.x, p.y, z)
}
