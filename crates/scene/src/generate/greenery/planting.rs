//! Trees that the seed adds where nothing else is.

use openbench_core::MapPoint;
use openbench_geometry::Bounds;

use super::tree;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, EVERYTHING, OBJECT};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, stream};

/// Distance from the buildings up to which trees are added, metres.
pub(super) const BEYOND_BUILDINGS_M: f64 = 32.0;
/// Area of one tree where all greenery is planted, m².
const AREA_OF_TREE_M2: f64 = 220.0;
/// Trees at most.
const MOST: usize = 3_000;

/// Builds the trees that the seed adds.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let Bounds { low, high } = inputs.extent;
    let width = high.x - low.x + 2.0 * BEYOND_BUILDINGS_M;
    let depth = high.y - low.y + 2.0 * BEYOND_BUILDINGS_M;
    let share = inputs.options.planting.clamp(0.0, 1.0);
    let wanted = (width * depth / AREA_OF_TREE_M2 * share) as usize;
    let mut rng = stream(inputs.seed, Purpose::Planting, 0);
    let Bounds { low, high } = inputs.extent.grown(BEYOND_BUILDINGS_M);
    for i in 0..wanted.min(MOST) {
        let x = between(&mut rng, low.x, high.x);
        let p = MapPoint::new(x, between(&mut rng, low.y, high.y));
        // The crown stays clear of buildings and other trees, the trunk of everything else.
        let free = occupied.is_free_at(p, 2.6, BUILDING | OBJECT)
            && occupied.is_free_at(p, 1.0, EVERYTHING);
        if free {
            // A stream for each tree: places where none fits do not change the others.
            let mut own = stream(inputs.seed, Purpose::Planting, 1 + i as u64);
            let is_conifer = chance(&mut own, 0.2);
            tree::build(inputs, occupied, out, p, is_conifer, &mut own);
        }
    }
}
