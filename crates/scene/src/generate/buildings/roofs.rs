//! Roofs: flat with parapet, gabled, hipped, tents, and a mansard that fits over any outline.

use nalgebra::{Point3, Vector3};
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Polygon, Segment, sides, signed_area};
use rand_pcg::Pcg64Mcg;

use super::house::{House, PARAPET_M, RELIEF_M, Roof};
use super::pitched::{OVERHANG_M, Span};
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance};
use crate::generate::shapes::rings::inset;
use crate::generate::shapes::{Block, Surface, at, cuboid, facet, floor, panel};
use crate::material::MaterialId;
use crate::scene::{Corner, Layer, SceneBuilder};

/// Height of the boards along the edges of a pitched roof, metres.
const FASCIA_M: f64 = 0.18;
/// Overhang over gables, in overhangs over eaves.
const GABLE_OVERHANG: f64 = 0.7;
/// Overhang of a mansard, metres.
const MANSARD_OVERHANG_M: f64 = 0.25;
/// Smallest flat top of a mansard, m².
const SMALLEST_TOP_M2: f64 = 4.0;
/// Lowest gable with a window, metres.
const WINDOW_GABLE_M: f64 = 2.0;
/// Lowest roof with dormers, metres.
const DORMER_RISE_M: f64 = 2.4;
/// Half the width of a dormer, metres.
const DORMER_HALF_WIDTH_M: f64 = 0.75;
/// Height of a dormer's window, metres.
const DORMER_HEIGHT_M: f64 = 1.25;
/// Lowest open shelter: a robot and people go below, metres.
const SHELTER_M: f64 = 2.4;

/// Builds the roof of a house.
pub(super) fn build(inputs: &Inputs, out: &mut Output, house: &House, rng: &mut Pcg64Mcg) {
    match house.roof {
        Roof::Gabled(slope) => gabled(inputs, out, house, slope, rng),
        Roof::Hipped(slope) => hipped(inputs, out, house, slope, rng),
        Roof::Mansard => mansard(inputs, out, house, rng),
        Roof::Flat => flat(out, house, rng),
        Roof::Tent(rise) => tent(&mut out.scene, house, rise),
        Roof::Terrace => cover(&mut out.scene, house),
    }
}

/// A roof on posts, nothing below it.
pub(super) fn shelter(out: &mut Output, house: &House) {
    let z = house.eaves.max(SHELTER_M);
    floor(
        &mut out.scene,
        house.roofing,
        house.outer(),
        house.holes(),
        z,
    );
}

fn tent(scene: &mut SceneBuilder, house: &House, rise: f64) {
    let outline = Polygon::new(house.outer().to_vec(), Vec::new());
    let Some(middle) = outline.map(|p| p.centroid()) else {
        return;
    };
    let tip = at(middle, house.eaves + rise);
    for eaves in sides(house.outer()) {
        let (a, b) = (at(eaves.start, house.eaves), at(eaves.end, house.eaves));
        facet(scene, Layer::Visible, house.roofing, &[a, b, tip]);
    }
}

fn cover(scene: &mut SceneBuilder, house: &House) {
    floor(
        scene,
        house.roofing,
        house.outer(),
        house.holes(),
        house.eaves,
    );
}

fn gabled(inputs: &Inputs, out: &mut Output, house: &House, slope: f64, rng: &mut Pcg64Mcg) {
    let span = Span::of(house.outer(), house.eaves, slope);
    let overhang = OVERHANG_M * GABLE_OVERHANG;
    let ([e0, e1, e2, e3], [r0, r1]) = (span.edge(overhang), span.ridge(-overhang));
    let scene = &mut out.scene;
    facet(scene, Layer::Visible, house.roofing, &[e0, e1, r1, r0]);
    facet(scene, Layer::Visible, house.roofing, &[e2, e3, r0, r1]);
    // The gable walls end at the ridge itself, without the overhang.
    let [top0, top1] = span.ridge(0.0);
    let [a, b, c, d] = span.corners.map(|p| at(p, house.eaves));
    facet(scene, Layer::Visible, house.facade, &[b, c, top1]);
    facet(scene, Layer::Visible, house.facade, &[d, a, top0]);
    for [from, to] in [[e0, e1], [e2, e3], [e1, r1], [r1, e2], [e3, r0], [r0, e0]] {
        fascia(scene, house, from, to);
    }
    if house.plain || out.is_full() {
        return;
    }
    let scene = &mut out.scene;
    for wall in span.gables() {
        gable_window(scene, house, wall, span.rise());
    }
    if span.rise() > DORMER_RISE_M && house.detailed && chance(rng, 0.45) {
        dormers(scene, house, &span, rng);
    } else {
        roof_windows(scene, house, [e0, e1, r1, r0], rng);
    }
    chimney(scene, house, inputs.palette.facades[0], [top0, top1], rng);
}

