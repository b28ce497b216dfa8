//! Boxes, frustums, bands and filled outlines, with texture coordinates in metres.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{Point3, Vector3};
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::Segment;

use super::rings::parallel;
use crate::material::MaterialId;
use crate::scene::{Layer, SceneBuilder};
use crate::triangulate::triangulate;

/// A material, and how many metres its image covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    pub material: MaterialId,
    pub tile: f64,
}

/// Corner with texture coordinates in tiles.
pub(super) type Corner = (Point3<f64>, [f32; 2]);

/// A box in the frame of a pose: forward, left, up, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

/// An upright frustum with a regular polygon as its base.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frustum {
    pub center: MapPoint,
    pub sides: usize,
    /// Heights of its base and its top, metres.
    pub z: Range<f64>,
    /// Radii of its base and its top, metres; a top of radius 0 makes it a pyramid.
    pub radii: [f64; 2],
}

/// A point at a height.
pub(super) fn at(p: MapPoint, z: f64) -> Point3<f64> {
    Point3::new(p.x, p.y, z)
}

/// A vertical rectangle over a line, seen from its right; the image is tiled by metres.
pub(super) fn wall(
    scene: &mut SceneBuilder,
    layer: Layer,
    surface: Surface,
    line: Segment,
    z: Range<f64>,
) {
    let u = (line.length() / surface.tile) as f32;
    let v = (z.start / surface.tile) as f32..(z.end / surface.tile) as f32;
    upright(scene, layer, surface.material, line, z, u, v);
}

/// The same with the image fitted to the rectangle once.
pub(super) fn panel(
    scene: &mut SceneBuilder,
    layer: Layer,
    material: MaterialId,
    line: Segment,
    z: Range<f64>,
) {
    upright(scene, layer, material, line, z, 1.0, 0.0..1.0);
}

/// The same with an image that is as high as the rectangle and repeats along it: a fence that is
/// seen through.
pub(super) fn see_through(
    scene: &mut SceneBuilder,
    surface: Surface,
    line: Segment,
    z: Range<f64>,
) {
    let u = (line.length() / surface.tile) as f32;
    // Not quite the whole height: texels of the opposite edge must not show.
    upright(
        scene,
        Layer::Visible,
        surface.material,
        line,
        z,
        u,
        0.001..0.999,
    );
}

/// A vertical rectangle whose image reaches from 0 to `u` along it and over `v` upwards.
fn upright(
    scene: &mut SceneBuilder,
    layer: Layer,
    material: MaterialId,
    Segment { start: a, end: b }: Segment,
    z: Range<f64>,
    u: f32,
    v: Range<f32>,
) {
    let corners = [
        (at(a, z.start), [0.0, v.start]),
        (at(b, z.start), [u, v.start]),
        (at(b, z.end), [u, v.end]),
        (at(a, z.end), [0.0, v.end]),
    ];
    scene.mesh(layer, material, &corners, &[[0, 1, 2], [0, 2, 3]]);
}

/// A planar polygon in space, convex, counter-clockwise from outside; texture coordinates along its
/// first edge and across it.
pub(super) fn facet(
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
    let corners: Vec<Corner> = points.iter().map(|p| (*p, uv(p))).collect();
    scene.mesh(layer, surface.material, &corners, &fan(points.len()));
}

/// Triangles from the first corner of a convex polygon.
fn fan(corners: usize) -> Vec<[u32; 3]> {
    (2..corners as u32).map(|i| [0, i - 1, i]).collect()
}

/// A box on a pose, without its underside if it stands on the ground.
pub(super) fn cuboid(
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
    if min[2] > 0.05 {
        let [a, b, c, d] = ring.map(|q| at(q, min[2]));
        facet(scene, layer, surface, &[a, d, c, b]);
    }
}

/// A frustum, closed at the top.
pub(super) fn frustum(
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
    let direction = |i: usize| TAU * i as f64 / sides as f64;
    let bottom = |i: usize| at(center.offset(direction(i), radii[0]), z.start);
    let top = |i: usize| at(center.offset(direction(i), radii[1]), z.end);
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

/// A rectangle about a pose at height `z`, seen from above.
pub(super) fn level_rectangle(
    scene: &mut SceneBuilder,
    surface: Surface,
    pose: Pose2,
    length: f64,
    width: f64,
    z: f64,
) {
    let (x, y) = (length / 2.0, width / 2.0);
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let corners = corners.map(|[x, y]| at(pose.transform(x, y), z));
    facet(scene, Layer::Visible, surface, &corners);
}

/// Texture coordinates of what lies level: the image is laid out along the axes of `map`.
pub(super) fn level_uv(surface: Surface, p: MapPoint) -> [f32; 2] {
    [(p.x / surface.tile) as f32, (p.y / surface.tile) as f32]
}

/// A filled outline with holes at height `z`, seen from above.
pub(super) fn floor(
    scene: &mut SceneBuilder,
    surface: Surface,
    outer: &[MapPoint],
    holes: &[Vec<MapPoint>],
    z: f64,
) {
    for triangle in triangulate(outer, holes) {
        let corners = triangle.map(|p| (at(p, z), level_uv(surface, p)));
        scene.mesh(Layer::Visible, surface.material, &corners, &[[0, 1, 2]]);
    }
}

/// A flat band along a line, `half` metres to either side, with mitred bends and rounded ends.
pub(super) fn band(
    scene: &mut SceneBuilder,
    surface: Surface,
    line: &[MapPoint],
    half: f64,
    z: f64,
) {
    let edges = parallel(line, half).into_iter().zip(parallel(line, -half));
    let (mut corners, mut run) = (Vec::<Corner>::new(), 0.0);
    for (i, (left, right)) in edges.enumerate() {
        run += if i > 0 {
            line[i].distance(line[i - 1])
        } else {
            0.0
        };
        let u = (run / surface.tile) as f32;
        corners.push((at(right, z), [u, 0.0]));
        corners.push((at(left, z), [u, (2.0 * half / surface.tile) as f32]));
    }
    let quads = (1..line.len() as u32).flat_map(|i| {
        let k = 2 * i;
        [[k - 2, k, k + 1], [k - 2, k + 1, k - 1]]
    });
    scene.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &quads.collect::<Vec<_>>(),
    );
    if line.len() > 1 {
        let last = line.len() - 1;
        for (end, before) in [(0, 1), (last, last - 1)] {
            let facing = line[before].bearing_to(line[end]);
            half_disc(scene, surface, line[end], facing, half, z);
        }
    }
}

fn half_disc(
    scene: &mut SceneBuilder,
    surface: Surface,
    center: MapPoint,
    facing: f64,
    radius: f64,
    z: f64,
) {
    const STEPS: usize = 6;
    let angle = |i: usize| facing + PI * (i as f64 / STEPS as f64 - 0.5);
    let points = (0..=STEPS).map(|i| center.offset(angle(i), radius));
    let corners: Vec<Corner> = points.map(|p| (at(p, z), level_uv(surface, p))).collect();
    scene.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &fan(corners.len()),
    );
}
