//! Pose graphs: the poses that agree best with the motions measured between them.
//!
//! | module | contents |
//! |---|---|
//! | `pose` | poses in the plane and in space, as Lie groups |
//! | `problem` | [`Graph`]: poses, edges, priors |
//! | `solve` | the least squares of a graph |
//! | `sparse` | its normal equations |
//! | `window` | [`Window`]: the newest poses of a drive, with outlier rejection |
//! | `g2o` | [`PoseGraph`]: files |

mod g2o;
mod pose;
mod problem;
mod solve;
mod sparse;
mod window;

pub use g2o::{G2oError, GraphSize, LineError, NumberedGraph, PoseGraph};
pub use pose::Pose;
pub use problem::{Edge, Graph, Prior};
pub use solve::{SolveError, Solved};
pub use window::{FixCount, Window};
