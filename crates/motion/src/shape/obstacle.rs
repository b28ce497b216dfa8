//! Standing and moving obstacles.

use openbench_core::MapPoint;

use super::distance::{between, edges, winds_twice};
use super::error::{MOST_CORNERS, ShapeError};
use super::footprint::Placed;
use crate::vector::Vector2;

/// Coordinates and speeds beyond this are not usable, metres and m/s.
const LARGEST: f64 = 1e7;
/// Roundings from this on are not usable, metres.
const LARGEST_ROUNDING: f64 = 1e4;

/// A convex obstacle, standing or moving with constant velocity.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_motion::{Obstacle, Vector2};
///
/// // A person walks north at 1 m/s.
/// let person = Obstacle::new(&[MapPoint::new(2.0, 0.0)], 0.3, Vector2::new(0.0, 1.0))?;
/// let robot = MapPoint::new(0.0, 0.0);
/// assert!((person.distance_to(robot) - 1.7).abs() < 1e-9);
/// assert!((person.after(1.5).distance_to(robot) - 2.2).abs() < 1e-9);
/// # Ok::<(), openbench_motion::ShapeError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    corners: Vec<Vector2>,
    rounding: f64,
    velocity: Vector2,
    middle: Vector2,
    radius: f64,
}

/// How near a footprint is to an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Distance, metres; negative inside.
    pub(crate) distance: f64,
    /// Derivative of the distance by the robot's x, y (per metre) and yaw (per radian).
    pub(crate) gradient: [f64; 3],
    /// Unit vector from the footprint to the obstacle, in `map`.
    pub(crate) normal: Vector2,
}

impl Obstacle {
    /// Anything convex: corners in `map` counter-clockwise, rounded by `rounding` metres, moving
    /// with `velocity` m/s in `map`.
    pub fn new(corners: &[MapPoint], rounding: f64, velocity: Vector2) -> Result<Self, ShapeError> {
        let corners: Vec<Vector2> = corners.iter().map(|c| Vector2::to(*c)).collect();
        let numbers = corners.iter().all(|c| c.is_within(LARGEST)) && velocity.is_within(LARGEST);
        if corners.is_empty() || !numbers || !(0.0..LARGEST_ROUNDING).contains(&rounding) {
            return Err(ShapeError::NotFinite);
        }
        for i in 0..corners.len() {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % corners.len()]);
            // Corners in one line are allowed, unlike those of a footprint: edges without length
            // are skipped.
            if corners.len() > 2 && (b - a).cross(c - b) < 0.0 {
                return Err(ShapeError::NotConvex((i + 1) % corners.len()));
            }
        }
        if winds_twice(&corners) {
            return Err(ShapeError::Crosses);
        }
        let n = corners.len() as f64;
        let middle = corners.iter().fold(Vector2::ZERO, |sum, c| {
            Vector2::new(sum.x + c.x / n, sum.y + c.y / n)
        });
        let radius = corners
            .iter()
            .map(|c| (*c - middle).norm())
            .fold(0.0, f64::max)
            + rounding;
        Ok(Self {
            corners,
            rounding,
            velocity,
            middle,
            radius,
        })
    }

    /// A disc that stands; radius in metres.
    pub fn disc(center: MapPoint, radius: f64) -> Result<Self, ShapeError> {
        Self::new(&[center], radius, Vector2::ZERO)
    }

    /// A wall without thickness.
    pub fn wall(from: MapPoint, to: MapPoint) -> Result<Self, ShapeError> {
        Self::new(&[from, to], 0.0, Vector2::ZERO)
    }

    /// The mean of its corners now, in `map`.
    pub fn middle(&self) -> MapPoint {
        self.middle.point()
    }

    /// Distance from [`Obstacle::middle`] to the furthest point of it, metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Its corners in `map`, counter-clockwise.
    pub fn corners(&self) -> impl Iterator<Item = MapPoint> {
        self.corners.iter().map(|c| c.point())
    }

    /// Distance by which the outline of its corners is widened, metres.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// m/s in `map`.
    pub fn velocity(&self) -> Vector2 {
        self.velocity
    }

    /// Whether it moves.
    pub fn is_moving(&self) -> bool {
        self.velocity != Vector2::ZERO
    }

    /// Where it will be after `seconds` at constant velocity.
    pub fn after(&self, seconds: f64) -> Self {
        let by = self.velocity * seconds;
        Self {
            corners: self.corners.iter().map(|c| *c + by).collect(),
            middle: self.middle + by,
            ..*self
        }
    }

    /// Distance from a point, metres; negative inside.
    pub fn distance_to(&self, point: MapPoint) -> f64 {
        let point = Vector2::to(point);
        let mut nearest = (point - self.corners[0]).norm();
        let mut inside = self.corners.len() > 2;
        for edge in edges(&self.corners) {
            nearest = nearest.min((point - edge.nearest_to(point)).norm());
            inside &= edge.along().cross(point - edge.from) > 0.0;
        }
        (if inside { -nearest } else { nearest }) - self.rounding
    }

    /// How near a footprint is to the obstacle as it will be after `seconds`, if that may be less
    /// than `reach` metres. `circumscribed` is the footprint's, metres.
    #[inline]
    pub(crate) fn contact(
        &self,
        foot: &Placed,
        circumscribed: f64,
        seconds: f64,
        reach: f64,
    ) -> Option<Contact> {
        // The robot is moved instead of the obstacle: it has fewer corners.
        let shift = self.velocity * seconds;
        // Circles around both first: they settle most obstacles.
        let origin = foot.origin - shift;
        let apart = origin - self.middle;
        let far = self.radius + circumscribed + reach;
        if apart.dot(apart) > far * far {
            return None;
        }
        let mut room = [Vector2::ZERO; MOST_CORNERS];
        let corners = foot.corners_moved_back(shift, &mut room);
        let touch = between(corners, &self.corners);
        let (arm, n) = (touch.on_foot - origin, touch.normal);
        // The distance is n . (obstacle - contact point), and the contact point turns about the
        // robot's origin.
        let gradient = [-n.x, -n.y, n.x * arm.y - n.y * arm.x];
        Some(Contact {
            distance: touch.distance - self.rounding,
            gradient,
            normal: n,
        })
    }
}

