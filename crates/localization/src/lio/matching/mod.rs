//! Which points of a scan lie on which planes of the map, as sums: what a plane's points say needs
//! no more than their moments.
//!
//! A point's distance from a plane and its Jacobian are linear in the point. All that a filter adds
//! up over a plane's points therefore follows from the moments of these points, at whatever pose
//! the filter has come to (Z. Liu, X. Liu, F. Zhang, *Efficient and Consistent Bundle Adjustment on
//! Lidar Point Clouds*, 2023, call them point clusters). A scan is searched once, not once an
//! iteration, and all its points count.
//!
//! | module | contents |
//! |---|---|
//! | `cluster` | [`Cluster`]: points of one cube, and the plane that they lie on |
//! | `gate` | which points lie on a plane |
//! | `cube_order` | a scan's points in the order of their cubes |
//! | `search` | cubes searched from the largest to the smallest |
//! | `matcher` | [`Matching`]: the clusters of a scan |

mod cluster;
mod cube_order;
mod gate;
mod matcher;
mod search;

pub use cluster::{Cluster, PlaneObservation};
pub use matcher::Matching;
