//! Whether a point is inside a polygon.

use openbench_core::MapPoint;

use super::shape::Polygon;
use crate::segment::Segment;

impl Polygon {
    /// Whether `point` is inside the outline and in no hole. On the boundary the answer may be
    /// either.
    ///
    /// A ray to the east is followed, and the sides that it crosses are counted.
    pub fn contains(&self, point: MapPoint) -> bool {
        // Sides of holes count like those of the outline: a point in a hole crosses an even number.
        self.sides()
            .filter(|side| crosses_ray(*side, point))
            .count()
            % 2
            == 1
    }
}

/// Whether a ray from `point` to the east crosses the side. Each end belongs to one side only.
fn crosses_ray(side: Segment, point: MapPoint) -> bool {
    let Segment { start: a, end: b } = side;
    // The first comparison also keeps level sides out, which the division could not take.
    (a.y > point.y) != (b.y > point.y)
        && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
}

#[cfg(test)]
mod tests {
    use openbench_core::MapPoint;

    use super::super::shape::courtyard_house;

    #[test]
    fn a_courtyard_is_outside() {
        let house = courtyard_house();
        assert!(house.contains(MapPoint::new(1.0, 1.0)));
        assert!(!house.contains(MapPoint::new(5.0, 3.0)));
        assert!(!house.contains(MapPoint::new(-1.0, 3.0)));
    }
}
