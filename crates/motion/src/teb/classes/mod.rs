//! Homotopy classes: paths that cannot be deformed into each other without passing through an
//! obstacle.
//!
//! Obstacles too near each other for the robot to pass between are one cluster. From each cluster a
//! ray goes north; how often a path crosses the rays, eastwards less westwards, is its
//! [`Signature`]. Paths with the same ends and different signatures are of different classes (the
//! invariant is that of S. Bhattacharya et al., *Topological constraints in search-based robot path
//! planning*, 2012; C. Roesmann et al., *Integrated online trajectory planning and optimization in
//! distinctive topologies*, 2017, distinguish bands by it). A* over cells *and* signatures finds
//! the cheapest path of each of the cheapest classes in one search.
//!
//! | module | contents |
//! |---|---|
//! | `signature` | [`Signature`] and [`Clusters`]: which class a path is of |
//! | `explorer` | [`Explorer`]: the cheapest path of each class |
//! | `search` | A* over cells and signatures |
//! | `crossings` | the rays that a step between columns crosses |

mod crossings;
mod explorer;
mod search;
mod signature;

pub use explorer::{ClassPath, Explorer, Exploring};
pub use signature::{Clusters, Passing, Signature};
