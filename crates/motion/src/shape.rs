//! Shapes on the ground: the robot's footprint, what stands or moves in its way, and how far they are apart.
//!
//! Every obstacle is convex with an optional rounding: one corner is a disc, two are a wall, more a polygon. What is not convex is several of them. Distances are exact and signed:
//! apart, the Euclidean distance; overlapping, less than zero by the shortest way out along an edge's normal (separating axes).

use openbench_core::{MapPoint, Pose2, RobotDescription};

/// Most corners of a footprint.
pub const MOST_CORNERS: usize = 16;

/// The robot's outline in `base_link`: convex, counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    corners: Vec<[f64; 2]>,
    inscribed: f64,
    circumscribed: f64,
}

/// Corners make no shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Too few or too many.
    #[error("a footprint has 3 to {MOST_CORNERS} corners, not {0}")]
    Corners(usize),
    /// Not convex or not counter-clockwise.
    #[error("corner {0} of the outline does not turn left; give a convex one counter-clockwise")]
    NotConvex(usize),
    /// Every corner turns left, but the outline crosses itself.
    #[error("the outline crosses itself; give its corners in their order")]
    Crosses,
    /// The robot turns about a point outside its outline.
    #[error("the footprint does not hold the origin of base_link, about which the robot turns")]
    NotAround,
    /// A number that is none, or a negative rounding.
    #[error("a corner, rounding or speed of a shape is no usable number")]
    NotFinite,
}

impl Footprint {
    /// A footprint from its corners in `base_link`, metres.
    pub fn new(corners: &[[f64; 2]]) -> Result<Self, ShapeError> {
        if !(3..=MOST_CORNERS).contains(&corners.len()) {
            return Err(ShapeError::Corners(corners.len()));
        }
        if !corners.iter().flatten().all(|c| c.is_finite() && c.abs() < 1e3) {
            return Err(ShapeError::NotFinite);
        }
        let mut inscribed = f64::INFINITY;
        for (i, (a, b)) in edges(corners).enumerate() {
            let c = corners[(i + 2) % corners.len()];
            let (along, next) = (minus(b, a), minus(c, b));
            if cross(along, next) <= 0.0 {
                return Err(ShapeError::NotConvex((i + 1) % corners.len()));
            }
            inscribed = inscribed.min(cross(along, minus([0.0; 2], a)) / norm(along));
        }
        let circumscribed = corners.iter().map(|c| norm(*c)).fold(0.0, f64::max);
        if inscribed <= 0.0 {
            return Err(ShapeError::NotAround);
        }
        if winds(corners) {
            return Err(ShapeError::Crosses);
        }
        Ok(Self { corners: corners.to_vec(), inscribed, circumscribed })
    }

    /// The rectangle of a robot.
    pub fn of(robot: &RobotDescription) -> Result<Self, ShapeError> {
        let (x, y) = (robot.length / 2.0, robot.width / 2.0);
        Self::new(&[[x, -y], [x, y], [-x, y], [-x, -y]])
    }

    /// Its corners in `base_link`, counter-clockwise.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners
    }

    /// Radius of the largest circle about `base_link` in it, metres.
    pub fn inscribed(&self) -> f64 {
        self.inscribed
    }

    /// Radius of the smallest circle about `base_link` that holds it, metres.
    pub fn circumscribed(&self) -> f64 {
        self.circumscribed
    }

    /// The footprint of a robot at `pose`.
    pub fn at(&self, pose: Pose2) -> Placed {
        let (sin, cos) = libm::sincos(pose.yaw);
        let mut placed =
            Placed { origin: [pose.x, pose.y], corners: [[0.0; 2]; MOST_CORNERS], count: self.corners.len() };
        for (to, from) in placed.corners.iter_mut().zip(&self.corners) {
            *to = [pose.x + cos * from[0] - sin * from[1], pose.y + sin * from[0] + cos * from[1]];
        }
        placed
    }
}

/// A footprint somewhere in the map.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    origin: [f64; 2],
    corners: [[f64; 2]; MOST_CORNERS],
    count: usize,
}

