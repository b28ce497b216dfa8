//! Centre of mass of a polygon.

use openbench_core::MapPoint;

use super::shape::Polygon;
use crate::segment::Segment;

impl Polygon {
    /// Centre of mass. It may be outside of a polygon that is concave or has holes.
    pub fn centroid(&self) -> MapPoint {
        // Relative to a corner, so that large coordinates cost no digits.
        let Some(&origin) = self.outer.first() else {
            return MapPoint::default();
        };
        let (mut x, mut y, mut twice) = (0.0, 0.0, 0.0);
        for Segment { start: a, end: b } in self.sides() {
            let (ax, ay) = (a.x - origin.x, a.y - origin.y);
            let (bx, by) = (b.x - origin.x, b.y - origin.y);
            // The triangle of the origin and the side: `cross` is twice its area, and its centroid
            // is a third of the sum of its corners. Holes are clockwise and count negative.
            let cross = ax * by - bx * ay;
            x += (ax + bx) * cross;
            y += (ay + by) * cross;
            twice += cross;
        }
        if twice == 0.0 {
            return origin;
        }
        MapPoint::new(origin.x + x / (3.0 * twice), origin.y + y / (3.0 * twice))
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::MapPoint;

    use super::super::shape::courtyard_house;

    #[test]
    fn a_symmetric_house_has_its_centroid_in_the_middle() {
        assert_eq!(courtyard_house().centroid(), MapPoint::new(5.0, 3.0));
    }
}
