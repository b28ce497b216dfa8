//! Closed rings moved inwards.

use openbench_core::MapPoint;
use openbench_geometry::line::parallel;

/// A closed ring moved `inset` metres to its left: inwards for an outline, outwards for a hole seen
/// from the building. `None` if an edge would be reversed.
pub(crate) fn inset(ring: &[MapPoint], inset: f64) -> Option<Vec<MapPoint>> {
    let n = ring.len();
    if n < 3 {
        return None;
    }
    // `parallel` takes an open line: with one corner more at both ends, all real corners are bends.
    let padded: Vec<MapPoint> = (0..n + 2).map(|i| ring[(i + n - 1) % n]).collect();
    let moved = parallel(&padded, inset)[1..=n].to_vec();
    // An edge that is shorter than the mitres at its ends would run backwards.
    let keeps_direction = |i: usize| {
        let (a, b, p, q) = (ring[i], ring[(i + 1) % n], moved[i], moved[(i + 1) % n]);
        (b.x - a.x) * (q.x - p.x) + (b.y - a.y) * (q.y - p.y) > 0.0
    };
    (0..n).all(keeps_direction).then_some(moved)
}

#[cfg(test)]
mod tests {
    use openbench_geometry::signed_area;

    use super::*;

    #[test]
    fn a_square_shrinks_until_an_edge_is_reversed() {
        let square =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| MapPoint::new(x, y));
        let smaller = inset(&square, 1.0).unwrap();
        assert!((signed_area(&smaller) - 4.0).abs() < 1e-9);
        assert_eq!(inset(&square, 2.5), None);
    }
}