impl Placed {
    /// From its origin to another's, metres in `map`.
    pub fn to(&self, other: &Self) -> [f64; 2] {
        minus(other.origin, self.origin)
    }

    /// Whether a point is in it.
    pub fn holds(&self, point: MapPoint) -> bool {
        let left = |(a, b)| cross(minus(b, a), minus([point.x, point.y], a)) >= 0.0;
        edges(&self.corners[..self.count]).all(left)
    }
}

/// Something convex in the robot's way, standing or moving on straight.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    corners: Vec<[f64; 2]>,
    rounding: f64,
    velocity: [f64; 2],
    middle: [f64; 2],
    radius: f64,
}

/// How near a footprint is to an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Distance, metres; negative inside.
    pub distance: f64,
    /// Derivative of the distance by the robot's x, y and yaw.
    pub gradient: [f64; 3],
    /// Unit normal from the footprint to the obstacle.
    pub normal: [f64; 2],
}

impl Obstacle {
    /// Anything convex: the corners counter-clockwise, rounded by `rounding` metres, moving with `velocity` m/s in `map`.
    pub fn new(corners: &[MapPoint], rounding: f64, velocity: [f64; 2]) -> Result<Self, ShapeError> {
        let usable = |c: f64| c.is_finite() && c.abs() < 1e7;
        let numbers = corners.iter().flat_map(|c| [c.x, c.y]).chain(velocity);
        if corners.is_empty() || !numbers.into_iter().all(usable) || !(0.0..1e4).contains(&rounding) {
            return Err(ShapeError::NotFinite);
        }
        let corners: Vec<[f64; 2]> = corners.iter().map(|c| [c.x, c.y]).collect();
        for i in 0..corners.len() {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % corners.len()]);
            if corners.len() > 2 && cross(minus(b, a), minus(c, b)) < 0.0 {
                return Err(ShapeError::NotConvex((i + 1) % corners.len()));
            }
        }
        if winds(&corners) {
            return Err(ShapeError::Crosses);
        }
        let n = corners.len() as f64;
        let middle = corners.iter().fold([0.0; 2], |m, c| [m[0] + c[0] / n, m[1] + c[1] / n]);
        let radius = corners.iter().map(|c| norm(minus(*c, middle))).fold(0.0, f64::max) + rounding;
        Ok(Self { corners, rounding, velocity, middle, radius })
    }

    /// A disc that stands.
    pub fn disc(center: MapPoint, radius: f64) -> Result<Self, ShapeError> {
        Self::new(&[center], radius, [0.0; 2])
    }

    /// A wall without thickness.
    pub fn wall(from: MapPoint, to: MapPoint) -> Result<Self, ShapeError> {
        Self::new(&[from, to], 0.0, [0.0; 2])
    }

    /// A point around which it lies, now.
    pub fn middle(&self) -> MapPoint {
        MapPoint::new(self.middle[0], self.middle[1])
    }

    /// Distance from [`Obstacle::middle`] to the furthest of it, metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Its corners, counter-clockwise, and its rounding, metres.
    pub fn outline(&self) -> (impl Iterator<Item = MapPoint>, f64) {
        (self.corners.iter().map(|c| MapPoint::new(c[0], c[1])), self.rounding)
    }

    /// m/s in `map`.
    pub fn velocity(&self) -> [f64; 2] {
        self.velocity
    }

    /// Whether it moves.
    pub fn is_moving(&self) -> bool {
        self.velocity != [0.0; 2]
    }

    /// Where it will be after `seconds`, if it goes on as it does.
    pub fn after(&self, seconds: f64) -> Self {
        let by = [self.velocity[0] * seconds, self.velocity[1] * seconds];
        let moved = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        Self {
            corners: self.corners.iter().map(|c| moved(*c)).collect(),
            middle: moved(self.middle),
            ..*self
        }
    }

    /// Distance from a point, metres; negative inside.
    pub fn distance_to(&self, point: MapPoint) -> f64 {
        let point = [point.x, point.y];
        let mut nearest = norm(minus(point, self.corners[0]));
        let mut inside = self.corners.len() > 2;
        for (a, b) in edges(&self.corners) {
            nearest = nearest.min(norm(minus(point, foot(point, a, b))));
            inside &= cross(minus(b, a), minus(point, a)) > 0.0;
        }
        (if inside { -nearest } else { nearest }) - self.rounding
    }

    /// How near a footprint is to the obstacle as it will be after `seconds`, if that may be less than `reach` metres.
    #[inline]
    pub fn contact(&self, foot: &Placed, circumscribed: f64, seconds: f64, reach: f64) -> Option<Contact> {
        let shift = [self.velocity[0] * seconds, self.velocity[1] * seconds];
        let origin = minus(foot.origin, shift);
        let apart = minus(origin, self.middle);
        let far = self.radius + circumscribed + reach;
        if apart[0] * apart[0] + apart[1] * apart[1] > far * far {
            return None;
        }
        let mut corners = foot.corners;
        for corner in &mut corners[..foot.count] {
            *corner = minus(*corner, shift);
        }
        let touch = between(&corners[..foot.count], &self.corners);
        let arm = minus(touch.on_foot, origin);
        let n = touch.normal;
        // The distance is n . (obstacle - contact point), and the contact point turns about the robot.
        let gradient = [-n[0], -n[1], n[0] * arm[1] - n[1] * arm[0]];
        Some(Contact { distance: touch.distance - self.rounding, gradient, normal: n })
    }
}

