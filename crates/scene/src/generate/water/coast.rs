//! The sea beside `natural=coastline` ways: OSM has it as a line only, with the land on its left.
//!
//! The lines are cut at a rectangle around the world and closed along its edge, as renderers do it
//! for their tiles: counter-clockwise from where a line leaves the rectangle to where the next one
//! enters. Lines that end inside are left out; islands that lie inside are holes.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_geometry::{Bounds, Polygon, segments, signed_area};
use openbench_osm::{OsmData, OsmMap};

/// Height of the sea, metres.
pub(crate) const SEA_LEVEL_M: f64 = -0.5;
/// A corner of the coast nearer than this to the one before is left out, metres; twice as much
/// where there are too many corners.
const FINEST_M: f64 = 2.0;
/// A smaller area is no sea, m²: two lines on one another enclose one.
const SMALLEST_SEA_M2: f64 = 1.0;
/// Corners of one coast at most.
const MAX_CORNERS: usize = 1_500;

/// The sea within `extent`.
pub(crate) fn sea(data: &OsmData, map: &OsmMap, extent: Bounds) -> Vec<Polygon> {
    let (mut shores, mut islands) = (Vec::new(), Vec::new());
    for line in coastlines(data) {
        // Reversed, so that the sea is on the left, as an area is of its outline.
        let points: Vec<MapPoint> = line
            .iter()
            .rev()
            .filter_map(|n| data.nodes.get(n))
            .map(|n| map.projection.to_map(n.position))
            .filter(|p| p.x.is_finite() && p.y.is_finite())
            .collect();
        let points = coarse(points, FINEST_M);
        let pieces = clipped(&points, extent);
        // A ring that reaches over the edge of the rectangle is cut like any other coast.
        let whole = line.first() == line.last() && points.iter().all(|p| extent.holds(*p, 0.0));
        if whole {
            islands.push(bounded(points));
        } else {
            shores.extend(pieces.into_iter().map(bounded));
        }
    }
    let rings = closed(shores, extent);
    rings
        .into_iter()
        .filter_map(|ring| with_islands(ring, &islands))
        .collect()
}

/// A line without corners that are closer together than `finest` metres; both ends stay.
fn coarse(line: Vec<MapPoint>, finest: f64) -> Vec<MapPoint> {
    let mut kept: Vec<MapPoint> = Vec::with_capacity(line.len());
    for (i, p) in line.iter().enumerate() {
        // The last point stays however near it is: pieces end exactly on the edge, and rings where
        // they began.
        if i + 1 == line.len() || kept.last().is_none_or(|q| q.distance(*p) >= finest) {
            kept.push(*p);
        }
    }
    kept
}

/// A piece of coast, simplified until it has no more than [`MAX_CORNERS`].
fn bounded(mut piece: Vec<MapPoint>) -> Vec<MapPoint> {
    let mut finest = FINEST_M;
    while piece.len() > MAX_CORNERS && finest < 1_000.0 {
        finest *= 2.0;
        piece = coarse(piece, finest);
    }
    piece
}

fn with_islands(ring: Vec<MapPoint>, islands: &[Vec<MapPoint>]) -> Option<Polygon> {
    let outer = Polygon::new(ring, Vec::new())?;
    let holes = islands
        .iter()
        .filter(|i| i.first().is_some_and(|p| outer.contains(*p)))
        .cloned()
        .collect();
    Polygon::new(outer.outer, holes)
}

/// Node numbers of the coastlines; ways are joined where one begins at the end of another.
fn coastlines(data: &OsmData) -> Vec<Vec<i64>> {
    let ways = data
        .ways
        .values()
        .filter(|w| w.tags.is("natural", "coastline") && w.nodes.len() > 1);
    let mut begins: BTreeMap<i64, Vec<i64>> = ways.map(|w| (w.nodes[0], w.nodes.clone())).collect();
    let ends: Vec<i64> = begins
        .values()
        .filter_map(|nodes| nodes.last().copied())
        .collect();
    // First those that follow no other, then the remaining ones: rings.
    let mut starts: Vec<i64> = begins
        .keys()
        .copied()
        .filter(|n| !ends.contains(n))
        .collect();
    starts.extend(begins.keys().copied().collect::<Vec<_>>());
    let mut lines = Vec::new();
    for start in starts {
        let Some(mut line) = begins.remove(&start) else {
            continue;
        };
        // Each way is removed when it is used, so a ring ends where it began.
        while let Some(next) = line.last().and_then(|end| begins.remove(end)) {
            line.extend_from_slice(&next[1..]);
        }
        lines.push(line);
    }
    lines
}

