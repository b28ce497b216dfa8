//! Lines through points in `map`: points along them, parts, and points beside them.

use openbench_core::MapPoint;
use openbench_geometry::Segment;
use openbench_geometry::line::{length, parallel};

/// Shortest length by which a direction is divided, metres.
const SHORTEST_M: f64 = 1e-9;

/// The point `distance` metres along a line; its last point beyond its end.
pub(super) fn point_at(line: &[MapPoint], distance: f64) -> MapPoint {
    let mut left = distance;
    for w in line.windows(2) {
        let step = w[0].distance(w[1]);
        if left <= step {
            return towards(w[0], w[1], left);
        }
        left -= step;
    }
    line[line.len() - 1]
}

/// The line without its first `begin` and its last `end` metres.
pub(super) fn trimmed(line: &[MapPoint], begin: f64, end: f64) -> Vec<MapPoint> {
    let whole = length(line);
    let (low, high) = (begin, whole - end);
    let mut kept = vec![point_at(line, low)];
    let mut run = 0.0;
    for (i, p) in line.iter().enumerate() {
        run += if i > 0 { line[i - 1].distance(*p) } else { 0.0 };
        // A point right at a cut would leave a segment without a direction.
        if run > low + 0.01 && run < high - 0.01 {
            kept.push(*p);
        }
    }
    kept.push(point_at(line, high));
    kept
}

/// The same line with points at equal distances of about `spacing` metres; two points or more.
pub(super) fn resampled(line: &[MapPoint], spacing: f64) -> Vec<MapPoint> {
    let whole = length(line);
    // The bound keeps absurd lengths from filling memory.
    let steps = (whole / spacing).round().clamp(1.0, 100_000.0) as usize;
    let mut points = Vec::with_capacity(steps + 1);
    let (mut i, mut before) = (0, 0.0);
    for k in 0..=steps {
        let run = whole * k as f64 / steps as f64;
        // The last segment is never left, so that rounding at the end finds one.
        while i + 2 < line.len() && before + line[i].distance(line[i + 1]) < run {
            before += line[i].distance(line[i + 1]);
            i += 1;
        }
        points.push(towards(line[i], line[i + 1], run - before));
    }
    points
}

/// The line's point number `i` moved `offset` metres to the left of its neighbours' direction.
pub(super) fn offset_point(line: &[MapPoint], i: usize, offset: f64) -> MapPoint {
    // At the ends there is one neighbour only, and the point itself stands for the other.
    let (a, b) = (line[i.max(1) - 1], line[(i + 1).min(line.len() - 1)]);
    let length = a.distance(b).max(SHORTEST_M);
    MapPoint::new(
        line[i].x - (b.y - a.y) / length * offset,
        line[i].y + (b.x - a.x) / length * offset,
    )
}

/// The line with each point moved to its left by the offset with its number, metres.
pub(super) fn offset_points(line: &[MapPoint], offsets: &[f64]) -> Vec<MapPoint> {
    match offsets {
        // A line at an even distance keeps its bends mitred.
        [first, rest @ ..] if rest.iter().all(|o| o == first) => parallel(line, *first),
        _ => (0..line.len())
            .map(|i| offset_point(line, i, offsets[i]))
            .collect(),
    }
}

/// The point `distance` metres from `a` towards `b`, at most `b`.
fn towards(a: MapPoint, b: MapPoint, distance: f64) -> MapPoint {
    let share = (distance / a.distance(b).max(SHORTEST_M)).clamp(0.0, 1.0);
    Segment::new(a, b).at(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 m east, then 4 m north.
    fn corner() -> [MapPoint; 3] {
        [
            MapPoint::new(0.0, 0.0),
            MapPoint::new(3.0, 0.0),
            MapPoint::new(3.0, 4.0),
        ]
    }

    #[test]
    fn points_lie_along_the_line() {
        assert_eq!(length(&corner()), 7.0);
        assert_eq!(point_at(&corner(), 5.0), MapPoint::new(3.0, 2.0));
        assert_eq!(point_at(&corner(), 9.0), MapPoint::new(3.0, 4.0));
        let even = resampled(&corner(), 1.0);
        assert_eq!(even.len(), 8);
        assert!((even[5].y - 2.0).abs() < 1e-12, "{even:?}");
    }

    #[test]
    fn a_trimmed_line_keeps_the_bend_between_its_ends() {
        let expected = [
            MapPoint::new(1.0, 0.0),
            MapPoint::new(3.0, 0.0),
            MapPoint::new(3.0, 2.0),
        ];
        assert_eq!(trimmed(&corner(), 1.0, 2.0), expected);
    }

    #[test]
    fn points_at_an_even_distance_are_those_of_a_parallel() {
        let left = parallel(&corner(), 1.0);
        assert_eq!(offset_points(&corner(), &[1.0; 3]), left);
        assert_eq!(offset_point(&corner(), 0, 1.0), MapPoint::new(0.0, 1.0));
    }
}
