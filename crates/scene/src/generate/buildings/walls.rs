//! The straight walls of a building.

use openbench_core::MapPoint;
use openbench_geometry::{Segment, sides};
use openbench_osm::Building;

/// A corner this near to the line between its neighbours is no corner, metres.
const STRAIGHT_M: f64 = 0.05;

/// The walls of a building, the building on the left of each: an entrance node in a wall does not
/// divide it.
pub(crate) fn walls(building: &Building) -> Vec<Segment> {
    let rings = building.polygon.rings().map(straightened);
    rings
        .flat_map(|ring| sides(&ring).collect::<Vec<_>>())
        .collect()
}

/// A ring without the corners at which it does not bend.
pub(super) fn straightened(ring: &[MapPoint]) -> Vec<MapPoint> {
    let mut kept = ring.to_vec();
    let mut i = 0;
    // A ring keeps three corners at least.
    while i < kept.len() && kept.len() > 3 {
        let n = kept.len();
        let neighbours = Segment::new(kept[(i + n - 1) % n], kept[(i + 1) % n]);
        if neighbours.distance_to_point(kept[i]) < STRAIGHT_M {
            kept.remove(i);
        } else {
            i += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_in_a_straight_wall_is_no_corner() {
        let ring = [(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)];
        let ring = ring.map(|(x, y)| MapPoint::new(x, y));
        assert_eq!(straightened(&ring), [ring[0], ring[2], ring[3], ring[4]]);
    }
}
