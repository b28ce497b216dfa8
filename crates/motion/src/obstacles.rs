//! A LiDAR scan as a ring of ranges around the robot.
//!
//! Points between ankle and roof of the robot are obstacles. A beam that reached the ground or an obstacle shows that
//! nothing stood in its way; that is how far the ring is clear in that direction.

use openbench_core::MapPoint;

/// Directions of a ring: one degree each.
pub const DIRECTIONS: usize = 360;
/// Points between these heights above the ground are obstacles, metres.
const BODY: (f64, f64) = (0.10, 0.45);
/// Points lower than this are ground, metres.
const GROUND: f64 = 0.06;
/// Points further away are left alone: a tilt of one degree lifts the ground by 14 cm there.
const REACH: f64 = 8.0;

/// What one scan shows around the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeRing {
    /// Where the sensor was, in `map`.
    pub center: MapPoint,
    /// Obstacle points, in `map`.
    pub obstacles: Vec<MapPoint>,
    /// For each direction (degrees counter-clockwise from east): metres known to be clear.
    pub clear: Vec<f64>,
}

impl RangeRing {
    /// Sorts points in `map`, each with its height above the ground in metres, into a ring around the sensor.
    pub fn new(center: MapPoint, points: impl Iterator<Item = (MapPoint, f64)>) -> Self {
        let mut nearest = [f64::INFINITY; DIRECTIONS];
        let mut reached = [0.0_f64; DIRECTIONS];
        let mut obstacles = Vec::new();
        for (point, height) in points {
            let (dx, dy) = (point.x - center.x, point.y - center.y);
            let square = dx * dx + dy * dy;
            // Written so that a broken number is passed over too.
            let counts = square <= REACH * REACH && (height < GROUND || (BODY.0..=BODY.1).contains(&height));
            if !counts {
                continue;
            }
            let (distance, direction) = (square.sqrt(), direction_index(libm::atan2(dy, dx)));
            reached[direction] = reached[direction].max(distance);
            if height >= BODY.0 {
                nearest[direction] = nearest[direction].min(distance);
                obstacles.push(point);
            }
        }
        let clear = (0..DIRECTIONS).map(|i| reached[i].min(nearest[i])).collect();
        Self { center, obstacles, clear }
    }
}

fn direction_index(bearing: f64) -> usize {
    let degrees = libm::floor(bearing.to_degrees()) as i64;
    degrees.rem_euclid(DIRECTIONS as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[[f64; 3]]) -> RangeRing {
        RangeRing::new(MapPoint::new(1.0, 1.0), points.iter().map(|p| (MapPoint::new(p[0], p[1]), p[2])))
    }

    #[test]
    fn heights_tell_obstacles_from_ground_and_from_what_is_above() {
        let ring =
            ring(&[[1.0, 3.0, 0.3], [1.0, 4.0, 0.01], [2.0, 3.0, 2.0], [-1.0, 1.01, 0.0], [1.0, 10.0, 0.2]]);
        assert_eq!(ring.obstacles, [MapPoint::new(1.0, 3.0)]);
        // Clear to the obstacle in the north, though ground was seen behind it; clear to the ground in the west.
        assert!((ring.clear[90] - 2.0).abs() < 1e-9);
        assert!((ring.clear[179] - 2.0).abs() < 1e-3);
    }

    #[test]
    fn broken_points_are_passed_over() {
        let ring = ring(&[[f64::NAN, 0.0, 0.2], [1.0, 0.0, f64::NAN], [f64::INFINITY, 0.0, 0.2]]);
        assert!(ring.obstacles.is_empty() && ring.clear.iter().all(|&c| c == 0.0));
    }
}