/// Nearest or deepest points of two convex shapes.
struct Touch {
    distance: f64,
    /// From the footprint to the obstacle.
    normal: [f64; 2],
    on_foot: [f64; 2],
}

fn between(foot: &[[f64; 2]], other: &[[f64; 2]]) -> Touch {
    let mut best = Touch { distance: f64::NEG_INFINITY, normal: [1.0, 0.0], on_foot: foot[0] };
    let mut settled = false;
    for (a, b) in edges(foot) {
        let along = minus(b, a);
        let length = norm(along);
        let n = [along[1] / length, -along[0] / length];
        let (nearest, distance) = lowest(other, a, n);
        if distance > best.distance {
            let t = dot(minus(nearest, a), along) / (length * length);
            settled = (0.0..=1.0).contains(&t);
            let on_foot = minus(nearest, [n[0] * distance, n[1] * distance]);
            best = Touch { distance, normal: n, on_foot };
        }
    }
    for (a, b) in edges(other) {
        let along = minus(b, a);
        let length = norm(along);
        if length < 1e-12 {
            continue;
        }
        let n = [along[1] / length, -along[0] / length];
        let (nearest, distance) = lowest(foot, a, n);
        if distance > best.distance {
            let t = dot(minus(nearest, a), along) / (length * length);
            settled = (0.0..=1.0).contains(&t);
            best = Touch { distance, normal: [-n[0], -n[1]], on_foot: nearest };
        }
    }
    if best.distance <= 0.0 || settled { best } else { corner_to_corner(foot, other) }
}

/// The point of a shape that lies least far along `n` from `a`, and how far.
#[inline]
fn lowest(shape: &[[f64; 2]], a: [f64; 2], n: [f64; 2]) -> ([f64; 2], f64) {
    let mut low = (shape[0], dot(minus(shape[0], a), n));
    for &p in &shape[1..] {
        let d = dot(minus(p, a), n);
        if d < low.1 {
            low = (p, d);
        }
    }
    low
}

/// For shapes that are apart: the nearest pair of points, each an end of an edge or a point on one.
fn corner_to_corner(foot: &[[f64; 2]], other: &[[f64; 2]]) -> Touch {
    let mut best = (f64::INFINITY, foot[0], other[0]);
    let mut try_pair = |on_foot: [f64; 2], on_other: [f64; 2]| {
        let gap = minus(on_other, on_foot);
        let square = dot(gap, gap);
        if square < best.0 {
            best = (square, on_foot, on_other);
        }
    };
    for (a, b) in edges(foot) {
        other.iter().for_each(|&p| try_pair(self::foot(p, a, b), p));
    }
    for (a, b) in edges(other) {
        foot.iter().for_each(|&p| try_pair(p, self::foot(p, a, b)));
    }
    let (square, on_foot, on_other) = best;
    let distance = square.sqrt();
    let gap = minus(on_other, on_foot);
    Touch { distance, normal: [gap[0] / distance.max(1e-12), gap[1] / distance.max(1e-12)], on_foot }
}

