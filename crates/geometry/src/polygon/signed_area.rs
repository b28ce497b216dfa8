//! Area and orientation of a ring.

use openbench_core::MapPoint;

use crate::segment::sides;

/// The shoelace formula about the ring's first point, square metres: positive for a
/// counter-clockwise ring.
pub fn signed_area(ring: &[MapPoint]) -> f64 {
    let Some(&o) = ring.first() else { return 0.0 };
    let cross = |a: MapPoint, b: MapPoint| (a.x - o.x) * (b.y - o.y) - (b.x - o.x) * (a.y - o.y);
    sides(ring)
        .map(|side| cross(side.start, side.end))
        .sum::<f64>()
        / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counter_clockwise_is_positive() {
        let mut ring = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)].map(|(x, y)| MapPoint::new(x, y));
        assert_eq!(signed_area(&ring), 6.0);
        ring.reverse();
        assert_eq!(signed_area(&ring), -6.0);
        assert_eq!(signed_area(&[]), 0.0);
    }
}
