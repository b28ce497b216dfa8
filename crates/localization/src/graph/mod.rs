//! Pose graphs: poses, and what is measured between them, brought into agreement.
//!
//! | module | its one job |
//! |---|---|
//! | [`pose`] | poses in the plane and in space, as Lie groups |
//! | [`problem`] | [`Graph`]: poses, edges, priors |
//! | [`solve`] | the least squares of a graph |
//! | [`window`] | [`Window`]: the newest poses of a drive without an end |
//! | `sparse` | its normal equations |
//! | [`g2o`] | files |

pub mod g2o;
pub mod pose;
pub mod problem;
pub mod solve;
mod sparse;
pub mod window;

pub use g2o::{G2oError, GraphSize, LineError, NumberedGraph, PoseGraph};
pub use pose::Pose;
pub use problem::{Edge, Graph, Prior};
pub use solve::{SolveError, Solved};
pub use window::{FixCount, Window};
