//! Trees that the map has as nodes.

use super::tree::{self, TREE_RADIUS_M};
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::{BUILDING, DOOR, OBJECT, START};
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, chance, stream};

/// Builds the map's trees.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let mut in_the_way = 0;
    for tree in inputs
        .features
        .iter()
        .filter(|f| f.tags.is("natural", "tree"))
    {
        let p = tree.position;
        if !inputs.is_on_ground(p) {
            continue;
        }
        if !occupied.is_free_at(p, TREE_RADIUS_M, BUILDING | DOOR | START | OBJECT) {
            in_the_way += 1;
            continue;
        }
        let mut rng = stream(inputs.seed, Purpose::Tree, tree.node as u64);
        let drawn = chance(&mut rng, 0.15);
        let leaf_type = tree.tags.get("leaf_type");
        let is_conifer = leaf_type.map_or(drawn, |kind| kind == "needleleaved");
        tree::build(inputs, occupied, out, p, is_conifer, &mut rng);
    }
    if in_the_way > 0 {
        out.warnings.push(format!(
            "{in_the_way} trees stand in buildings or in front of doors and were left out"
        ));
    }
}
