//! From a pose and obstacles to a velocity.
//!
//! | module | its one job |
//! |---|---|
//! | [`obstacles`] | [`RangeRing`]: one LiDAR scan as what stands in the robot's way, and how far it is clear |
//! | [`costmap`] | [`Costmap`]: buildings of the map and what the LiDAR saw, inflated |
//! | [`search`] | [`Search`]: A* over any cells with costs, for maps of a million of them |
//! | [`astar`] | [`plan`]: the cheapest way over a costmap |
//! | [`follower`] | [`Follower`]: drives along a way and stops before obstacles; [`PathFollower`] is the seam |

pub mod astar;
pub mod costmap;
pub mod follower;
pub mod obstacles;
pub mod search;

pub use astar::{PlanError, costs, plan};
pub use costmap::{Costmap, CostmapError};
pub use follower::{Blocked, FollowInput, Follower, PathFollower, Progress};
pub use obstacles::RangeRing;
pub use search::{Costs, CostsError, Search};
