//! Trees in woods and orchards, thin enough to drive between them.

use openbench_core::MapPoint;
use openbench_geometry::Bounds;
use openbench_osm::Tags;

use super::planting::BEYOND_BUILDINGS_M;
use super::tree;
use crate::generate::inputs::Inputs;
use crate::generate::layout::clearance::EVERYTHING;
use crate::generate::layout::occupied::Occupied;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, element_number, stream};

/// Area of one tree, m².
const AREA_OF_TREE_M2: f64 = 70.0;
/// Free radius that a tree in a wood needs, metres.
const FREE_RADIUS_M: f64 = 1.2;
/// Places that are tried at most, in all woods.
const MAX_TRIES: usize = 20_000;

/// Builds the trees of the map's woods.
pub(crate) fn build(inputs: &Inputs, occupied: &mut Occupied, out: &mut Output) {
    let mut left = MAX_TRIES;
    let extent = inputs.extent;
    for area in inputs.map.areas.iter().filter(|a| is_wood(&a.tags)) {
        if !extent.meets(area.polygon.bounds(), BEYOND_BUILDINGS_M) {
            continue;
        }
        // The highest bit keeps woods apart from single trees, which are numbered by their nodes.
        let element = element_number(area.element) | 1 << 63;
        let mut rng = stream(inputs.seed, Purpose::Tree, element);
        let conifers = if area.tags.is("leaf_type", "needleleaved") {
            0.9
        } else {
            0.2
        };
        let Bounds { low, high } = area.polygon.bounds();
        // Of a large forest only the part near the buildings is planted.
        let (low, high) = (nearby(extent, low), nearby(extent, high));
        let wanted = ((high.x - low.x) * (high.y - low.y) / AREA_OF_TREE_M2) as usize;
        for _ in 0..wanted.min(left) {
            let x = between(&mut rng, low.x, high.x);
            let p = MapPoint::new(x, between(&mut rng, low.y, high.y));
            let free =
                area.polygon.contains(p) && occupied.is_free_at(p, FREE_RADIUS_M, EVERYTHING);
            if free {
                let is_conifer = chance(&mut rng, conifers);
                tree::build(inputs, occupied, out, p, is_conifer, &mut rng);
            }
        }
        // By what was wanted, not by what grew: tries cost the time.
        left -= wanted.min(left);
    }
}

fn is_wood(tags: &Tags) -> bool {
    tags.is("natural", "wood") || tags.is("landuse", "forest") || tags.is("landuse", "orchard")
}

/// The point of the ground where trees grow that is nearest to `p`.
fn nearby(extent: Bounds, p: MapPoint) -> MapPoint {
    let Bounds { low, high } = extent.grown(BEYOND_BUILDINGS_M);
    MapPoint::new(p.x.clamp(low.x, high.x), p.y.clamp(low.y, high.y))
}
