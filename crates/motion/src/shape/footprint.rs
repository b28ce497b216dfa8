//! The robot's outline, and where it is.

use openbench_core::{MapPoint, Pose2, RobotDescription};

use super::distance::{edges, winds_twice};
use super::error::{MOST_CORNERS, ShapeError};
use crate::vector::Vector2;

/// Coordinates beyond this are no robot's, metres.
const LARGEST: f64 = 1e3;

/// The robot's outline in `base_link`: convex, counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    corners: Vec<Vector2>,
    inscribed: f64,
    circumscribed: f64,
}

impl Footprint {
    /// A footprint from its corners in `base_link`, metres, counter-clockwise.
    pub fn new(corners: &[Vector2]) -> Result<Self, ShapeError> {
        if !(3..=MOST_CORNERS).contains(&corners.len()) {
            return Err(ShapeError::Corners(corners.len()));
        }
        if !corners.iter().all(|c| c.is_within(LARGEST)) {
            return Err(ShapeError::NotFinite);
        }
        let mut inscribed = f64::INFINITY;
        for (i, edge) in edges(corners).enumerate() {
            let (along, next) = (edge.along(), corners[(i + 2) % corners.len()] - edge.to);
            if along.cross(next) <= 0.0 {
                return Err(ShapeError::NotConvex((i + 1) % corners.len()));
            }
            // Distance from the edge to the origin, positive on the inner side.
            inscribed = inscribed.min(along.cross(Vector2::ZERO - edge.from) / along.norm());
        }
        if inscribed <= 0.0 {
            return Err(ShapeError::NotAround);
        }
        if winds_twice(corners) {
            return Err(ShapeError::Crosses);
        }
        let circumscribed = corners.iter().map(|c| c.norm()).fold(0.0, f64::max);
        Ok(Self {
            corners: corners.to_vec(),
            inscribed,
            circumscribed,
        })
    }

    /// The rectangle of a robot.
    pub fn of(robot: &RobotDescription) -> Result<Self, ShapeError> {
        let (x, y) = (robot.length / 2.0, robot.width / 2.0);
        let corner = Vector2::new;
        Self::new(&[corner(x, -y), corner(x, y), corner(-x, y), corner(-x, -y)])
    }

    /// Its corners in `base_link`, metres, counter-clockwise.
    pub fn corners(&self) -> &[Vector2] {
        &self.corners
    }

    /// Radius of the largest circle about the origin of `base_link` inside it, metres.
    pub fn inscribed(&self) -> f64 {
        self.inscribed
    }

    /// Radius of the smallest circle about the origin of `base_link` around it, metres.
    pub fn circumscribed(&self) -> f64 {
        self.circumscribed
    }

    /// The footprint of a robot at `pose`.
    pub(crate) fn at(&self, pose: Pose2) -> Placed {
        let (sin, cos) = libm::sincos(pose.yaw);
        let mut placed = Placed {
            origin: Vector2::new(pose.x, pose.y),
            corners: [Vector2::ZERO; MOST_CORNERS],
            count: self.corners.len(),
        };
        for (to, from) in placed.corners.iter_mut().zip(&self.corners) {
            to.x = pose.x + cos * from.x - sin * from.y;
            to.y = pose.y + sin * from.x + cos * from.y;
        }
        placed
    }
}

/// A footprint somewhere in `map`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    pub(super) origin: Vector2,
    corners: [Vector2; MOST_CORNERS],
    count: usize,
}

impl Placed {
    /// From its origin to another's, metres in `map`.
    pub(crate) fn to(&self, other: &Self) -> Vector2 {
        other.origin - self.origin
    }

    /// Whether a point is in it.
    pub(crate) fn holds(&self, point: MapPoint) -> bool {
        let point = Vector2::to(point);
        edges(self.corners()).all(|edge| edge.along().cross(point - edge.from) >= 0.0)
    }

    /// Its corners displaced by `-shift`, in `room`: a whole `Placed` would be copied twice.
    #[inline]
    pub(super) fn corners_moved_back<'a>(
        &self,
        shift: Vector2,
        room: &'a mut [Vector2; MOST_CORNERS],
    ) -> &'a [Vector2] {
        let moved = &mut room[..self.count];
        for (to, from) in moved.iter_mut().zip(self.corners()) {
            *to = *from - shift;
        }
        moved
    }

    #[inline]
    pub(super) fn corners(&self) -> &[Vector2] {
        &self.corners[..self.count]
    }
}
