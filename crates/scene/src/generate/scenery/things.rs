//! What things in the way look like. Robots meet boxes of about their size.

use std::f64::consts::FRAC_PI_2;

use openbench_core::Pose2;
use rand_pcg::Pcg64Mcg;

use super::bars::{Wheel, bar, placed, wheel};
use super::kinds::{Half, Kind, Thing};
use crate::generate::greenery::ball::{Ball, ball};
use crate::generate::materials::palette::Palette;
use crate::generate::seeds::{between, pick};
use crate::generate::shapes::{Block, Frustum, Surface, at, cuboid, frustum};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// Distance between the middles of bins side by side, metres.
const BIN_SPACING_M: f64 = 0.66;
/// Distance between bicycles in a rack, metres.
const RACK_SPACING_M: f64 = 0.56;
/// Radius of a bicycle's wheels, metres.
const BICYCLE_WHEEL_M: f64 = 0.33;

/// A thing under construction. Its pose faces out of the wall.
pub(super) struct Piece<'a> {
    pub scene: &'a mut SceneBuilder,
    pub palette: &'a Palette,
    pub pose: Pose2,
    pub rng: &'a mut Pcg64Mcg,
}

/// Builds a thing.
pub(super) fn build(piece: &mut Piece, thing: &Thing) {
    piece
        .scene
        .begin_object(thing.kind.name(), SemanticClass::Furniture);
    match thing.kind {
        Kind::Bins => bins(piece, thing.count),
        Kind::Bicycle => bicycle(piece, FRAC_PI_2, 0.0),
        Kind::Rack => rack(piece, thing.count),
        Kind::Planter => planter(piece, thing),
        Kind::TallPlant => tall_plant(piece, thing.height),
        Kind::Bench => bench(piece),
        Kind::Board => board(piece, thing.height),
        Kind::Scooter => scooter(piece),
        Kind::Pallets => pallets(piece, thing.count * 2),
        Kind::Rubble => rubble(piece, thing),
        Kind::Boxes => boxes(piece, thing.count),
    }
}

impl Piece<'_> {
    fn block(&mut self, layer: Layer, surface: Surface, min: [f64; 3], max: [f64; 3]) {
        cuboid(self.scene, layer, surface, self.pose, Block { min, max });
    }

    fn bar(&mut self, surface: Surface, from: [f64; 3], to: [f64; 3], thickness: f64) {
        let (a, b) = (placed(self.pose, from), placed(self.pose, to));
        bar(self.scene, surface, a, b, thickness);
    }

    /// The pose turned about a point of it.
    fn turned(&self, forward: f64, left: f64, turn: f64) -> Pose2 {
        let p = self.pose.transform(forward, left);
        Pose2::new(p.x, p.y, self.pose.yaw + turn)
    }
}

fn bins(piece: &mut Piece, count: usize) {
    let (dark, green) = (piece.palette.dark_metal, piece.palette.green);
    let lids = [green, piece.palette.yellow, dark, piece.palette.metal];
    for i in 0..count {
        let left = BIN_SPACING_M * (i as f64 - (count as f64 - 1.0) / 2.0);
        let body = pick(piece.rng, &[dark, green, dark]);
        let lid = pick(piece.rng, &lids);
        // As somebody left it.
        let turn = between(piece.rng, -0.12, 0.12);
        let pose = piece.turned(0.0, left, turn);
        let parts = [
            (Layer::Both, body, [-0.3, -0.27, 0.06], [0.3, 0.27, 0.95]),
            (
                Layer::Visible,
                lid,
                [-0.34, -0.29, 0.95],
                [0.34, 0.29, 1.03],
            ),
        ];
        for (layer, surface, min, max) in parts {
            cuboid(piece.scene, layer, surface, pose, Block { min, max });
        }
    }
}