/// The parts of a line within the rectangle that begin and end on its edge.
fn clipped(line: &[MapPoint], extent: Bounds) -> Vec<Vec<MapPoint>> {
    let (mut pieces, mut piece): (Vec<Vec<MapPoint>>, Option<Vec<MapPoint>>) = (Vec::new(), None);
    for segment in segments(line) {
        let Some(inside) = extent.clip(segment) else {
            continue;
        };
        let part = segment.part(inside.start, inside.end);
        // The line enters here. A piece that begins inside the rectangle has no such place and is
        // dropped.
        if inside.start > 0.0 {
            piece = Some(vec![part.start]);
        }
        let Some(points) = &mut piece else { continue };
        points.push(part.end);
        if inside.end < 1.0 {
            pieces.extend(piece.take());
        }
    }
    pieces
}

/// Joins pieces along the edge of the rectangle, counter-clockwise.
fn closed(mut pieces: Vec<Vec<MapPoint>>, extent: Bounds) -> Vec<Vec<MapPoint>> {
    let mut rings = Vec::new();
    while let Some(mut ring) = pieces.pop() {
        let begin = run(ring[0], extent);
        loop {
            // The sea is on the left of its coast, so the edge of the rectangle is followed
            // counter-clockwise: to the nearest place where another piece comes in.
            let from = ring.last().map_or(0.0, |p| run(*p, extent));
            let ahead_to = |i: &usize| ahead(from, run(pieces[*i][0], extent));
            let next = (0..pieces.len()).min_by(|i, j| ahead_to(i).total_cmp(&ahead_to(j)));
            // If the ring's own beginning comes first along the edge, the ring is closed.
            let next = next.filter(|i| ahead_to(i) < ahead(from, begin));
            let to = next.map_or(begin, |i| run(pieces[i][0], extent));
            ring.extend(corners_between(from, ahead(from, to), extent));
            match next {
                Some(i) => ring.extend(pieces.swap_remove(i)),
                None => break,
            }
        }
        // A ring the wrong way round is not sea: its lines had the land on the wrong side.
        if signed_area(&ring) > SMALLEST_SEA_M2 {
            rings.push(ring);
        }
    }
    rings
}

/// The way from one position on the edge of the rectangle to another, counter-clockwise, in sides.
fn ahead(from: f64, to: f64) -> f64 {
    if to >= from {
        to - from
    } else {
        to - from + 4.0
    }
}

/// Position of a point on the edge of the rectangle, in sides: 0 to 4, counter-clockwise from the
/// south-west.
fn run(p: MapPoint, extent: Bounds) -> f64 {
    let (width, depth) = (extent.high.x - extent.low.x, extent.high.y - extent.low.y);
    let (x, y) = ((p.x - extent.low.x) / width, (p.y - extent.low.y) / depth);
    // For each side: distance from it, and the position if the point is on it.
    let sides = [(y, x), (1.0 - x, 1.0 + y), (1.0 - y, 3.0 - x), (x, 4.0 - y)];
    let nearest = sides
        .into_iter()
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    nearest.map_or(0.0, |(_, run)| run.rem_euclid(4.0))
}

/// The rectangle's corners from the position `from` on for `length` sides.
fn corners_between(from: f64, length: f64, extent: Bounds) -> Vec<MapPoint> {
    let corners = extent.corners();
    // Corner number i lies at position i, so the next one is the next whole number.
    let first = from.floor() as usize + 1;
    (first..first + 4)
        .filter(|i| *i as f64 - from < length)
        .map(|i| corners[i % 4])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: Bounds = Bounds {
        low: MapPoint { x: 0.0, y: 0.0 },
        high: MapPoint { x: 10.0, y: 10.0 },
    };

    fn points(list: &[(f64, f64)]) -> Vec<MapPoint> {
        list.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
    }

    #[test]
    fn a_coast_across_the_middle_leaves_half_to_the_sea() {
        // The sea on the left of a line to the east is in the north.
        let pieces = clipped(&points(&[(-5.0, 4.0), (15.0, 4.0)]), SQUARE);
        assert_eq!(pieces, [points(&[(0.0, 4.0), (10.0, 4.0)])]);
        let rings = closed(pieces, SQUARE);
        assert_eq!(rings.len(), 1);
        assert!((signed_area(&rings[0]) - 60.0).abs() < 1e-9);
    }

    #[test]
    fn two_coasts_enclose_a_strait() {
        let east = clipped(&points(&[(-5.0, 2.0), (15.0, 2.0)]), SQUARE);
        let west = clipped(&points(&[(15.0, 5.0), (-5.0, 5.0)]), SQUARE);
        let rings = closed([east, west].concat(), SQUARE);
        assert_eq!(rings.len(), 1);
        assert!((signed_area(&rings[0]) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn a_coast_that_ends_inside_is_left_out() {
        assert!(clipped(&points(&[(-5.0, 2.0), (5.0, 2.0)]), SQUARE).is_empty());
    }
}
