//! Lines through points: their length, and lines beside them.

use openbench_core::MapPoint;

use crate::segment::{Segment, segments};

/// Shortest length by which a direction is divided, metres: points that repeat have no direction.
const SHORTEST_M: f64 = 1e-9;
/// Bends sharper than about 120 degrees are cut: a mitre would be a long spike there.
const LEAST_MITRE: f64 = 0.5;

/// Unit normal of a segment, to its left.
#[derive(Debug, Clone, Copy)]
struct Normal {
    x: f64,
    y: f64,
}

impl Normal {
    /// Of a line of one point.
    const NORTH: Self = Self { x: 0.0, y: 1.0 };

    fn of(a: MapPoint, b: MapPoint) -> Self {
        let length = a.distance(b).max(SHORTEST_M);
        Self {
            x: -(b.y - a.y) / length,
            y: (b.x - a.x) / length,
        }
    }
}

/// Length of a line, metres.
pub fn length(line: &[MapPoint]) -> f64 {
    segments(line).map(Segment::length).sum()
}

/// The line moved `offset` metres to its left (right if negative), with mitred bends.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::line;
///
/// // The left kerb of a street of 6 m that turns from east to north.
/// let street = [(0.0, 0.0), (20.0, 0.0), (20.0, 30.0)].map(|(x, y)| MapPoint::new(x, y));
/// let kerb = line::parallel(&street, 3.0);
/// assert_eq!(kerb[1], MapPoint::new(17.0, 3.0));
/// assert_eq!(line::length(&kerb), 17.0 + 27.0);
/// ```
pub fn parallel(line: &[MapPoint], offset: f64) -> Vec<MapPoint> {
    let n = line.len();
    (0..n)
        .map(|i| {
            // Ends have one neighbour, whose normal counts twice.
            let before = (i > 0).then(|| Normal::of(line[i - 1], line[i]));
            let after = (i + 1 < n).then(|| Normal::of(line[i], line[i + 1]));
            let a = before.or(after).unwrap_or(Normal::NORTH);
            let b = after.or(before).unwrap_or(Normal::NORTH);
            // The mitre is (a + b) * offset / (1 + a . b): its share along each normal is `offset`.
            let scale = offset / (1.0 + a.x * b.x + a.y * b.y).max(LEAST_MITRE);
            MapPoint::new(
                line[i].x + (a.x + b.x) * scale,
                line[i].y + (a.y + b.y) * scale,
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bend_is_mitred() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let left = parallel(&line, 1.0);
        let expected = [(0.0, 1.0), (3.0, 1.0), (3.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        for (p, q) in left.iter().zip(expected) {
            assert!(p.distance(q) < 1e-9, "{left:?}");
        }
    }

    #[test]
    fn points_and_empty_lines_have_no_length_and_no_bends() {
        let point = MapPoint::new(2.0, 1.0);
        assert_eq!(length(&[point]), 0.0);
        assert_eq!(parallel(&[], 1.0), []);
        assert_eq!(parallel(&[point], 0.5), [MapPoint::new(2.0, 1.5)]);
    }
}