/// A bicycle, turned from the piece's pose, so far to its left.
fn bicycle(piece: &mut Piece, turn: f64, left: f64) {
    let pose = piece.turned(0.0, left, turn);
    let palette = piece.palette;
    let frames = [
        palette.red,
        palette.dark_metal,
        palette.green,
        palette.metal,
        palette.yellow,
    ];
    let frame = pick(piece.rng, &frames);
    let mut own = Piece {
        scene: &mut *piece.scene,
        palette,
        pose,
        rng: &mut *piece.rng,
    };
    let (front, rear, up) = (0.53, -0.53, BICYCLE_WHEEL_M);
    for x in [front, rear] {
        let tyre = Wheel {
            middle: [x, 0.0, up],
            radius: BICYCLE_WHEEL_M,
        };
        wheel(own.scene, palette.dark_metal, pose, tyre);
    }
    let (crank, saddle, head) = ([-0.08, 0.0, 0.28], [-0.24, 0.0, 0.84], [0.36, 0.0, 0.86]);
    let tubes = [
        (crank, saddle),
        (crank, head),
        ([-0.2, 0.0, 0.74], [0.36, 0.0, 0.78]),
        ([rear, 0.0, up], crank),
        ([rear, 0.0, up], [-0.2, 0.0, 0.74]),
        ([front, 0.0, up], head),
    ];
    for (from, to) in tubes {
        own.bar(frame, from, to, 0.035);
    }
    let dark = palette.dark_metal;
    own.bar(dark, head, [0.34, 0.0, 0.98], 0.03);
    own.bar(dark, [0.32, -0.28, 1.0], [0.32, 0.28, 1.0], 0.03);
    own.block(
        Layer::Visible,
        dark,
        [-0.36, -0.07, 0.84],
        [-0.1, 0.07, 0.9],
    );
    own.block(Layer::Solid, dark, [-0.84, -0.06, 0.0], [0.84, 0.06, 0.9]);
}

fn rack(piece: &mut Piece, count: usize) {
    let metal = piece.palette.metal;
    let half = RACK_SPACING_M * count as f64 / 2.0;
    piece.block(Layer::Both, metal, [-0.62, -half, 0.0], [-0.58, half, 0.3]);
    for i in 0..count {
        let left = RACK_SPACING_M * (i as f64 - (count as f64 - 1.0) / 2.0);
        let turn = between(piece.rng, -0.06, 0.06);
        bicycle(piece, turn, left);
    }
}

fn planter(piece: &mut Piece, thing: &Thing) {
    let Half { along, out } = thing.half;
    let palette = piece.palette;
    let box_of = pick(
        piece.rng,
        &[
            palette.wood,
            palette.metal,
            palette.kerbstone,
            palette.doorstep,
        ],
    );
    let height = thing.height * 0.7;
    piece.block(
        Layer::Both,
        box_of,
        [-out, -along, 0.0],
        [out, along, height],
    );
    let plants = [
        pick(piece.rng, &palette.flowers),
        pick(piece.rng, &palette.needles),
        palette.hedge,
    ];
    let leaves = pick(piece.rng, &plants);
    piece.scene.begin_object("shrub", SemanticClass::Vegetation);
    for side in [-0.5, 0.5] {
        let crown = Ball {
            center: at(piece.pose.transform(0.0, side * along), height + 0.12),
            radius: out.min(along) * 1.05,
            half_height: 0.22 + 0.2 * thing.height,
        };
        ball(piece.scene, leaves, crown, 0, piece.rng);
    }
}

fn tall_plant(piece: &mut Piece, height: f64) {
    let palette = piece.palette;
    let pot = Frustum {
        center: piece.pose.point(),
        sides: 8,
        z: 0.0..0.4,
        radii: [0.17, 0.24],
    };
    let clay = pick(
        piece.rng,
        &[palette.path, palette.doorstep, palette.dark_metal],
    );
    frustum(piece.scene, Layer::Both, clay, pot);
    let leaves = [palette.hedge, palette.needles[0], palette.crowns[0].core];
    let leaves = pick(piece.rng, &leaves);
    piece.scene.begin_object("shrub", SemanticClass::Vegetation);
    // One ball over the other, the upper one narrower: a clipped laurel.
    for (share, radius) in [(0.42, 0.30), (0.74, 0.26)] {
        let crown = Ball {
            center: at(piece.pose.point(), height * share + 0.15),
            radius,
            half_height: height * 0.24,
        };
        ball(piece.scene, leaves, crown, 1, piece.rng);
    }
}

fn bench(piece: &mut Piece) {
    let (wood, metal) = (piece.palette.wood, piece.palette.dark_metal);
    for x in [-0.12, 0.06, 0.22] {
        let (min, max) = ([x - 0.07, -0.75, 0.42], [x + 0.07, 0.75, 0.46]);
        piece.block(Layer::Both, wood, min, max);
    }
    for z in [0.58, 0.74] {
        piece.block(
            Layer::Both,
            wood,
            [-0.26, -0.75, z],
            [-0.22, 0.75, z + 0.12],
        );
    }
    for y in [-0.6, 0.55] {
        piece.block(Layer::Both, metal, [-0.24, y, 0.0], [0.26, y + 0.06, 0.42]);
        piece.block(
            Layer::Visible,
            metal,
            [-0.24, y, 0.42],
            [-0.2, y + 0.06, 0.86],
        );
    }
}

