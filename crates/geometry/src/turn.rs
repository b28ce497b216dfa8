//! On which side of a line a point is.

use openbench_core::MapPoint;

/// Twice the signed area of a triangle, square metres: positive if `a`, `b`, `c` turn left.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::turn;
///
/// let (a, b) = (MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0));
/// assert_eq!(turn(a, b, MapPoint::new(4.0, 3.0)), 12.0);
/// ```
#[inline]
pub fn turn(a: MapPoint, b: MapPoint, c: MapPoint) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}
