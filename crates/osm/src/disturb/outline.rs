//! Outlines that were drawn carelessly.

use openbench_core::MapPoint;
use openbench_geometry::Polygon;

/// Scales a building about its middle, so that its walls move outwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swelling {
    middle: MapPoint,
    factor: f64,
}

impl Swelling {
    /// A building whose walls move outwards by `distance` metres, inwards if it is negative. Exact
    /// if all walls touch one circle, as those of a square do.
    pub(super) fn new(outline: &Polygon, distance: f64) -> Self {
        // The radius of that circle.
        let radius = 2.0 * outline.area() / outline.perimeter();
        let factor = 1.0 + distance / radius;
        Self {
            middle: outline.centroid(),
            // No building vanishes or becomes a multiple of itself.
            factor: if factor.is_finite() {
                factor.clamp(0.5, 2.0)
            } else {
                1.0
            },
        }
    }

    /// Where a point of the building comes to be.
    pub(super) fn apply(&self, point: MapPoint) -> MapPoint {
        let Self { middle, factor } = *self;
        MapPoint::new(
            middle.x + factor * (point.x - middle.x),
            middle.y + factor * (point.y - middle.y),
        )
    }
}

/// The smallest of the rectangles around a ring that are parallel to one of its sides,
/// counter-clockwise. A smallest rectangle around a convex ring is one of them (Freeman and
/// Shapira 1975).
pub(super) fn rectangle_around(ring: &[MapPoint]) -> Option<[MapPoint; 4]> {
    let sides = openbench_geometry::sides(ring).filter(|side| side.length() > 0.0);
    let rectangles = sides.map(|side| Rectangle::parallel(ring, side.bearing()));
    rectangles
        .min_by(|a, b| a.area().total_cmp(&b.area()))
        .map(|rectangle| rectangle.corners())
}

/// A rectangle in a turned frame.
struct Rectangle {
    bearing: f64,
    low: [f64; 2],
    high: [f64; 2],
}

impl Rectangle {
    fn parallel(ring: &[MapPoint], bearing: f64) -> Self {
        let (sin, cos) = libm::sincos(bearing);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in ring {
            let turned = [cos * p.x + sin * p.y, cos * p.y - sin * p.x];
            for axis in 0..2 {
                low[axis] = low[axis].min(turned[axis]);
                high[axis] = high[axis].max(turned[axis]);
            }
        }
        Self { bearing, low, high }
    }

    fn area(&self) -> f64 {
        (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])
    }

    fn corners(&self) -> [MapPoint; 4] {
        let (sin, cos) = libm::sincos(self.bearing);
        let Self { low, high, .. } = self;
        let turned = [
            [low[0], low[1]],
            [high[0], low[1]],
            [high[0], high[1]],
            [low[0], high[1]],
        ];
        turned.map(|[u, v]| MapPoint::new(cos * u - sin * v, sin * u + cos * v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[(f64, f64)]) -> Polygon {
        let ring = corners.iter().map(|&(x, y)| MapPoint::new(x, y)).collect();
        Polygon::new(ring, Vec::new()).unwrap()
    }

    #[test]
    fn the_walls_of_a_square_move_by_the_distance() {
        let square = polygon(&[(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0)]);
        let swollen = Swelling::new(&square, 1.0);
        assert_eq!(
            swollen.apply(MapPoint::new(0.0, 0.0)),
            MapPoint::new(-1.0, -1.0)
        );
        let shrunk = Swelling::new(&square, -1.0);
        assert_eq!(
            shrunk.apply(MapPoint::new(8.0, 4.0)),
            MapPoint::new(7.0, 4.0)
        );
        assert_eq!(Swelling::new(&square, -100.0).factor, 0.5);
    }

    #[test]
    fn the_rectangle_around_an_l_holds_it_and_follows_its_sides() {
        // An L of 6 by 4 m, turned by 30 degrees.
        let corners = [
            (0.0, 0.0),
            (6.0, 0.0),
            (6.0, 2.0),
            (2.0, 2.0),
            (2.0, 4.0),
            (0.0, 4.0),
        ];
        let (sin, cos) = libm::sincos(30_f64.to_radians());
        let turned = corners.map(|(x, y)| (cos * x - sin * y, sin * x + cos * y));
        let l = polygon(&turned);
        let rectangle = Polygon::new(rectangle_around(&l.outer).unwrap().to_vec(), vec![]);
        let rectangle = rectangle.unwrap();
        assert!((rectangle.area() - 24.0).abs() < 1e-9);
        for corner in &l.outer {
            assert!(rectangle.contains(*corner) || rectangle.distance_to_boundary(*corner) < 1e-9);
        }
        assert_eq!(rectangle_around(&[]), None);
    }
}