fn board(piece: &mut Piece, height: f64) {
    let palette = piece.palette;
    let colors = [palette.dark_metal, palette.wood, palette.green, palette.red];
    let face = pick(piece.rng, &colors);
    for side in [-1.0, 1.0] {
        // Two leaves that lean against each other, each of five strips.
        for strip in 0..5 {
            let left = 0.1 * f64::from(strip) - 0.2;
            let (foot, top) = ([side * 0.26, left, 0.04], [side * 0.02, left, height]);
            piece.bar(face, foot, top, 0.098);
        }
    }
    let (min, max) = ([-0.26, -0.26, 0.0], [0.26, 0.26, 0.4]);
    piece.block(Layer::Solid, face, min, max);
}

fn scooter(piece: &mut Piece) {
    let palette = piece.palette;
    let (dark, paint) = (
        palette.dark_metal,
        pick(piece.rng, &[palette.green, palette.yellow]),
    );
    let turn = FRAC_PI_2 + between(piece.rng, -0.25, 0.25);
    let pose = piece.turned(0.0, 0.0, turn);
    let mut own = Piece {
        scene: &mut *piece.scene,
        palette,
        pose,
        rng: &mut *piece.rng,
    };
    for x in [0.46, -0.46] {
        let tyre = Wheel {
            middle: [x, 0.0, 0.11],
            radius: 0.11,
        };
        wheel(own.scene, dark, pose, tyre);
    }
    own.block(Layer::Both, paint, [-0.42, -0.09, 0.1], [0.36, 0.09, 0.17]);
    own.bar(paint, [0.46, 0.0, 0.14], [0.34, 0.0, 1.1], 0.06);
    own.bar(dark, [0.34, -0.25, 1.12], [0.34, 0.25, 1.12], 0.035);
    own.block(Layer::Solid, dark, [0.3, -0.08, 0.0], [0.52, 0.08, 1.1]);
}

fn pallets(piece: &mut Piece, count: usize) {
    let wood = piece.palette.wood;
    for i in 0..count {
        let z = 0.144 * i as f64;
        // Three runners below, a deck above.
        for y in [-0.53, 0.0, 0.53] {
            let (min, max) = ([-0.38, y - 0.05, z], [0.38, y + 0.05, z + 0.1]);
            piece.block(Layer::Visible, wood, min, max);
        }
        let (min, max) = ([-0.4, -0.6, z + 0.1], [0.4, 0.6, z + 0.14]);
        piece.block(Layer::Visible, wood, min, max);
    }
    let top = 0.144 * count as f64;
    piece.block(Layer::Solid, wood, [-0.4, -0.6, 0.0], [0.4, 0.6, top]);
}

fn rubble(piece: &mut Piece, thing: &Thing) {
    let Half { along, out } = thing.half;
    let palette = piece.palette;
    let stones = [
        palette.kerbstone,
        palette.doorstep,
        palette.path,
        palette.quay,
    ];
    let heap = Ball {
        center: at(piece.pose.point(), 0.0),
        radius: out * 0.85,
        half_height: thing.height * 0.8,
    };
    ball(piece.scene, palette.gravel, heap, 1, piece.rng);
    for _ in 0..thing.count {
        let (x, y) = (between(piece.rng, -0.5, 0.5), between(piece.rng, -0.6, 0.6));
        let size = between(piece.rng, 0.08, 0.16);
        let stone = pick(piece.rng, &stones);
        let turn = between(piece.rng, 0.0, FRAC_PI_2);
        let pose = piece.turned(x * out, y * along, turn);
        // Higher near the middle, where they lie on the heap.
        let top = size + thing.height * 0.8 * (1.0 - x.abs() - y.abs()).max(0.0);
        let block = Block {
            min: [-size, -size * 0.6, 0.0],
            max: [size, size * 0.6, top],
        };
        cuboid(piece.scene, Layer::Both, stone, pose, block);
    }
    let solid = [out * 0.6, along * 0.6];
    let (min, max) = (
        [-solid[0], -solid[1], 0.0],
        [solid[0], solid[1], thing.height * 0.6],
    );
    piece.block(Layer::Solid, palette.gravel, min, max);
}

fn boxes(piece: &mut Piece, count: usize) {
    let wood = piece.palette.wood;
    for i in 0..count {
        let left = 0.24 * (i as f64 - (count as f64 - 1.0) / 2.0);
        let turn = between(piece.rng, -0.2, 0.2);
        let height = between(piece.rng, 0.18, 0.5);
        let forward = between(piece.rng, -0.08, 0.08);
        let pose = piece.turned(forward, left, turn);
        let block = Block {
            min: [-0.16, -0.11, 0.0],
            max: [0.16, 0.11, height],
        };
        cuboid(piece.scene, Layer::Both, wood, pose, block);
    }
}
