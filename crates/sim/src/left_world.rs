//! Whether the robot has left its world.

use openbench_core::{MapPoint, Pose3};
use openbench_geometry::Bounds;

/// Why the robot can no longer take part in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LeftWorld {
    /// No ground is under it, or it has fallen off the ground.
    #[error("the robot drove off the ground of the world")]
    OffTheGround,
    /// It is far outside the world's static objects, or its position is NaN or infinite.
    #[error("the robot drove out of the world")]
    OutOfBounds,
    /// It lies on its side or back.
    #[error("the robot has tipped over")]
    TippedOver,
}

/// A robot farther than this outside the bounds is out of the world, metres.
const OUTSIDE_M: f64 = 50.0;
/// A robot farther than this below the ground of its start has fallen off, metres.
const FALLEN_M: f64 = 2.0;
/// Cosine of the largest tilt at which the wheels still carry the robot: 60 degrees.
const TIPPED_COSINE: f64 = 0.5;

/// How a robot at `base_link` has left a world with these bounds, if it has. `ground` is the
/// height of the ground at its start, metres.
pub(crate) fn left_world(base_link: &Pose3, bounds: &Bounds, ground: f64) -> Option<LeftWorld> {
    let [x, y, z] = base_link.translation.vector.into();
    // "Not inside" rather than "outside", and first: comparisons with NaN are false.
    if !(z.is_finite() && bounds.holds(MapPoint::new(x, y), OUTSIDE_M)) {
        return Some(LeftWorld::OutOfBounds);
    }
    if (base_link.rotation * nalgebra::Vector3::z()).z < TIPPED_COSINE {
        return Some(LeftWorld::TippedOver);
    }
    (z < ground - FALLEN_M).then_some(LeftWorld::OffTheGround)
}
