//! Points of a path ahead of the robot.

use openbench_core::MapPoint;
use openbench_geometry::Segment;

/// Of two places on a path that are as near, within this many metres, the earlier one counts.
const ROUNDING: f64 = 1e-9;

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Where, in `map`.
    pub point: MapPoint,
    /// Whether the path ends there.
    pub is_end: bool,
}

/// The point `length` metres along a path from its point nearest to `from`, or its end if that is
/// nearer; `None` for an empty path.
pub fn ahead(path: &[MapPoint], from: MapPoint, length: f64) -> Option<PathPoint> {
    let (mut segment, mut foot) = (0, *path.first()?);
    for (i, pair) in path.windows(2).enumerate() {
        let candidate = Segment::new(pair[0], pair[1]).nearest_point(from).point;
        if candidate.distance(from) < foot.distance(from) - ROUNDING {
            (segment, foot) = (i, candidate);
        }
    }
    let (mut at, mut left) = (foot, length);
    // A path of a single point has no segment, and nothing after it.
    for next in &path[(segment + 1).min(path.len())..] {
        let step = at.distance(*next);
        // Points that are given twice have no direction.
        if step >= left && step > 0.0 {
            let t = left / step;
            let point = MapPoint::new(at.x + t * (next.x - at.x), at.y + t * (next.y - at.y));
            return Some(PathPoint {
                point,
                is_end: false,
            });
        }
        (at, left) = (*next, left - step);
    }
    Some(PathPoint {
        point: at,
        is_end: true,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_ahead_is_measured_along_the_path_from_its_nearest_point() {
        let path = [
            MapPoint::new(0.0, 0.0),
            MapPoint::new(2.0, 0.0),
            MapPoint::new(2.0, 2.0),
        ];
        let from = MapPoint::new(1.5, 0.3);
        let at = |length: f64| ahead(&path, from, length).unwrap();
        assert_eq!(
            at(0.5),
            PathPoint {
                point: path[1],
                is_end: false
            }
        );
        assert_eq!(
            at(1.5),
            PathPoint {
                point: MapPoint::new(2.0, 1.0),
                is_end: false
            }
        );
        assert_eq!(
            at(9.0),
            PathPoint {
                point: path[2],
                is_end: true
            }
        );
        assert_eq!(ahead(&[], from, 1.0), None);
    }
}
