//! A LiDAR scan as a ring of ranges around the robot.
//!
//! Points between the lowest obstacle and the robot's roof are obstacles. A beam that reached the
//! ground or an obstacle shows that no obstacle as high as the beam stood before it. Low things
//! near the robot lie below every beam, so a ring also says at which height its beams passed.

use openbench_core::MapPoint;

/// Directions of a ring: one degree each.
pub(crate) const DIRECTIONS: usize = 360;
/// Points from this height above the ground on are obstacles, metres.
const LOWEST_M: f64 = 0.10;
/// Points above this height are above the robot, metres.
const ROOF_M: f64 = 0.45;
/// Points up to this height may be of people, metres.
const PEOPLE_M: f64 = 1.8;
/// Points lower than this are ground, metres.
const GROUND_M: f64 = 0.06;
/// Points further away are ignored: a tilt of one degree lifts the ground by 14 cm there, metres.
const REACH_M: f64 = 8.0;

/// A point that a LiDAR hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPoint {
    /// Where, in `map`.
    pub at: MapPoint,
    /// Its height above the ground, metres.
    pub height: f64,
}

impl ScanPoint {
    /// A point from its place in `map` and its height above the ground, metres.
    pub const fn new(at: MapPoint, height: f64) -> Self {
        Self { at, height }
    }
}

/// One scan, sorted by direction and height.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeRing {
    /// Where the sensor was, in `map`.
    pub center: MapPoint,
    /// Height of the sensor above the ground, metres.
    pub height: f64,
    /// Points of obstacles.
    pub obstacles: Vec<ScanPoint>,
    /// Points above the robot that are no higher than people, in `map`.
    pub above: Vec<MapPoint>,
    /// For each direction, degrees counter-clockwise from east: the beam that shows most ground to
    /// be free.
    pub beams: Vec<Beam>,
}

/// A beam and its end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Beam {
    /// Horizontal distance of its end from the sensor, metres.
    pub reach: f64,
    /// Height of its end above the ground, metres.
    pub end_height: f64,
}

impl Beam {
    /// The one of two beams that ends first; the other one if both end at the same distance.
    fn shorter(self, other: Self) -> Self {
        if self.reach < other.reach {
            self
        } else {
            other
        }
    }
}

impl RangeRing {
    /// Sorts points into a ring around the sensor at `center`, `height` metres above the ground.
    pub fn new(center: MapPoint, height: f64, points: impl Iterator<Item = ScanPoint>) -> Self {
        let mut nearest = [Beam {
            reach: f64::INFINITY,
            end_height: 0.0,
        }; DIRECTIONS];
        let mut furthest = [Beam::default(); DIRECTIONS];
        let (mut obstacles, mut above) = (Vec::new(), Vec::new());
        for ScanPoint {
            at: point,
            height: z,
        } in points
        {
            let (dx, dy) = (point.x - center.x, point.y - center.y);
            let square = dx * dx + dy * dy;
            // Written so that NaN is passed over too.
            // Between ground and the lowest obstacle a point may be either: it counts as neither.
            let counts =
                square <= REACH_M * REACH_M && (z < GROUND_M || (LOWEST_M..=PEOPLE_M).contains(&z));
            if !counts {
                continue;
            }
            if z > ROOF_M {
                above.push(point);
                continue;
            }
            let (beam, direction) = (
                Beam {
                    reach: square.sqrt(),
                    end_height: z,
                },
                direction_index(libm::atan2(dy, dx)),
            );
            if beam.reach > furthest[direction].reach {
                furthest[direction] = beam;
            }
            if z >= LOWEST_M {
                obstacles.push(ScanPoint::new(point, z));
                if beam.reach < nearest[direction].reach {
                    nearest[direction] = beam;
                }
            }
        }
        // A beam that reached ground behind an obstacle passed over it, but the beam that hit the
        // obstacle says where the free ground ends.
        let both = nearest.into_iter().zip(furthest);
        Self {
            center,
            height,
            obstacles,
            above,
            beams: both
                .map(|(nearest, furthest)| nearest.shorter(furthest))
                .collect(),
        }
    }

    /// Height above the ground at which `beam` passes `distance` metres from the sensor, metres.
    pub(crate) fn height_at(&self, beam: Beam, distance: f64) -> f64 {
        self.height + (beam.end_height - self.height) * (distance / beam.reach.max(1e-9))
    }
}

/// The direction of a bearing, radians.
fn direction_index(bearing: f64) -> usize {
    let degrees = libm::floor(bearing.to_degrees()) as i64;
    degrees.rem_euclid(DIRECTIONS as i64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[[f64; 3]]) -> RangeRing {
        RangeRing::new(
            MapPoint::new(1.0, 1.0),
            0.25,
            points
                .iter()
                .map(|p| ScanPoint::new(MapPoint::new(p[0], p[1]), p[2])),
        )
    }

    #[test]
    fn heights_distinguish_obstacles_from_ground_and_from_things_above() {
        let ring = ring(&[
            [1.0, 3.0, 0.3],
            [1.0, 4.0, 0.01],
            [2.0, 3.0, 2.0],
            [-1.0, 1.01, 0.0],
            [1.0, 10.0, 0.2],
        ]);
        assert_eq!(
            ring.obstacles,
            [ScanPoint::new(MapPoint::new(1.0, 3.0), 0.3)]
        );
        // Free to the obstacle in the north, though ground was seen behind it; free to the ground
        // in the west.
        assert!((ring.beams[90].reach - 2.0).abs() < 1e-9);
        assert!((ring.beams[179].reach - 2.0).abs() < 1e-3);
    }

    #[test]
    fn points_that_are_not_finite_are_passed_over() {
        let ring = ring(&[
            [f64::NAN, 0.0, 0.2],
            [1.0, 0.0, f64::NAN],
            [f64::INFINITY, 0.0, 0.2],
        ]);
        assert!(ring.obstacles.is_empty() && ring.beams.iter().all(|b| b.reach == 0.0));
    }
}
