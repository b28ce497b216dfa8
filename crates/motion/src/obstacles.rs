//! A LiDAR scan as a ring of ranges around the robot.
//!
//! Points between the lowest obstacle and the robot's roof are obstacles. A beam that reached the
//! ground or an obstacle shows that no obstacle as high as the beam stood before it. Low things
//! near the robot lie below every beam, so a ring also says at which height its beams passed.
//!
//! A point well below the ground shows that ground is missing before it: from where its beam went
//! below the ground on, there is an obstacle.

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
/// Points lower than this show that ground is missing, metres. Within [`PIT_REACH_M`] the ground
/// seems to lie as low only where the robot tilts by more than a degree and a half.
const MISSING_M: f64 = -0.09;
/// Missing ground is searched for within this distance, metres.
const PIT_REACH_M: f64 = 3.5;
/// Distance between the obstacles that stand for missing ground, metres.
const PIT_STEP_M: f64 = 0.1;
/// Height of those obstacles, metres: no beam passes below it, so none clears them.
const PIT_TOP_M: f64 = 0.0;
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
            let direction = direction_index(libm::atan2(dy, dx));
            let whole = Beam {
                reach: square.sqrt(),
                end_height: z,
            };
            let is_missing = z < MISSING_M && height > 0.0 && whole.reach <= PIT_REACH_M;
            let beam = if is_missing {
                let edge = edge_of_ground(height, whole);
                obstacles.extend(missing_ground(center, point, edge.reach, whole.reach));
                edge
            } else {
                whole
            };
            if beam.reach > furthest[direction].reach {
                furthest[direction] = beam;
            }
            if z >= LOWEST_M {
                obstacles.push(ScanPoint::new(point, z));
            }
            let ends_free_ground = z >= LOWEST_M || is_missing;
            if ends_free_ground && beam.reach < nearest[direction].reach {
                nearest[direction] = beam;
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

/// The part of a beam above the ground; the beam ends below it.
fn edge_of_ground(height: f64, beam: Beam) -> Beam {
    Beam {
        reach: beam.reach * height / (height - beam.end_height),
        end_height: PIT_TOP_M,
    }
}

/// Obstacles on the line from `center` to `point`, between two distances from `center`.
fn missing_ground(
    center: MapPoint,
    point: MapPoint,
    from: f64,
    to: f64,
) -> impl Iterator<Item = ScanPoint> {
    // The nearest and the farthest are a few decimetres apart.
    let steps = ((to - from) / PIT_STEP_M) as usize;
    // A point straight below the sensor has no line to it.
    let count = if to > 0.0 { steps + 1 } else { 0 };
    (0..count).map(move |i| {
        let share = (from + i as f64 * PIT_STEP_M) / to;
        let along = |a: f64, b: f64| a + (b - a) * share;
        let at = MapPoint::new(along(center.x, point.x), along(center.y, point.y));
        ScanPoint::new(at, PIT_TOP_M)
    })
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
    fn ground_is_missing_from_where_a_beam_goes_below_it() {
        // A beam from 25 cm that ends 3 m away and 15 cm below the ground crosses it at 1.875 m.
        let pit = ring(&[[1.0, 4.0, -0.15], [1.0, 5.0, 0.0]]);
        assert!((pit.beams[90].reach - 1.875).abs() < 1e-9, "no further");
        assert_eq!(pit.obstacles.len(), 12);
        let first = pit.obstacles[0];
        assert!((first.at.y - 2.875).abs() < 1e-9 && first.height == PIT_TOP_M);
        let nearer = |p: &ScanPoint| p.at.y < 4.0 + 1e-9;
        assert!(pit.obstacles.iter().all(nearer));
    }

    #[test]
    fn a_point_straight_below_the_sensor_shows_no_missing_ground() {
        let below = ring(&[[1.0, 1.0, -0.5]]);
        assert!(below.obstacles.is_empty());
        assert!(below.beams.iter().all(|beam| beam.reach == 0.0));
    }

    #[test]
    fn ground_that_seems_low_by_a_tilt_is_no_pit() {
        let tilted = ring(&[[1.0, 4.0, -0.08], [1.0, 5.0, -0.11], [8.5, 1.0, -0.2]]);
        assert!(tilted.obstacles.is_empty());
        assert!((tilted.beams[90].reach - 4.0).abs() < 1e-9);
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
