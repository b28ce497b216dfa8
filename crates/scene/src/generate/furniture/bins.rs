//! Wheelie bins at the walls of houses, clear of doors, paths and roads.

use openbench_core::Pose2;
use rand_pcg::Pcg64Mcg;

use crate::generate::buildings::walls::walls;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{
    BARRIER, BUILDING, DOOR, OBJECT, PATH, PAVED, ROAD, START, WATER,
};
use crate::generate::layout::occupied::Occupied;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, element_number, pick, stream};
use crate::generate::shapes::{Block, cuboid};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// A larger building has its bins inside, m².
const LARGEST_BUILDING_M2: f64 = 500.0;
/// Shortest wall with bins, metres.
const SHORTEST_WALL_M: f64 = 4.0;
/// Distance of a bin's middle from the wall, metres.
const FROM_WALL_M: f64 = 0.5;
/// Distance between the middles of two bins, metres.
const SPACING_M: f64 = 0.8;

/// Builds the bins that the seed adds.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let in_the_way = DOOR | PATH | ROAD | PAVED | START | BARRIER | OBJECT | WATER;
    let buildings = inputs.map.buildings.iter();
    for building in buildings.filter(|b| b.polygon.area() < LARGEST_BUILDING_M2) {
        // The highest bit keeps bins apart from mapped furniture, which is numbered by its nodes.
        let element = element_number(building.element) | 1 << 63;
        let mut rng = stream(inputs.seed, Purpose::Furniture, element);
        let wall = pick(&mut rng, &walls(building));
        let count = 1 + usize::from(chance(&mut rng, 0.6));
        let share = between(&mut rng, 0.2, 0.8);
        if wall.length() < SHORTEST_WALL_M || !chance(&mut rng, inputs.options.planting) {
            continue;
        }
        let at_wall = wall.facing_out(share);
        let near = inputs.is_on_ground(at_wall.point());
        for i in 0..count {
            let left = SPACING_M * i as f64;
            let p = at_wall.transform(FROM_WALL_M, left);
            // Before the bin, there is room to go past.
            let passage = at_wall.transform(1.9, left);
            let free = occupied.is_free_at(p, 0.45, in_the_way)
                && occupied.is_free_at(passage, 1.0, BUILDING | BARRIER);
            if near && free && !out.is_full() {
                let pose = Pose2::new(p.x, p.y, at_wall.yaw);
                bin(&mut out.scene, &inputs.palette, pose, &mut rng);
                occupied.add_disc(p, 0.3);
            }
        }
    }
}

fn bin(scene: &mut SceneBuilder, palette: &Palette, pose: Pose2, rng: &mut Pcg64Mcg) {
    let dark = palette.dark_metal;
    scene.begin_object("bin", SemanticClass::Furniture);
    let body = pick(rng, &[dark, palette.green, dark]);
    let lid = pick(rng, &[palette.green, palette.yellow, dark, palette.metal]);
    let body_block = Block {
        min: [-0.32, -0.28, 0.08],
        max: [0.32, 0.28, 0.95],
    };
    cuboid(scene, Layer::Both, body, pose, body_block);
    let lid_block = Block {
        min: [-0.36, -0.31, 0.95],
        max: [0.36, 0.31, 1.03],
    };
    cuboid(scene, Layer::Visible, lid, pose, lid_block);
}