fn hipped(inputs: &Inputs, out: &mut Output, house: &House, slope: f64, rng: &mut Pcg64Mcg) {
    let span = Span::of(house.outer(), house.eaves, slope);
    // With the ridge's ends half a width inside, all four slopes are alike. Over a square the ridge
    // would vanish: 10 cm of it stay.
    let inside = span.half_width.min(span.length() / 2.0 - 0.05);
    let ([e0, e1, e2, e3], [r0, r1]) = (span.edge(OVERHANG_M), span.ridge(inside));
    let scene = &mut out.scene;
    facet(scene, Layer::Visible, house.roofing, &[e0, e1, r1, r0]);
    facet(scene, Layer::Visible, house.roofing, &[e2, e3, r0, r1]);
    facet(scene, Layer::Visible, house.roofing, &[e1, e2, r1]);
    facet(scene, Layer::Visible, house.roofing, &[e3, e0, r0]);
    for [from, to] in [[e0, e1], [e1, e2], [e2, e3], [e3, e0]] {
        fascia(scene, house, from, to);
    }
    if !house.plain {
        chimney(scene, house, inputs.palette.facades[0], [r0, r1], rng);
    }
}

/// All rings moved inwards; `None` if an edge would be reversed.
fn moved(rings: &[Vec<MapPoint>], offset: f64) -> Option<Vec<Vec<MapPoint>>> {
    rings.iter().map(|ring| inset(ring, offset)).collect()
}

/// Area inside the first ring and outside of the holes, m².
fn area(rings: &[Vec<MapPoint>]) -> f64 {
    rings.iter().map(|ring| signed_area(ring)).sum()
}

fn mansard(inputs: &Inputs, out: &mut Output, house: &House, rng: &mut Pcg64Mcg) {
    let (run, rise) = (between(rng, 0.9, 1.4), between(rng, 1.4, 2.0));
    let inner = moved(&house.rings, run).filter(|rings| area(rings) > SMALLEST_TOP_M2);
    let outer = moved(&house.rings, -MANSARD_OVERHANG_M);
    let (Some(inner), Some(outer)) = (inner, outer) else {
        // Slopes over a narrow or jagged outline would cross each other.
        flat(out, house, rng);
        return;
    };
    let scene = &mut out.scene;
    let (low, high) = (house.eaves - 0.1, house.eaves + rise);
    for (below, above) in outer.iter().zip(&inner) {
        for (foot, top) in sides(below).zip(sides(above)) {
            let (a, b) = (at(foot.start, low), at(foot.end, low));
            let slope = [a, b, at(top.end, high), at(top.start, high)];
            facet(scene, Layer::Visible, house.roofing, &slope);
            fascia(scene, house, a, b);
        }
    }
    floor(
        scene,
        inputs.palette.flat_roof,
        &inner[0],
        &inner[1..],
        high,
    );
}

fn flat(out: &mut Output, house: &House, rng: &mut Pcg64Mcg) {
    cover(&mut out.scene, house);
    // A mansard that was given up has walls without a parapet, and needs no coping.
    if house.roof != Roof::Flat || out.is_full() {
        return;
    }
    let top = house.eaves + PARAPET_M;
    for wall in house.rings.iter().flat_map(|ring| sides(ring)) {
        let coping = Block {
            // The building is to the left of its walls: the coping covers the parapet inwards.
            min: [-0.06, -0.06, top - 0.02],
            max: [wall.length() + 0.06, 0.28, top + 0.08],
        };
        cuboid(
            &mut out.scene,
            Layer::Visible,
            house.trim,
            wall.pose(),
            coping,
        );
    }
    if house.levels >= 3 {
        stair_head(&mut out.scene, house, rng);
    }
}

/// The hut over a staircase, and a ventilator.
fn stair_head(scene: &mut SceneBuilder, house: &House, rng: &mut Pcg64Mcg) {
    let Some(polygon) = Polygon::new(house.outer().to_vec(), house.holes().to_vec()) else {
        return;
    };
    let p = polygon.interior_point();
    // The farthest corner of the two, one of the ventilator's, is 2.55 m from `p`.
    if polygon.distance_to_boundary(p) < 2.6 {
        return;
    }
    let pose = Pose2::new(p.x, p.y, house.rings[0][0].bearing_to(house.rings[0][1]));
    let z = house.eaves;
    let hut = Block {
        min: [-1.6, -1.2, z],
        max: [1.6, 1.2, z + between(rng, 1.8, 2.4)],
    };
    cuboid(scene, Layer::Visible, house.facade, pose, hut);
    let ventilator = Block {
        min: [1.8, -0.5, z],
        max: [2.5, 0.4, z + 0.8],
    };
    cuboid(scene, Layer::Visible, house.trim, pose, ventilator);
}

/// A board along an edge of a roof.
fn fascia(scene: &mut SceneBuilder, house: &House, a: Point3<f64>, b: Point3<f64>) {
    let down = Vector3::z() * FASCIA_M;
    facet(
        scene,
        Layer::Visible,
        house.trim,
        &[a - down, b - down, b, a],
    );
}

