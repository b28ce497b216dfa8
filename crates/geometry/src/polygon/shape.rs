//! An outline with holes.

use openbench_core::MapPoint;

use super::ring::{Orientation, oriented};
use crate::segment::{Segment, sides};

/// An area in the `map` frame. No ring repeats its first point at its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polygon {
    /// The outer ring, counter-clockwise.
    pub outer: Vec<MapPoint>,
    /// The holes, each clockwise: the area is to the left of every side.
    pub holes: Vec<Vec<MapPoint>>,
}

impl Polygon {
    /// A polygon from rings of any orientation. Repeated points are dropped, and so are holes
    /// without area; `None` if the outer ring encloses no area.
    ///
    /// ```
    /// use openbench_core::MapPoint;
    /// use openbench_geometry::Polygon;
    ///
    /// // A house of 10 m by 6 m, closed as OSM closes its ways.
    /// let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 6.0), (0.0, 6.0), (0.0, 0.0)];
    /// let outline = corners.map(|(x, y)| MapPoint::new(x, y)).to_vec();
    /// let house = Polygon::new(outline, Vec::new()).unwrap();
    /// assert_eq!(house.area(), 60.0);
    /// assert!(house.contains(MapPoint::new(5.0, 3.0)));
    /// // Someone in front of the south wall: the nearest point of the wall, which faces south.
    /// let wall = house.nearest_boundary_point(MapPoint::new(5.0, -2.0));
    /// assert_eq!(wall.point, MapPoint::new(5.0, 0.0));
    /// assert_eq!(wall.normal, -std::f64::consts::FRAC_PI_2);
    /// ```
    pub fn new(outer: Vec<MapPoint>, holes: Vec<Vec<MapPoint>>) -> Option<Self> {
        let outer = oriented(outer, Orientation::CounterClockwise)?;
        let holes = holes
            .into_iter()
            .filter_map(|hole| oriented(hole, Orientation::Clockwise));
        Some(Self {
            outer,
            holes: holes.collect(),
        })
    }

    /// The same so many metres further east and north.
    #[must_use]
    pub fn moved(&self, by: MapPoint) -> Self {
        let moved = |ring: &Vec<MapPoint>| {
            let corners = ring.iter();
            corners
                .map(|at| MapPoint::new(at.x + by.x, at.y + by.y))
                .collect()
        };
        Self {
            outer: moved(&self.outer),
            holes: self.holes.iter().map(moved).collect(),
        }
    }

    /// The outer ring, then the holes.
    #[inline]
    pub fn rings(&self) -> impl Iterator<Item = &[MapPoint]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }

    /// All sides of all rings. The area is to the left of each.
    #[inline]
    pub fn sides(&self) -> impl Iterator<Item = Segment> {
        self.rings().flat_map(sides)
    }
}

/// A courtyard house for tests: 10 m by 6 m with a courtyard of 2 m by 2 m, both rings given in
/// the wrong orientation.
#[cfg(test)]
pub(super) fn courtyard_house() -> Polygon {
    let ring = |corners: &[(f64, f64)]| {
        corners
            .iter()
            .map(|(x, y)| MapPoint::new(*x, *y))
            .collect::<Vec<_>>()
    };
    let outer = ring(&[(0.0, 0.0), (0.0, 6.0), (10.0, 6.0), (10.0, 0.0), (0.0, 0.0)]);
    let hole = ring(&[(4.0, 2.0), (6.0, 2.0), (6.0, 4.0), (4.0, 4.0)]);
    Polygon::new(outer, vec![hole]).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_without_area_are_no_polygons() {
        let p = MapPoint::new;
        assert_eq!(Polygon::new(vec![], vec![]), None);
        assert_eq!(
            Polygon::new(vec![p(0.0, 0.0), p(1.0, 1.0), p(2.0, 2.0)], vec![]),
            None
        );
        assert_eq!(
            Polygon::new(vec![p(0.0, 0.0), p(f64::NAN, 1.0), p(2.0, 0.0)], vec![]),
            None
        );
    }
}
