//! Vertical rectangles over a line: walls, fitted images, and fences that are seen through.

use std::ops::Range;

use openbench_geometry::Segment;

use super::surface::{Surface, at};
use crate::material::MaterialId;
use crate::scene::{Corner, Layer, SceneBuilder};

/// A vertical rectangle over a line, seen from its right; the image is tiled by metres.
pub(crate) fn wall(
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
pub(crate) fn panel(
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
pub(crate) fn see_through(
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
        Corner::new(at(a, z.start), [0.0, v.start]),
        Corner::new(at(b, z.start), [u, v.start]),
        Corner::new(at(b, z.end), [u, v.end]),
        Corner::new(at(a, z.end), [0.0, v.end]),
    ];
    scene.mesh(layer, material, &corners, &[[0, 1, 2], [0, 2, 3]]);
}
