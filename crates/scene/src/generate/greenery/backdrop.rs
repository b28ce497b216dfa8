//! A belt of trees on the horizon, visible only: no robot gets there, and the free space need not
//! reach so far.

use std::f64::consts::TAU;

use openbench_geometry::sides;

use super::ball::{Ball, ball};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, ROAD, WATER};
use crate::generate::layout::extent::GROUND_MARGIN_M;
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, pick, stream};
use crate::generate::shapes::at;
use crate::material::SemanticClass;

/// Distance between the trees, metres.
const SPACING_M: f64 = 5.0;
/// Trees on one side at most.
const MOST: usize = 500;
/// Distance of the belt from the buildings, as a share of the ground's margin.
const DISTANCE: f64 = 0.8;
/// Number of the stream.
const STREAM: u64 = 1 << 41;

/// Builds the belt.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let corners = inputs.extent.grown(GROUND_MARGIN_M * DISTANCE).corners();
    let mut rng = stream(inputs.seed, Purpose::Planting, STREAM);
    for side in sides(&corners) {
        let count = ((side.length() / SPACING_M) as usize).min(MOST);
        for k in 0..count {
            let p = side.at((k as f64 + between(&mut rng, 0.0, 1.0)) / count as f64);
            let direction = between(&mut rng, 0.0, TAU);
            let p = p.offset(direction, between(&mut rng, 0.0, 10.0));
            let radius = between(&mut rng, 2.5, 4.5);
            let half_height = between(&mut rng, 3.0, 5.0);
            let core = pick(&mut rng, &inputs.palette.crowns).core;
            if !out.is_full() && occupied.is_free_at(p, radius, ROAD | BUILDING | WATER) {
                out.scene.begin_object("tree", SemanticClass::Vegetation);
                // Sunk into the ground a little, so that no trunk is needed.
                let center = at(p, half_height * 0.85);
                let crown = Ball {
                    center,
                    radius,
                    half_height,
                };
                ball(&mut out.scene, core, crown, 0, &mut rng);
            }
        }
    }
}
