//! Clipped hedges: never quite straight.

use nalgebra::Point3;
use openbench_core::Pose2;
use openbench_geometry::Segment;
use rand_pcg::Pcg64Mcg;

use crate::generate::inputs::Inputs;
use crate::generate::seeds::{Purpose, between, stream};
use crate::generate::shapes::{Block, Surface, at, cuboid};
use crate::scene::{Corner, Layer, SceneBuilder};

/// Distance between the cross sections of a hedge in a neighbourhood, metres.
const SECTION_M: f64 = 1.2;
/// The same in a town, where there are many hedges, metres.
const TOWN_SECTION_M: f64 = 4.0;
/// Sections of one stretch at most.
const MAX_SECTIONS: usize = 1_000;
/// Largest distance of a corner from its place, metres.
const DENT_M: f64 = 0.05;
/// Corners of a cross section.
const CORNERS: usize = 6;

/// A corner of the cross section.
struct ProfileCorner {
    /// Share of half the thickness, to the left.
    side: f64,
    /// Share of the height.
    up: f64,
}

const PROFILE: [ProfileCorner; CORNERS] = [
    ProfileCorner {
        side: -0.86,
        up: 0.0,
    },
    ProfileCorner {
        side: -1.0,
        up: 0.55,
    },
    ProfileCorner {
        side: -0.82,
        up: 0.96,
    },
    ProfileCorner {
        side: 0.82,
        up: 0.96,
    },
    ProfileCorner {
        side: 1.0,
        up: 0.55,
    },
    ProfileCorner {
        side: 0.86,
        up: 0.0,
    },
];

/// Height and thickness of a hedge, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Size {
    pub height: f64,
    pub thickness: f64,
}

/// A cross section, `run` metres along the hedge.
struct Section {
    run: f64,
    corners: [Point3<f64>; CORNERS],
}

/// Builds a hedge along a line. What a robot touches is a box.
pub(crate) fn build(inputs: &Inputs, scene: &mut SceneBuilder, line: Segment, size: Size) {
    let (pose, length) = (line.pose(), line.length());
    let surface = inputs.palette.hedge;
    let half = size.thickness / 2.0;
    let solid = Block {
        min: [0.0, -half, 0.0],
        max: [length, half, size.height],
    };
    cuboid(scene, Layer::Solid, surface, pose, solid);
    let spacing = if inputs.detailed {
        SECTION_M
    } else {
        TOWN_SECTION_M
    };
    let count = ((length / spacing) as usize).clamp(1, MAX_SECTIONS);
    // By place: a way has one hedge for each stretch that gates leave of it. The highest bit keeps
    // them apart from the ways themselves.
    let place = (line.start.x * 10.0) as i64 ^ ((line.start.y * 10.0) as i64) << 24;
    let mut rng = stream(inputs.seed, Purpose::Barrier, place as u64 | 1 << 63);
    let sections: Vec<Section> = (0..=count)
        .map(|i| section(pose, length * i as f64 / count as f64, size, &mut rng))
        .collect();
    for pair in sections.windows(2) {
        ribs(scene, surface, &pair[0], &pair[1]);
    }
    end(scene, surface, &sections[0], true);
    end(scene, surface, &sections[count], false);
}

fn section(pose: Pose2, run: f64, size: Size, rng: &mut Pcg64Mcg) -> Section {
    let half = size.thickness / 2.0;
    let corners = PROFILE.map(|ProfileCorner { side, up }| {
        let p = pose.transform(run, side * half + dent(rng));
        at(
            p,
            // The foot stays on the ground.
            if up > 0.0 {
                up * size.height + dent(rng)
            } else {
                0.0
            },
        )
    });
    Section { run, corners }
}

fn dent(rng: &mut Pcg64Mcg) -> f64 {
    between(rng, -DENT_M, DENT_M)
}

/// The surface between two cross sections.
fn ribs(scene: &mut SceneBuilder, surface: Surface, first: &Section, second: &Section) {
    let tile = |v: f64| (v / surface.tile) as f32;
    // The image runs along the hedge and around its cross section, in metres both ways.
    let mut around = 0.0;
    let mut corners: Vec<Corner> = Vec::with_capacity(2 * CORNERS);
    for k in 0..CORNERS {
        around += if k > 0 {
            (first.corners[k] - first.corners[k - 1]).norm()
        } else {
            0.0
        };
        let v = tile(around);
        corners.push(Corner::new(first.corners[k], [tile(first.run), v]));
        corners.push(Corner::new(second.corners[k], [tile(second.run), v]));
    }
    let faces: Vec<[u32; 3]> = (0..CORNERS as u32 - 1)
        .flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]])
        .collect();
    scene.mesh(Layer::Visible, surface.material, &corners, &faces);
}

/// The face that closes a hedge at its first or last cross section.
fn end(scene: &mut SceneBuilder, surface: Surface, section: &Section, is_first: bool) {
    let origin = section.corners[0];
    let uv = |p: &Point3<f64>| {
        let run = ((p.x - origin.x).powi(2) + (p.y - origin.y).powi(2)).sqrt();
        [(run / surface.tile) as f32, (p.z / surface.tile) as f32]
    };
    let corners: Vec<Corner> = section
        .corners
        .iter()
        .map(|p| Corner::new(*p, uv(p)))
        .collect();
    let faces = (2..CORNERS as u32).map(|i| {
        if is_first {
            [0, i - 1, i]
        } else {
            [0, i, i - 1]
        }
    });
    scene.mesh(
        Layer::Visible,
        surface.material,
        &corners,
        &faces.collect::<Vec<_>>(),
    );
}