/// The edges of a closed outline; both ways along a wall, none of a point.
fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let count = if corners.len() > 1 { corners.len() } else { 0 };
    (0..count).map(move |i| (corners[i], corners[if i + 1 == corners.len() { 0 } else { i + 1 }]))
}

/// Whether an outline whose corners all turn left does so more than once around, as a five-pointed star does.
fn winds(corners: &[[f64; 2]]) -> bool {
    let corner = |i: usize| corners[i % corners.len()];
    let turn = |i: usize| {
        let (along, next) = (minus(corner(i + 1), corner(i)), minus(corner(i + 2), corner(i + 1)));
        libm::atan2(cross(along, next).abs(), dot(along, next))
    };
    corners.len() > 4 && (0..corners.len()).map(turn).sum::<f64>() > 3.0 * std::f64::consts::PI
}

/// The point of the segment from `a` to `b` that is nearest to `p`.
fn foot(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let along = minus(b, a);
    let square = dot(along, along);
    let t = if square > 0.0 { (dot(minus(p, a), along) / square).clamp(0.0, 1.0) } else { 0.0 };
    [a[0] + t * along[0], a[1] + t * along[1]]
}

#[inline]
fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline]
fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[inline]
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn norm(a: [f64; 2]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn robot() -> Footprint {
        Footprint::of(&RobotDescription::sentry()).unwrap()
    }

    fn distance(pose: Pose2, obstacle: &Obstacle) -> f64 {
        let robot = robot();
        obstacle.contact(&robot.at(pose), robot.circumscribed(), 0.0, 100.0).unwrap().distance
    }

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    #[test]
    fn distances_of_a_rectangle_are_those_of_geometry() {
        let (half_length, half_width) = (0.16, 0.155);
        let stone = Obstacle::disc(point(1.0, 0.0), 0.2).unwrap();
        assert!((distance(Pose2::default(), &stone) - (1.0 - 0.2 - half_length)).abs() < 1e-12);
        let beside = Pose2::new(1.0, 1.0, 0.0);
        assert!((distance(beside, &stone) - (1.0 - 0.2 - half_width)).abs() < 1e-12);
        let post = Obstacle::disc(point(1.16, 1.155), 0.0).unwrap();
        assert!((distance(Pose2::default(), &post) - 2f64.sqrt()).abs() < 1e-12);
        let wall = Obstacle::wall(point(2.0, -9.0), point(2.0, 9.0)).unwrap();
        assert!((distance(Pose2::default(), &wall) - (2.0 - half_length)).abs() < 1e-12);
        // Inside: the shortest way out.
        assert!((distance(Pose2::new(1.05, 0.0, 0.0), &wall.after(1.0)) - 0.79).abs() < 1e-12);
        assert!((distance(Pose2::new(1.95, 0.0, 0.0), &wall) + (half_length - 0.05)).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_shape_is_refused() {
        let corners = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        assert!(Footprint::new(&corners).is_ok());
        assert_eq!(Footprint::new(&corners[..2]), Err(ShapeError::Corners(2)));
        let clockwise: Vec<_> = corners.iter().rev().copied().collect();
        assert!(matches!(Footprint::new(&clockwise), Err(ShapeError::NotConvex(_))));
        let aside: Vec<_> = corners.iter().map(|c| [c[0] + 3.0, c[1]]).collect();
        assert_eq!(Footprint::new(&aside), Err(ShapeError::NotAround));
        assert_eq!(Footprint::new(&[[f64::NAN, 0.0]; 3]), Err(ShapeError::NotFinite));
        assert!(Obstacle::disc(point(f64::NAN, 0.0), 1.0).is_err());
        assert!(Obstacle::disc(point(0.0, 0.0), -1.0).is_err());
        assert!(Obstacle::new(&[], 0.1, [0.0; 2]).is_err());
        let dent = [(0.0, 0.0), (2.0, 0.0), (0.5, 0.5), (0.0, 2.0)].map(|(x, y)| point(x, y));
        assert!(matches!(Obstacle::new(&dent, 0.0, [0.0; 2]), Err(ShapeError::NotConvex(_))));
        // A five-pointed star in one stroke turns left at every corner.
        let star = [0, 2, 4, 1, 3].map(|i| libm::sincos(std::f64::consts::TAU * f64::from(i) / 5.0));
        assert_eq!(Footprint::new(&star.map(|(sin, cos)| [cos, sin])), Err(ShapeError::Crosses));
        let star = star.map(|(sin, cos)| point(cos, sin));
        assert_eq!(Obstacle::new(&star, 0.0, [0.0; 2]), Err(ShapeError::Crosses));
    }

    fn convex() -> impl Strategy<Value = Obstacle> {
        let sides = 1..7_usize;
        (sides, 0.05..0.8_f64, -1.5..1.5_f64, -1.5..1.5_f64, 0.0..6.0_f64, 0.0..0.3_f64).prop_map(
            |(n, r, x, y, turn, rounding)| {
                let corner = |i: usize| {
                    let (sin, cos) = libm::sincos(turn + std::f64::consts::TAU * i as f64 / n as f64);
                    point(x + 1.5 * r * cos, y + r * sin)
                };
                Obstacle::new(&(0..n).map(corner).collect::<Vec<_>>(), rounding, [0.0; 2]).unwrap()
            },
        )
    }

    proptest! {
        #[test]
        fn distances_are_those_of_many_points_of_the_outlines(obstacle in convex(), x in -1.0..1.0_f64, y in -1.0..1.0_f64, yaw in -3.0..3.0_f64) {
            let (robot, pose) = (robot(), Pose2::new(x, y, yaw));
            let found = distance(pose, &obstacle);
            let outline: Vec<[f64; 2]> = edges(robot.corners()).flat_map(|(a, b)| (0..200).map(move |i| {
                let t = f64::from(i) / 200.0;
                [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
            })).collect();
            let least = outline.iter().map(|p| obstacle.distance_to(pose.transform(p[0], p[1]))).fold(f64::INFINITY, f64::min);
            if found > 0.0 {
                prop_assert!(least >= found - 1e-9 && least < found + 2e-3, "{found} {least}");
            } else {
                // Overlapping without rounding: moved out by as much along the normal, they touch.
                let contact = obstacle.contact(&robot.at(pose), robot.circumscribed(), 0.0, 9.0).unwrap();
                let out = Pose2::new(x + contact.normal[0] * found, y + contact.normal[1] * found, yaw);
                prop_assert!(distance(out, &obstacle).abs() < 1e-9 || obstacle.rounding > 0.0);
            }
        }

        #[test]
        fn gradients_are_those_of_finite_differences(obstacle in convex(), x in -1.0..1.0_f64, y in -1.0..1.0_f64, yaw in -3.0..3.0_f64) {
            const STEP: f64 = 1e-6;
            let robot = robot();
            let contact = obstacle.contact(&robot.at(Pose2::new(x, y, yaw)), robot.circumscribed(), 0.0, 9.0).unwrap();
            let at = |dx: f64, dy: f64, turn: f64| distance(Pose2::new(x + dx, y + dy, yaw + turn), &obstacle);
            let numeric = [at(STEP, 0.0, 0.0), at(0.0, STEP, 0.0), at(0.0, 0.0, STEP)].map(|d| (d - contact.distance) / STEP);
            let back = [at(-STEP, 0.0, 0.0), at(0.0, -STEP, 0.0), at(0.0, 0.0, -STEP)].map(|d| (contact.distance - d) / STEP);
            for k in 0..3 {
                // Where the nearest edge changes there is no derivative.
                let smooth = (numeric[k] - back[k]).abs() < 1e-4;
                prop_assert!(!smooth || (contact.gradient[k] - numeric[k]).abs() < 1e-3, "{contact:?} {numeric:?}");
            }
        }
    }
}
