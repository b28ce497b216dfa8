//! Rounded bushes along the walls of houses, away from doors and ways.

use openbench_core::MapPoint;
use rand_pcg::Pcg64Mcg;

use super::ball::{Ball, ball};
use crate::generate::buildings::walls::walls;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BARRIER, BUILDING, DOOR, PATH, PAVED, ROAD, START};
use crate::generate::layout::occupied::Occupied;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, pick, stream};
use crate::generate::shapes::{Frustum, at, frustum};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};

/// Distance between the places of shrubs along a wall, metres.
const SPACING_M: f64 = 1.6;
/// Shrubs along one wall at most.
const MOST: usize = 100;
/// Share of the places with a shrub where all greenery is planted.
const SHARE: f64 = 0.45;
/// Numbers of the streams of shrubs begin here.
const FIRST_STREAM: u64 = 1 << 40;

/// Builds the shrubs that the seed adds.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let in_the_way = DOOR | PATH | ROAD | PAVED | START | BARRIER;
    for (index, building) in inputs.map.buildings.iter().enumerate() {
        if out.is_full() {
            break;
        }
        let mut rng = stream(inputs.seed, Purpose::Planting, FIRST_STREAM + index as u64);
        for wall in walls(building) {
            let (length, outward) = (wall.length(), wall.outward());
            for i in 0..((length / SPACING_M) as usize).min(MOST) {
                let along = (i as f64 + between(&mut rng, 0.3, 0.7)) * SPACING_M / length;
                let foot = wall.at(along);
                let radius = between(&mut rng, 0.3, 0.45);
                let wanted = chance(&mut rng, SHARE * inputs.options.planting);
                let p = foot.offset(outward, radius + 0.08);
                // Before the shrub, there is room to go past.
                let passage = foot.offset(outward, 2.2);
                let free = wanted
                    && occupied.is_free_at(p, radius + 0.3, in_the_way)
                    && occupied.is_free_at(passage, 1.1, BUILDING | BARRIER);
                if free {
                    shrub(&mut out.scene, &inputs.palette, p, radius, &mut rng);
                    occupied.add_disc(p, radius);
                }
            }
        }
    }
}

fn shrub(
    scene: &mut SceneBuilder,
    palette: &Palette,
    p: MapPoint,
    radius: f64,
    rng: &mut Pcg64Mcg,
) {
    let surface = match between(rng, 0.0, 1.0) {
        kind if kind < 0.25 => pick(rng, &palette.needles),
        kind if kind < 0.55 => pick(rng, &palette.flowers),
        _ => palette.hedge,
    };
    scene.begin_object("shrub", SemanticClass::Vegetation);
    let height = radius * between(rng, 1.4, 2.2);
    let crown = Ball {
        center: at(p, height * 0.45),
        radius,
        half_height: height * 0.55,
    };
    ball(scene, surface, crown, 0, rng);
    let solid = Frustum {
        center: p,
        sides: 6,
        z: 0.0..height * 0.8,
        radii: [radius * 0.8, radius * 0.7],
    };
    frustum(scene, Layer::Solid, surface, solid);
}
