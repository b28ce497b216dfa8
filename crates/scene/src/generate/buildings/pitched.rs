//! The geometry of gabled and hipped roofs over a rectangle.

use nalgebra::Point3;
use openbench_core::MapPoint;
use openbench_geometry::Segment;

use crate::generate::shapes::at;

/// Overhang of a pitched roof over its walls, metres.
pub(super) const OVERHANG_M: f64 = 0.4;

/// The rectangle that a gabled or hipped roof covers.
pub(super) struct Span {
    /// Counter-clockwise, the eaves along 0-1 and 2-3.
    pub corners: [MapPoint; 4],
    /// Half of the distance between the eaves, metres.
    pub half_width: f64,
    /// Height of the eaves, metres.
    pub eaves: f64,
    /// Rise over run.
    pub slope: f64,
}

impl Span {
    /// Over a ring of four corners; the eaves are along the longer sides.
    pub fn of(ring: &[MapPoint], eaves: f64, slope: f64) -> Self {
        let long_first = ring[0].distance(ring[1]) >= ring[1].distance(ring[2]);
        let first = if long_first { 0 } else { 1 };
        let corners = [0, 1, 2, 3].map(|i| ring[(i + first) % 4]);
        let half_width = corners[1].distance(corners[2]) / 2.0;
        Self {
            corners,
            half_width,
            eaves,
            slope,
        }
    }

    /// Length of the eaves, metres.
    pub fn length(&self) -> f64 {
        self.corners[0].distance(self.corners[1])
    }

    /// Height of the ridge above the eaves, metres.
    pub fn rise(&self) -> f64 {
        self.half_width * self.slope
    }

    /// The rectangle grown by the overhang, at the height of the roof there.
    pub fn edge(&self, over_gables: f64) -> [Point3<f64>; 4] {
        let [a, b, c, d] = self.corners;
        let grow = |p: MapPoint, along: MapPoint, across: MapPoint| {
            let q = away(away(p, along, over_gables), across, OVERHANG_M);
            // The slope goes on over the wall, so its edge is below the eaves.
            at(q, self.eaves - OVERHANG_M * self.slope)
        };
        [grow(a, b, d), grow(b, a, c), grow(c, d, b), grow(d, c, a)]
    }

    /// Both ends of the ridge, `by` metres inside the gables (outside if negative).
    pub fn ridge(&self, by: f64) -> [Point3<f64>; 2] {
        let [a, b, c, d] = self.corners;
        let (first, last) = (Segment::new(a, d).middle(), Segment::new(b, c).middle());
        let z = self.eaves + self.rise();
        [at(away(first, last, -by), z), at(away(last, first, -by), z)]
    }

    /// The walls under the two gables.
    pub fn gables(&self) -> [Segment; 2] {
        let [a, b, c, d] = self.corners;
        [Segment::new(b, c), Segment::new(d, a)]
    }
}

/// `p` moved away from `other` by `metres`.
fn away(p: MapPoint, other: MapPoint, metres: f64) -> MapPoint {
    Segment::new(p, other).at(-metres / p.distance(other).max(1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ridge_runs_between_the_shorter_sides() {
        let ring = [(0.0, 0.0), (6.0, 0.0), (6.0, 10.0), (0.0, 10.0)];
        let span = Span::of(&ring.map(|(x, y)| MapPoint::new(x, y)), 5.0, 0.5);
        let [from, to] = span.ridge(0.0);
        assert_eq!(
            (from, to),
            (Point3::new(3.0, 0.0, 6.5), Point3::new(3.0, 10.0, 6.5))
        );
        assert_eq!(span.length(), 10.0);
    }
}
