//! Grids of square cells over the ground.
//!
//! | file | what it does |
//! |---|---|
//! | `cells` | [`GridGeometry`]: cells and map points |
//! | `sight` | [`in_sight`], [`passes_all`]: straight lines over cells |
//! | `frontier` | [`Frontier`]: the next cell of a search |
//! | `distance_transform` | [`squared_distances`]: exact Euclidean distances |

mod cells;
mod distance_transform;
mod frontier;
mod sight;

pub use cells::{GridGeometry, NEIGHBOURS};
pub use distance_transform::squared_distances;
pub use frontier::Frontier;
pub use sight::{in_sight, passes_all};
