//! Planar polygons in space, boxes and frustums, with texture coordinates in metres.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{Point3, Vector3};
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::Segment;

use super::surface::{Surface, at};
use super::upright::wall;
use crate::scene::{Corner, Layer, SceneBuilder};

/// A box in the frame of a pose: forward, left, up, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Block {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

/// Lower undersides are not drawn, metres.
const LOWEST_UNDERSIDE_M: f64 = 0.05;

/// An upright frustum with a regular polygon as its base.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frustum {
    pub center: MapPoint,
    pub sides: usize,
    /// Heights of its base and its top, metres.
    pub z: Range<f64>,
    /// Radii of its base and its top, metres; a top of radius 0 makes it a pyramid.
    pub radii: [f64; 2],
}

/// A planar polygon in space, convex, counter-clockwise from outside; texture coordinates along its
/// first edge and across it.
pub(crate) fn facet(
    scene: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    points: &[Point3<f64>],
) {
    if points.len() < 3 {
        return;
    }
    let along = (points[1] - points[0])
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    // By the two edges at the first corner: the polygon is convex, so they turn as it does.
    let normal = (points[1] - points[0]).cross(&(points[points.len() - 1] - points[0]));
    let across = normal
        .cross(&along)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::y);
    let uv = |p: &Point3<f64>| {
        let d = p - points[0];
        [
            (d.dot(&along) / surface.tile) as f32,
            (d.dot(&across) / surface.tile) as f32,
        ]
    };
    let corners: Vec<Corner> = points.iter().map(|p| Corner::new(*p, uv(p))).collect();
    scene.mesh(layer, surface.material, &corners, &fan(points.len()));
}

/// Triangles from the first corner of a convex polygon.
pub(super) fn fan(corners: usize) -> Vec<[u32; 3]> {
    (2..corners as u32).map(|i| [0, i - 1, i]).collect()
}

/// A box on a pose, without its underside if it stands on the ground.
pub(crate) fn cuboid(
    scene: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    pose: Pose2,
    Block { min, max }: Block,
) {
    let ring = [
        [min[0], min[1]],
        [max[0], min[1]],
        [max[0], max[1]],
        [min[0], max[1]],
    ];
    let ring = ring.map(|[x, y]| pose.transform(x, y));
    for i in 0..4 {
        let side = Segment::new(ring[i], ring[(i + 1) % 4]);
        wall(scene, layer, surface, side, min[2]..max[2]);
    }
    facet(scene, layer, surface, &ring.map(|q| at(q, max[2])));
    // Nothing looks under what stands on the ground or a hand's breadth above it.
    if min[2] > LOWEST_UNDERSIDE_M {
        let [a, b, c, d] = ring.map(|q| at(q, min[2]));
        facet(scene, layer, surface, &[a, d, c, b]);
    }
}

/// A frustum, closed at the top.
pub(crate) fn frustum(
    scene: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    Frustum {
        center,
        sides,
        z,
        radii,
    }: Frustum,
) {
    let corner = |i: usize, radius: f64, z: f64| {
        let direction = TAU * i as f64 / sides as f64;
        at(center.offset(direction, radius), z)
    };
    let bottom = |i: usize| corner(i, radii[0], z.start);
    let top = |i: usize| corner(i, radii[1], z.end);
    // A point has no face to close it.
    let has_top = radii[1] > 1e-6;
    for i in 0..sides {
        if has_top {
            let side = [bottom(i), bottom(i + 1), top(i + 1), top(i)];
            facet(scene, layer, surface, &side);
        } else {
            facet(scene, layer, surface, &[bottom(i), bottom(i + 1), top(i)]);
        }
    }
    if has_top {
        let cap: Vec<_> = (0..sides).map(top).collect();
        facet(scene, layer, surface, &cap);
    }
}
