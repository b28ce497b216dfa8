//! The map: space in cubes of three sizes, and in each the plane that its points lie on.
//!
//! After C. Yuan, W. Xu, X. Liu, X. Hong, F. Zhang, *Efficient and Probabilistic Adaptive Voxel
//! Mapping for Accurate Online LiDAR Odometry*, 2022 (VoxelMap). A point's plane is looked up, not
//! searched for. A plane is the more certain the more points it has, and says how certain it is.
//! Here no points are kept, only their number, sum and second moments, from which the plane
//! follows.
//!
//! | module | contents |
//! |---|---|
//! | `place` | [`Place`]: a cube of the grid |
//! | `plane` | [`Plane`], and how certain it is |
//! | `cube` | points of a cube, and the plane fitted to them |
//! | `map` | [`PlaneMap`]: all cubes |

mod cube;
mod map;
mod place;
mod plane;

pub(super) use cube::Rays;
pub use map::PlaneMap;
pub use place::Place;
pub(super) use place::{CORNER_M, SIDES_M, SIZES};
pub use plane::Plane;
