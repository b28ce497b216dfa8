//! Rings in a given orientation, without repeated points.

use openbench_core::MapPoint;

use super::signed_area::signed_area;

/// Rings that enclose less than this are rounding errors, square metres.
const SMALLEST_AREA_M2: f64 = 1e-6;

/// In which direction a ring runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Orientation {
    CounterClockwise,
    Clockwise,
}

/// The ring without repeated points, in the given orientation; `None` if it encloses no area or
/// has coordinates that are not finite.
pub(super) fn oriented(
    mut points: Vec<MapPoint>,
    orientation: Orientation,
) -> Option<Vec<MapPoint>> {
    // OSM repeats the first node of a closed way at its end.
    points.dedup();
    while points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    let area = signed_area(&points);
    // Written so that NaN is refused too.
    if !(area.abs() > SMALLEST_AREA_M2 && area.is_finite()) {
        return None;
    }
    if (area > 0.0) != (orientation == Orientation::CounterClockwise) {
        points.reverse();
    }
    Some(points)
}
