//! The nearest point of a polygon's boundary, and its outward normal.

use openbench_core::MapPoint;

use super::shape::Polygon;
use crate::segment::Segment;

/// A point of a polygon's boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryPoint {
    /// Its position.
    pub point: MapPoint,
    /// The direction out of the area, at right angles to the side: radians, counter-clockwise
    /// from east.
    pub normal: f64,
}

impl Polygon {
    /// The point of any ring nearest to `point`, which may be inside or outside. `point` itself
    /// with normal 0, if the polygon has no sides.
    pub fn nearest_boundary_point(&self, point: MapPoint) -> BoundaryPoint {
        let mut least = f64::INFINITY;
        let mut nearest = BoundaryPoint { point, normal: 0.0 };
        for side in self.sides() {
            let foot = side.nearest_point(point).point;
            // Squares order as distances do, without a root for each side.
            let squared =
                (foot.x - point.x) * (foot.x - point.x) + (foot.y - point.y) * (foot.y - point.y);
            // Of two sides that are equally near, at a corner, the first counts.
            if squared < least {
                least = squared;
                nearest = BoundaryPoint {
                    point: foot,
                    normal: outward_normal(side),
                };
            }
        }
        nearest
    }

    /// Metres from `point` to the nearest ring, whether `point` is inside or outside.
    pub fn distance_to_boundary(&self, point: MapPoint) -> f64 {
        self.nearest_boundary_point(point).point.distance(point)
    }
}

/// The area is to the left of each side, so the normal points to its right.
fn outward_normal(side: Segment) -> f64 {
    let Segment { start: a, end: b } = side;
    libm::atan2(a.x - b.x, b.y - a.y)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use openbench_core::MapPoint;
    use proptest::prelude::*;

    use super::super::shape::{Polygon, courtyard_house};
    use super::BoundaryPoint;

    fn p(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    #[test]
    fn normals_point_out_of_the_area() {
        let house = courtyard_house();
        let south_wall = BoundaryPoint {
            point: p(3.0, 0.0),
            normal: -FRAC_PI_2,
        };
        assert_eq!(house.nearest_boundary_point(p(3.0, -2.0)), south_wall);
        assert_eq!(house.nearest_boundary_point(p(3.0, 0.5)), south_wall);
        let east_wall = BoundaryPoint {
            point: p(10.0, 3.0),
            normal: 0.0,
        };
        assert_eq!(house.nearest_boundary_point(p(12.0, 3.0)), east_wall);
    }

    #[test]
    fn normals_of_a_courtyard_point_into_it() {
        let house = courtyard_house();
        let west_wall = BoundaryPoint {
            point: p(4.0, 3.0),
            normal: 0.0,
        };
        assert_eq!(house.nearest_boundary_point(p(4.1, 3.0)), west_wall);
        let east_wall = house.nearest_boundary_point(p(5.9, 3.0));
        assert!((east_wall.normal.abs() - PI).abs() < 1e-12);
    }

    proptest! {
        /// Stars around the origin are simple polygons. A millimetre along the normal is outside,
        /// a millimetre against it inside.
        #[test]
        fn the_normal_leads_out(
            radii in prop::collection::vec(2.0f64..9.0, 5..12),
            x in -12.0f64..12.0,
            y in -12.0f64..12.0,
        ) {
            let turn = |i: usize| i as f64 / radii.len() as f64 * TAU;
            let corner = |(i, radius): (usize, &f64)| p(0.0, 0.0).offset(turn(i), *radius);
            let outer = radii.iter().enumerate().map(corner).collect();
            let star = Polygon::new(outer, vec![]).unwrap();
            let wall = star.nearest_boundary_point(p(x, y));
            let at_corner = star.outer.iter().any(|c| c.distance(wall.point) < 1e-2);
            prop_assume!(!at_corner);
            prop_assert!(!star.contains(wall.point.offset(wall.normal, 1e-3)));
            prop_assert!(star.contains(wall.point.offset(wall.normal, -1e-3)));
            prop_assert!(star.contains(star.interior_point()));
        }
    }
}
