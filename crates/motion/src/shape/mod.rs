//! Shapes on the ground: the robot's footprint, standing and moving obstacles, and their distances.
//!
//! Every obstacle is convex with an optional rounding: one corner is a disc, two are a wall, more
//! a polygon. A concave thing is several obstacles. Distances are exact and signed: the Euclidean
//! distance between separate shapes; for overlapping shapes minus the shortest displacement along
//! an edge's normal that separates them (separating axes).
//!
//! | module | contents |
//! |---|---|
//! | `footprint` | [`Footprint`]: the robot's outline, and where it is |
//! | `obstacle` | [`Obstacle`]: something convex that stands or moves |
//! | `distance` | distance and contact of two convex outlines |
//! | `error` | [`ShapeError`]: corners that make no shape |

mod distance;
mod error;
mod footprint;
mod obstacle;

pub use error::ShapeError;
pub use footprint::Footprint;
pub(crate) use footprint::Placed;
pub use obstacle::Obstacle;
pub(crate) use obstacle::{moving, standing};
