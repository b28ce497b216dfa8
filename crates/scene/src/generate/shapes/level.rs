//! Level surfaces, seen from above: rectangles, filled outlines, and bands along lines.

use std::f64::consts::PI;

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::line::parallel;

use super::solids::{facet, fan};
use super::surface::{Surface, at};
use crate::scene::{Corner, Layer, SceneBuilder};
use crate::triangulate::triangulate;

/// A rectangle about a pose at height `z`, seen from above.
pub(crate) fn level_rectangle(
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
pub(crate) fn level_uv(surface: Surface, p: MapPoint) -> [f32; 2] {
    [(p.x / surface.tile) as f32, (p.y / surface.tile) as f32]
}

/// A corner of what lies level at height `z`.
fn level_corner(surface: Surface, p: MapPoint, z: f64) -> Corner {
    Corner::new(at(p, z), level_uv(surface, p))
}

/// A filled outline with holes at height `z`, seen from above.
pub(crate) fn floor(
    scene: &mut SceneBuilder,
    surface: Surface,
    outer: &[MapPoint],
    holes: &[Vec<MapPoint>],
    z: f64,
) {
    // Triangulation gives points, not numbers of corners: triangles do not share any.
    for triangle in triangulate(outer, holes) {
        let corners = triangle.map(|p| level_corner(surface, p, z));
        scene.mesh(Layer::Visible, surface.material, &corners, &[[0, 1, 2]]);
    }
}

/// A flat band along a line, `half` metres to either side, with mitred bends and rounded ends.
pub(crate) fn band(
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
        let across = (2.0 * half / surface.tile) as f32;
        corners.push(Corner::new(at(right, z), [u, 0.0]));
        corners.push(Corner::new(at(left, z), [u, across]));
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
        // Roads end at junctions at any angle: round ends leave no notch between them.
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
    let corners: Vec<Corner> = points.map(|p| level_corner(surface, p, z)).collect();
    scene.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &fan(corners.len()),
    );
}
