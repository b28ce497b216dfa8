#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | module | what it does |
//! |---|---|
//! | `segment` | [`Segment`]: lengths, nearest points, crossings |
//! | [`mod@line`] | lines through points: lengths, parallels |
//! | `turn` | [`turn`]: on which side of a line a point is |
//! | `bounds` | [`Bounds`]: axis-aligned boxes |
//! | [`polygon`] | [`Polygon`]: outlines with holes |
//! | [`grid`] | cells over the ground: lines of sight, distances, searches |

mod bounds;
pub mod grid;
pub mod line;
pub mod polygon;
mod segment;
mod turn;

pub use bounds::Bounds;
pub use polygon::{BoundaryPoint, Polygon, signed_area};
pub use segment::{Crossing, FootPoint, Segment, segments, sides};
pub use turn::turn;
