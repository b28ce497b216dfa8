//! Why corners make no shape.

/// Most corners of a footprint.
pub(crate) const MOST_CORNERS: usize = 16;

/// Corners make no shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    #[error("the footprint does not contain the origin of base_link, about which the robot turns")]
    NotAround,
    /// NaN, infinity, an impossible number, or a negative rounding.
    #[error("a corner, rounding or speed of a shape is NaN, infinite or impossible")]
    NotFinite,
}
