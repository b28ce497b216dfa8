//! The directions in which edges leave and reach vertices.

use crate::geo::{Place, bearing, distance};
use crate::network::Network;

/// The direction of an edge at a vertex is measured over this length, metres.
const LOOK_M: f64 = 10.0;

/// The direction in which a directed edge leaves its first vertex, degrees clockwise from north.
pub(crate) fn leaving(network: &Network, directed: u32) -> f64 {
    let points = network.edge_points(directed / 2);
    if directed.is_multiple_of(2) {
        along(points.iter())
    } else {
        along(points.iter().rev())
    }
}

/// The direction in which a directed edge reaches its last vertex, degrees clockwise from north.
pub(crate) fn reaching(network: &Network, directed: u32) -> f64 {
    // The opposite edge leaves the vertex that this one reaches: its direction, turned round.
    (leaving(network, directed ^ 1) + 180.0) % 360.0
}

/// The direction from the first point of a line to one some metres on, degrees clockwise from
/// north; 0 if there is no point.
pub(crate) fn along(points: impl Iterator<Item = Place>) -> f64 {
    let (mut first, mut last, mut length) = (None, None, 0.0);
    for point in points {
        // `last` starts as the first point, so its distance to itself adds nothing.
        let before = *last.get_or_insert(point);
        first.get_or_insert(point);
        length += distance(before, point);
        last = Some(point);
        if length >= LOOK_M {
            break;
        }
    }
    first
        .zip(last)
        .map_or(0.0, |(first, last)| bearing(first, last))
}
