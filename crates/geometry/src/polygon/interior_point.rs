//! A point inside a polygon, away from its boundary.

use openbench_core::MapPoint;

use super::shape::Polygon;
use crate::segment::Segment;

/// The polygon is cut by this many horizontal lines less one, evenly spaced.
const CUTS: i32 = 8;

impl Polygon {
    /// A point inside, away from the boundary. Candidates are the centroid and the middles of the
    /// longest stretches on some horizontal lines; the one farthest from the boundary is returned.
    pub fn interior_point(&self) -> MapPoint {
        let centroid = self.centroid();
        let bounds = self.bounds();
        let height = bounds.high.y - bounds.low.y;
        let levels = (1..CUTS).map(|i| bounds.low.y + height * f64::from(i) / f64::from(CUTS));
        let cuts = levels.filter_map(|y| self.widest_cut(y));
        // The centroid of a concave polygon may be outside.
        let inside = std::iter::once(centroid)
            .chain(cuts)
            .filter(|p| self.contains(*p));
        inside
            .map(|point| (self.distance_to_boundary(point), point))
            .reduce(|a, b| if b.0 > a.0 { b } else { a })
            .map_or(centroid, |(_, point)| point)
    }

    /// The middle of the longest stretch inside the polygon on the horizontal line through `y`.
    fn widest_cut(&self, y: f64) -> Option<MapPoint> {
        let mut xs: Vec<f64> = self.sides().filter_map(|side| crossing(side, y)).collect();
        xs.sort_by(f64::total_cmp);
        // Crossings in ascending order lead in and out in turn, so each pair bounds a stretch
        // inside.
        let stretches = xs
            .chunks_exact(2)
            .map(|ends| (ends[1] - ends[0], (ends[0] + ends[1]) / 2.0));
        let (_, middle) = stretches.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        Some(MapPoint::new(middle, y))
    }
}

/// The x coordinate at which a side crosses the horizontal line through `y`.
fn crossing(side: Segment, y: f64) -> Option<f64> {
    let Segment { start: a, end: b } = side;
    let crosses = (a.y > y) != (b.y > y);
    crosses.then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
}

#[cfg(test)]
mod tests {
    use super::super::shape::courtyard_house;

    #[test]
    fn the_point_is_not_in_a_courtyard() {
        let house = courtyard_house();
        let point = house.interior_point();
        assert!(house.contains(point));
        assert!(house.distance_to_boundary(point) > 1.0);
    }
}
