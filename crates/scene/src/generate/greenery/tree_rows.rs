//! Trees along `natural=tree_row`.

use openbench_geometry::segments;

use super::tree::{self, TREE_RADIUS_M};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, DOOR, OBJECT, ROAD, START};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, chance, stream};

/// Distance between the trees of a row, metres.
const SPACING_M: f64 = 8.0;
/// Trees along one segment at most.
const MOST: usize = 500;

/// Builds the map's rows of trees.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let in_the_way = BUILDING | DOOR | START | OBJECT | ROAD;
    for row in &inputs.tree_rows {
        // The bit keeps rows apart from single trees and from woods, which have the highest.
        let mut rng = stream(inputs.seed, Purpose::Tree, row.way as u64 | 1 << 62);
        let is_conifer = chance(&mut rng, 0.1);
        for segment in segments(&row.line) {
            let count = ((segment.length() / SPACING_M).ceil() as usize).min(MOST);
            for i in 0..count {
                let p = segment.at((i as f64 + 0.5) / count as f64);
                let near = inputs.is_on_ground(p);
                if near && occupied.is_free_at(p, TREE_RADIUS_M, in_the_way) {
                    tree::build(inputs, occupied, out, p, is_conifer, &mut rng);
                }
            }
        }
    }
}
