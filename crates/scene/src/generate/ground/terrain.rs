//! The ground, cut out where the sea is.

use nalgebra::{Point3, Vector3};
use openbench_core::MapPoint;
use openbench_geometry::{Bounds, Polygon, signed_area, turn};

use crate::beyond::{Rectangle, beyond};
use crate::generate::inputs::Inputs;
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::output::Output;
use crate::generate::shapes::{Surface, at, floor, level_uv};
use crate::generate::water::coast::SEA_LEVEL_M;
use crate::material::SemanticClass;
use crate::scene::{Corner, Layer, SceneBuilder};
use crate::triangulate::triangulate;

/// Height of the sea where the ground could not be cut out, metres: just above it.
const Z_SEA_M: f64 = 0.001;
/// Ground beyond the sea's edge, metres, so that the sea is a hole in it.
pub(super) const RIM_M: f64 = 0.05;
/// Largest error of the area of the land, as a share of the whole.
const AREA_TOLERANCE: f64 = 1e-3;

/// What the ground covers.
pub(crate) fn rim_of(extent: Bounds) -> Bounds {
    extent.grown(GROUND_MARGIN_M + RIM_M)
}

/// Builds the ground and the sea.
pub(crate) fn build(inputs: &Inputs, out: &mut Output) {
    let rim = rim_of(inputs.extent);
    let Bounds { low, high } = rim;
    let grass = inputs.palette.grass;
    let scene = &mut out.scene;
    scene.begin_object("ground", SemanticClass::Grass);
    let east = Vector3::x() * (high.x - low.x);
    let north = Vector3::y() * (high.y - low.y);
    let repeat = [(east.x / grass.tile) as f32, (north.y / grass.tile) as f32];
    // A robot finds ground everywhere; the quay walls keep it out of the sea.
    let holes = inputs.relief.holes();
    let layer = if inputs.sea.is_empty() {
        Layer::Both
    } else {
        Layer::Solid
    };
    if holes.is_empty() {
        scene.rectangle(layer, grass.material, at(low, 0.0), east, north, repeat);
    } else {
        // There are none where there is sea.
        perforated(scene, grass, &inputs.relief.ground);
        holes.iter().for_each(|hole| scene.pit(hole));
    }
    // The extent is that of what is drawn, without the solid ground beyond.
    scene.set_extent(rim);
    solid_beyond(scene, grass, rim);
    if inputs.sea.is_empty() {
        return;
    }
    let is_cut_out = land(scene, grass, &rim.corners(), &inputs.sea);
    if !is_cut_out {
        scene.rectangle(
            Layer::Visible,
            grass.material,
            at(low, 0.0),
            east,
            north,
            repeat,
        );
    }
    scene.begin_object("sea", SemanticClass::Water);
    for part in &inputs.sea {
        let level = if is_cut_out { SEA_LEVEL_M } else { Z_SEA_M };
        floor(scene, inputs.palette.water, &part.outer, &part.holes, level);
        // The whole of a part of the sea was cut out, its islands too.
        for island in part.holes.iter().filter(|_| is_cut_out) {
            let ring: Vec<MapPoint> = island.iter().rev().copied().collect();
            floor(scene, grass, &ring, &[], 0.0);
        }
    }
}

/// The ground with holes.
fn perforated(scene: &mut SceneBuilder, grass: Surface, ground: &[[MapPoint; 3]]) {
    for triangle in ground {
        let corners = triangle.map(|p| Corner::new(at(p, 0.0), level_uv(grass, p)));
        scene.mesh(Layer::Both, grass.material, &corners, &[[0, 1, 2]]);
    }
}

/// Solid ground around what is drawn, so that nothing falls off.
fn solid_beyond(scene: &mut SceneBuilder, grass: Surface, drawn: Bounds) {
    let drawn = Rectangle {
        low: [drawn.low.x, drawn.low.y],
        high: [drawn.high.x, drawn.high.y],
    };
    for Rectangle { low, high } in beyond(drawn) {
        let east = Vector3::x() * (high[0] - low[0]);
        let north = Vector3::y() * (high[1] - low[1]);
        let corner = Point3::new(low[0], low[1], 0.0);
        scene.rectangle(Layer::Solid, grass.material, corner, east, north, [1.0; 2]);
    }
}

/// Draws the visible land around the sea: two long faces on one another would show through each
/// other from afar. False if it cannot be made: where coasts cross each other.
fn land(
    scene: &mut SceneBuilder,
    grass: Surface,
    outline: &[MapPoint; 4],
    sea: &[Polygon],
) -> bool {
    // Holes run clockwise, as `triangulate` expects them.
    let holes: Vec<Vec<MapPoint>> = sea
        .iter()
        .map(|part| part.outer.iter().rev().copied().collect())
        .collect();
    let triangles = triangulate(outline, &holes);
    let covered: f64 = triangles
        .iter()
        .map(|[a, b, c]| turn(*a, *b, *c).abs() / 2.0)
        .sum();
    let wet: f64 = sea.iter().map(|part| signed_area(&part.outer)).sum();
    let whole = signed_area(outline);
    // Ear clipping of rings that cross each other leaves gaps or overlaps; the area shows both.
    let good = (covered - (whole - wet)).abs() < AREA_TOLERANCE * whole;
    if good {
        floor(scene, grass, outline, &holes, 0.0);
    }
    good
}
