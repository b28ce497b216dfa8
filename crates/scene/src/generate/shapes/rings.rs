//! Lines and closed rings moved sideways, and the area that a ring encloses.

use openbench_core::MapPoint;
use openbench_geometry::turn;

/// Unit normal of a line, to its left.
#[derive(Clone, Copy)]
struct Normal {
    x: f64,
    y: f64,
}

impl Normal {
    fn of(a: MapPoint, b: MapPoint) -> Self {
        let length = a.distance(b).max(1e-9);
        Self {
            x: -(b.y - a.y) / length,
            y: (b.x - a.x) / length,
        }
    }
}

/// The line moved `offset` metres to its left (right if negative), mitred. Bends sharper than about
/// 120 degrees are cut.
pub(crate) fn parallel(line: &[MapPoint], offset: f64) -> Vec<MapPoint> {
    let n = line.len();
    (0..n)
        .map(|i| {
            let before = (i > 0).then(|| Normal::of(line[i - 1], line[i]));
            let after = (i + 1 < n).then(|| Normal::of(line[i], line[i + 1]));
            let none = Normal { x: 0.0, y: 1.0 };
            let a = before.or(after).unwrap_or(none);
            let b = after.or(before).unwrap_or(none);
            let scale = offset / (1.0 + a.x * b.x + a.y * b.y).max(0.5);
            MapPoint::new(
                line[i].x + (a.x + b.x) * scale,
                line[i].y + (a.y + b.y) * scale,
            )
        })
        .collect()
}

/// A closed ring moved `inset` metres to its left: inwards for an outline, outwards for a hole seen
/// from the building. `None` if an edge would be reversed.
pub(crate) fn inset(ring: &[MapPoint], inset: f64) -> Option<Vec<MapPoint>> {
    let n = ring.len();
    if n < 3 {
        return None;
    }
    let padded: Vec<MapPoint> = (0..n + 2).map(|i| ring[(i + n - 1) % n]).collect();
    let moved = parallel(&padded, inset)[1..=n].to_vec();
    let keeps_direction = |i: usize| {
        let (a, b, p, q) = (ring[i], ring[(i + 1) % n], moved[i], moved[(i + 1) % n]);
        (b.x - a.x) * (q.x - p.x) + (b.y - a.y) * (q.y - p.y) > 0.0
    };
    (0..n).all(keeps_direction).then_some(moved)
}

/// Sum of signed areas about the origin, m²; positive for a counter-clockwise ring.
pub(crate) fn signed_area(ring: &[MapPoint]) -> f64 {
    let origin = MapPoint::default();
    (0..ring.len())
        .map(|i| turn(origin, ring[i], ring[(i + 1) % ring.len()]) / 2.0)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_shrinks_until_an_edge_is_reversed() {
        let square =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let smaller = inset(&square, 1.0).unwrap();
        assert!((signed_area(&smaller) - 4.0).abs() < 1e-9);
        assert_eq!(inset(&square, 2.5), None);
    }

    #[test]
    fn a_bend_is_mitred() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let left = parallel(&line, 1.0);
        assert!(left[1].distance(MapPoint::new(3.0, 1.0)) < 1e-9);
    }
}
