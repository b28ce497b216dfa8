//! Triangulation of an outline with holes, by ear clipping. Holes are joined to the outline by
//! bridges first (Eberly, *Triangulation by Ear Clipping*, 2008). A self-crossing outline gives
//! some covering of it, never a panic.

use openbench_core::MapPoint;
use openbench_geometry::{Segment, sides, turn};

/// Rings with more corners are thinned to this many: ear clipping takes quadratic time.
const MAX_CORNERS: usize = 2_000;

/// Twice the area below which a triangle is a line, m²: a millionth of a millimetre over a metre is
/// rounding.
const LEAST_TURN_M2: f64 = 1e-9;

/// Triangles of a polygon, each counter-clockwise. `outer` is counter-clockwise, the holes
/// clockwise.
pub(crate) fn triangulate(outer: &[MapPoint], holes: &[Vec<MapPoint>]) -> Vec<[MapPoint; 3]> {
    let mut ring = thinned(outer);
    let mut rest: Vec<Vec<MapPoint>> = holes
        .iter()
        .map(|h| thinned(h))
        .filter(|h| h.len() > 2)
        .collect();
    // From the right on: a hole that is joined belongs to the ring when the next one is.
    rest.sort_by(|a, b| rightmost(b).total_cmp(&rightmost(a)));
    for hole in rest {
        // Further holes are filled rather than joined: ear clipping takes quadratic time.
        if ring.len() + hole.len() < 2 * MAX_CORNERS {
            ring = bridged(&ring, &hole);
        }
    }
    clip_ears(ring)
}

/// The largest x of a ring.
fn rightmost(ring: &[MapPoint]) -> f64 {
    ring.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max)
}

/// The ring without so many of its corners that it has no more than [`MAX_CORNERS`].
fn thinned(ring: &[MapPoint]) -> Vec<MapPoint> {
    let step = ring.len().div_ceil(MAX_CORNERS).max(1);
    ring.iter().step_by(step).copied().collect()
}

/// A line from a corner of a ring to a corner of a hole.
struct Bridge {
    /// Metres.
    length: f64,
    /// Numbers of the corners.
    in_ring: usize,
    in_hole: usize,
}

/// Bridges are tested from the shortest on, this many at most. If all of these cross something,
/// the rings cross each other, and the shortest one is taken.
const MAX_TESTED: usize = 64;

/// The ring with the hole joined to it along the shortest bridge that crosses neither.
fn bridged(ring: &[MapPoint], hole: &[MapPoint]) -> Vec<MapPoint> {
    let mut bridges: Vec<Bridge> = Vec::with_capacity(ring.len() * hole.len());
    for (in_ring, p) in ring.iter().enumerate() {
        bridges.extend(hole.iter().enumerate().map(|(in_hole, q)| Bridge {
            length: p.distance(*q),
            in_ring,
            in_hole,
        }));
    }
    bridges.sort_by(|a, b| a.length.total_cmp(&b.length));
    let is_clear = |bridge: &&Bridge| {
        let (from, to) = (ring[bridge.in_ring], hole[bridge.in_hole]);
        !crosses(ring, from, to) && !crosses(hole, from, to)
    };
    let clear = bridges.iter().take(MAX_TESTED).find(is_clear);
    let Some(bridge) = clear.or(bridges.first()) else {
        return ring.to_vec();
    };
    // Round the ring to the bridge, over it, once round the hole, and back.
    let around_hole = hole.iter().cycle().skip(bridge.in_hole);
    let mut joined = ring[..=bridge.in_ring].to_vec();
    joined.extend(around_hole.take(hole.len() + 1));
    joined.extend_from_slice(&ring[bridge.in_ring..]);
    joined
}

fn crosses(ring: &[MapPoint], p: MapPoint, q: MapPoint) -> bool {
    sides(ring).any(|side| side.crosses(Segment::new(p, q)))
}

fn clip_ears(mut ring: Vec<MapPoint>) -> Vec<[MapPoint; 3]> {
    let mut triangles = Vec::with_capacity(ring.len());
    let mut at = 0;
    let mut tried = 0;
    while ring.len() > 3 {
        let n = ring.len();
        let corner = [ring[(at + n - 1) % n], ring[at % n], ring[(at + 1) % n]];
        // From where the last ear was: one after the other, round the ring.
        if tried <= n && !is_ear(&ring, corner) {
            at = (at + 1) % n;
            tried += 1;
            continue;
        }
        // After a full turn without an ear the ring crosses itself: clip anyway, so that the loop
        // ends.
        if turn(corner[0], corner[1], corner[2]) > LEAST_TURN_M2 {
            triangles.push(corner);
        }
        ring.remove(at % n);
        at %= n - 1;
        tried = 0;
    }
    if ring.len() == 3 && turn(ring[0], ring[1], ring[2]) > LEAST_TURN_M2 {
        triangles.push([ring[0], ring[1], ring[2]]);
    }
    triangles
}

fn is_ear(ring: &[MapPoint], [a, b, c]: [MapPoint; 3]) -> bool {
    let area = turn(a, b, c);
    // A corner without area covers nothing and can always go.
    if area.abs() <= LEAST_TURN_M2 {
        return true;
    }
    let inside =
        |p: &MapPoint| turn(a, b, *p) >= 0.0 && turn(b, c, *p) >= 0.0 && turn(c, a, *p) >= 0.0;
    area > 0.0
        && !ring
            .iter()
            // By place, not by number: a bridge repeats two corners.
            .any(|p| *p != a && *p != b && *p != c && inside(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(coordinates: &[(f64, f64)]) -> Vec<MapPoint> {
        coordinates
            .iter()
            .map(|&(x, y)| MapPoint::new(x, y))
            .collect()
    }

    fn area(triangles: &[[MapPoint; 3]]) -> f64 {
        triangles
            .iter()
            .map(|[a, b, c]| turn(*a, *b, *c) / 2.0)
            .sum()
    }

    #[test]
    fn an_l_is_covered_once() {
        let ring = points(&[
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]);
        let triangles = triangulate(&ring, &[]);
        assert_eq!(triangles.len(), 4);
        assert!((area(&triangles) - 6.0).abs() < 1e-9);
    }

    #[test]
    fn a_courtyard_stays_open() {
        let ring = points(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]);
        let hole = points(&[(3.0, 3.0), (3.0, 7.0), (7.0, 7.0), (7.0, 3.0)]);
        let triangles = triangulate(&ring, &[hole]);
        assert!((area(&triangles) - 84.0).abs() < 1e-9);
        let middle = MapPoint::new(5.0, 5.0);
        let covers = |[a, b, c]: &[MapPoint; 3]| {
            turn(*a, *b, middle) > 0.0 && turn(*b, *c, middle) > 0.0 && turn(*c, *a, middle) > 0.0
        };
        assert!(!triangles.iter().any(covers));
    }

    #[test]
    fn a_bow_tie_and_a_line_end() {
        triangulate(
            &points(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)]),
            &[],
        );
        assert!(triangulate(&points(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), &[]).is_empty());
        assert!(triangulate(&[], &[]).is_empty());
    }
}