/// The obstacles that stand.
pub(crate) fn standing(obstacles: &[Obstacle]) -> impl Iterator<Item = &Obstacle> {
    obstacles.iter().filter(|obstacle| !obstacle.is_moving())
}

/// The obstacles that move.
pub(crate) fn moving(obstacles: &[Obstacle]) -> impl Iterator<Item = &Obstacle> {
    obstacles.iter().filter(|obstacle| obstacle.is_moving())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Footprint;
    use openbench_core::{Pose2, RobotDescription};
    use proptest::prelude::*;

    fn robot() -> Footprint {
        Footprint::of(&RobotDescription::sentry()).unwrap()
    }

    fn distance(pose: Pose2, obstacle: &Obstacle) -> f64 {
        contact(pose, obstacle).distance
    }

    fn contact(pose: Pose2, obstacle: &Obstacle) -> Contact {
        let robot = robot();
        obstacle
            .contact(&robot.at(pose), robot.circumscribed(), 0.0, 100.0)
            .unwrap()
    }

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    #[test]
    fn distances_of_a_rectangle_are_those_of_geometry() {
        let (half_length, half_width) = (0.16, 0.155);
        let here = Pose2::default();
        let disc = Obstacle::disc(point(1.0, 0.0), 0.2).unwrap();
        assert!((distance(here, &disc) - (1.0 - 0.2 - half_length)).abs() < 1e-12);
        let beside = Pose2::new(1.0, 1.0, 0.0);
        assert!((distance(beside, &disc) - (1.0 - 0.2 - half_width)).abs() < 1e-12);
        let post = Obstacle::disc(point(1.16, 1.155), 0.0).unwrap();
        assert!((distance(here, &post) - 2f64.sqrt()).abs() < 1e-12);
        let wall = Obstacle::wall(point(2.0, -9.0), point(2.0, 9.0)).unwrap();
        assert!((distance(here, &wall) - (2.0 - half_length)).abs() < 1e-12);
        // Inside: the shortest way out.
        assert!((distance(Pose2::new(1.05, 0.0, 0.0), &wall.after(1.0)) - 0.79).abs() < 1e-12);
        let inside = Pose2::new(1.95, 0.0, 0.0);
        assert!((distance(inside, &wall) + (half_length - 0.05)).abs() < 1e-12);
    }

    #[test]
    fn corners_that_make_no_shape_are_refused() {
        let corner = Vector2::new;
        let corners = [
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
            corner(-1.0, -1.0),
        ];
        assert!(Footprint::new(&corners).is_ok());
        assert_eq!(Footprint::new(&corners[..2]), Err(ShapeError::Corners(2)));
        let clockwise: Vec<_> = corners.iter().rev().copied().collect();
        assert!(matches!(
            Footprint::new(&clockwise),
            Err(ShapeError::NotConvex(_))
        ));
        let aside: Vec<_> = corners.iter().map(|c| *c + corner(3.0, 0.0)).collect();
        assert_eq!(Footprint::new(&aside), Err(ShapeError::NotAround));
        let broken = [corner(f64::NAN, 0.0); 3];
        assert_eq!(Footprint::new(&broken), Err(ShapeError::NotFinite));
        assert!(Obstacle::disc(point(f64::NAN, 0.0), 1.0).is_err());
        assert!(Obstacle::disc(point(0.0, 0.0), -1.0).is_err());
        assert!(Obstacle::new(&[], 0.1, Vector2::ZERO).is_err());
        let dent = [
            point(0.0, 0.0),
            point(2.0, 0.0),
            point(0.5, 0.5),
            point(0.0, 2.0),
        ];
        let dent = Obstacle::new(&dent, 0.0, Vector2::ZERO);
        assert!(matches!(dent, Err(ShapeError::NotConvex(_))));
    }

    #[test]
    fn a_star_that_turns_left_at_every_corner_is_refused() {
        let tip = |i: i32| libm::sincos(std::f64::consts::TAU * f64::from(i) / 5.0);
        let star = [0, 2, 4, 1, 3]
            .map(tip)
            .map(|(sin, cos)| Vector2::new(cos, sin));
        assert_eq!(Footprint::new(&star), Err(ShapeError::Crosses));
        let star = star.map(Vector2::point);
        assert_eq!(
            Obstacle::new(&star, 0.0, Vector2::ZERO),
            Err(ShapeError::Crosses)
        );
    }

    prop_compose! {
        fn convex()(
            sides in 1..7_usize,
            radius in 0.05..0.8_f64,
            x in -1.5..1.5_f64,
            y in -1.5..1.5_f64,
            turn in 0.0..6.0_f64,
            rounding in 0.0..0.3_f64,
        ) -> Obstacle {
            let corner = |i: usize| {
                let angle = turn + std::f64::consts::TAU * i as f64 / sides as f64;
                let (sin, cos) = libm::sincos(angle);
                point(x + 1.5 * radius * cos, y + radius * sin)
            };
            let corners: Vec<MapPoint> = (0..sides).map(corner).collect();
            Obstacle::new(&corners, rounding, Vector2::ZERO).unwrap()
        }
    }

    prop_compose! {
        fn near_pose()(
            x in -1.0..1.0_f64,
            y in -1.0..1.0_f64,
            yaw in -3.0..3.0_f64,
        ) -> Pose2 {
            Pose2::new(x, y, yaw)
        }
    }

    /// 200 points on each edge of the robot's outline, in `map`.
    fn outline_points(robot: &Footprint, pose: Pose2) -> Vec<MapPoint> {
        let on_edge = |i: i32, edge: crate::shape::distance::Edge| {
            let at = edge.from + edge.along() * (f64::from(i) / 200.0);
            pose.transform(at.x, at.y)
        };
        edges(robot.corners())
            .flat_map(|edge| (0..200).map(move |i| on_edge(i, edge)))
            .collect()
    }

    proptest! {
        #[test]
        fn distances_are_those_of_many_points_of_the_outlines(
            obstacle in convex(),
            pose in near_pose(),
        ) {
            let found = contact(pose, &obstacle);
            let points = outline_points(&robot(), pose);
            let least = points.iter().map(|p| obstacle.distance_to(*p)).fold(9.0, f64::min);
            if found.distance > 0.0 {
                let distance = found.distance;
                prop_assert!(least >= distance - 1e-9 && least < distance + 2e-3, "{least}");
            } else {
                // Overlapping without rounding: moved out by as much along the normal, they touch.
                let out = found.normal * found.distance;
                let out = Pose2::new(pose.x + out.x, pose.y + out.y, pose.yaw);
                prop_assert!(distance(out, &obstacle).abs() < 1e-9 || obstacle.rounding > 0.0);
            }
        }

        #[test]
        fn gradients_are_those_of_finite_differences(
            obstacle in convex(),
            pose in near_pose(),
        ) {
            const STEP: f64 = 1e-6;
            let contact = contact(pose, &obstacle);
            let at = |dx: f64, dy: f64, turn: f64| {
                distance(Pose2::new(pose.x + dx, pose.y + dy, pose.yaw + turn), &obstacle)
            };
            let forward = [at(STEP, 0.0, 0.0), at(0.0, STEP, 0.0), at(0.0, 0.0, STEP)]
                .map(|d| (d - contact.distance) / STEP);
            let back = [at(-STEP, 0.0, 0.0), at(0.0, -STEP, 0.0), at(0.0, 0.0, -STEP)]
                .map(|d| (contact.distance - d) / STEP);
            for k in 0..3 {
                // Where the nearest edge changes there is no derivative.
                let smooth = (forward[k] - back[k]).abs() < 1e-4;
                let agrees = (contact.gradient[k] - forward[k]).abs() < 1e-3;
                prop_assert!(!smooth || agrees, "{contact:?} {forward:?}");
            }
        }
    }
}
