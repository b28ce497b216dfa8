#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | module | what it does |
//! |---|---|
//! | [`geometry`] | [`GridGeometry`]: cells and map points |
//! | [`sight`] | [`in_sight`], [`passes_all`]: straight lines over cells |
//! | [`frontier`] | [`Frontier`]: the next cell of a search |
//! | [`distance_transform`] | [`squared_distances`]: exact Euclidean distances |

pub mod distance_transform;
pub mod frontier;
pub mod geometry;
pub mod sight;

pub use distance_transform::squared_distances;
pub use frontier::Frontier;
pub use geometry::GridGeometry;
pub use sight::{in_sight, passes_all};