fn gable_window(scene: &mut SceneBuilder, house: &House, wall: Segment, rise: f64) {
    if rise < WINDOW_GABLE_M {
        return;
    }
    let line = Segment::across(wall.facing_out(0.5), RELIEF_M, 0.4);
    let z = house.eaves + 0.2..house.eaves + 1.2;
    panel(scene, Layer::Visible, house.windows[0], line, z);
}

/// Windows in the slope between the eaves `e0`-`e1` and the ridge `r0`-`r1`.
fn roof_windows(
    scene: &mut SceneBuilder,
    house: &House,
    [e0, e1, r1, r0]: [Point3<f64>; 4],
    rng: &mut Pcg64Mcg,
) {
    let count = between(rng, 0.0, 3.9) as usize;
    // A little above the slope, which would show through the windows otherwise.
    let normal = (e1 - e0).cross(&(r0 - e0)).normalize() * 0.05;
    for i in 0..count {
        let share = (i as f64 + 1.0) / (count as f64 + 1.0);
        let (low, high) = (e0 + (e1 - e0) * share, r0 + (r1 - r0) * share);
        let (side, up) = ((e1 - e0).normalize() * 0.4, high - low);
        let (bottom, top) = (low + up * 0.4 + normal, low + up * 0.62 + normal);
        let corners = [
            Corner::new(bottom - side, [0.0, 0.0]),
            Corner::new(bottom + side, [1.0, 0.0]),
            Corner::new(top + side, [1.0, 1.0]),
            Corner::new(top - side, [0.0, 1.0]),
        ];
        scene.mesh(
            Layer::Visible,
            house.windows[0],
            &corners,
            &[[0, 1, 2], [0, 2, 3]],
        );
    }
}

/// Small gabled windows that stand in the slope over the wall 0-1.
fn dormers(scene: &mut SceneBuilder, house: &House, span: &Span, rng: &mut Pcg64Mcg) {
    let wall = Segment::new(span.corners[0], span.corners[1]);
    let count = ((wall.length() / 3.6) as usize).clamp(1, 8);
    let back = between(rng, 0.5, 0.9);
    for i in 0..count {
        let pose = wall.facing_out((i as f64 + 0.5) / count as f64);
        dormer(scene, house, span.slope, pose, back, house.windows[i % 2]);
    }
}

fn dormer(
    scene: &mut SceneBuilder,
    house: &House,
    slope: f64,
    pose: Pose2,
    back: f64,
    image: MaterialId,
) {
    // Where the slope is as high as the dormer's sill, eaves and ridge.
    let sill = house.eaves + back * slope;
    let depth = |z: f64| -(z - house.eaves) / slope;
    let (eaves, ridge) = (sill + DORMER_HEIGHT_M, sill + DORMER_HEIGHT_M + 0.55);
    let p = |x: f64, y: f64, z: f64| at(pose.transform(x, y), z);
    let (front, wide) = (depth(sill), DORMER_HALF_WIDTH_M);
    panel(
        scene,
        Layer::Visible,
        image,
        Segment::across(pose, front, wide),
        sill..eaves,
    );
    let gable = [
        p(front, -wide, eaves),
        p(front, wide, eaves),
        p(front, 0.0, ridge),
    ];
    facet(scene, Layer::Visible, house.trim, &gable);
    for side in [-1.0, 1.0] {
        let y = side * wide;
        let cheek = [
            p(front, y, sill),
            p(front, y, eaves),
            p(depth(eaves), y, eaves),
        ];
        facet(scene, Layer::Visible, house.facade, &cheek);
        let over = y * 1.2;
        let roof = [
            p(front + 0.2, over, eaves - 0.1),
            p(front + 0.2, 0.0, ridge),
            p(depth(ridge), 0.0, ridge),
            p(depth(eaves - 0.1), over, eaves - 0.1),
        ];
        facet(scene, Layer::Visible, house.roofing, &roof);
    }
}

/// A chimney on a ridge, with a cap.
fn chimney(
    scene: &mut SceneBuilder,
    house: &House,
    surface: Surface,
    [r0, r1]: [Point3<f64>; 2],
    rng: &mut Pcg64Mcg,
) {
    if !chance(rng, 0.75) {
        return;
    }
    // Away from the gables, so that the whole stack stands in the roof.
    let p = r0 + (r1 - r0) * between(rng, 0.15, 0.85);
    let ridge = Segment::new(MapPoint::new(r0.x, r0.y), MapPoint::new(r1.x, r1.y));
    let pose = Pose2::new(p.x, p.y, ridge.bearing());
    let stack = Block {
        min: [-0.35, -0.3, p.z - 0.7],
        max: [0.35, 0.3, p.z + 0.8],
    };
    cuboid(scene, Layer::Visible, surface, pose, stack);
    let cap = Block {
        min: [-0.42, -0.37, p.z + 0.8],
        max: [0.42, 0.37, p.z + 0.9],
    };
    cuboid(scene, Layer::Visible, house.plinth, pose, cap);
}
