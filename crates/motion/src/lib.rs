//! From a pose and obstacles to a velocity.
//!
//! | module | its one job |
//! |---|---|
//! | [`obstacles`] | [`RangeRing`]: one LiDAR scan as what stands in the robot's way, and how far it is clear |
//! | [`costmap`] | [`Costmap`]: buildings of the map and what the LiDAR saw, inflated |
//! | [`shape`] | [`Footprint`] and [`Obstacle`]: outlines on the ground and how far they are apart |
//! | [`search`] | [`Search`]: A* over any cells with costs, for maps of a million of them |
//! | [`astar`] | [`plan`]: the cheapest way over a costmap |
//! | [`tracking`] | [`Tracker`]: who moves, from what appears where the ground was free |
//! | [`local`] | [`LocalPlanner`]: the seam between a way and velocities |
//! | [`teb`] | [`Teb`]: Timed Elastic Bands in several classes of ways |
//! | [`maneuver`] | places and headings searched with the whole footprint, where a way says too little |
//! | [`evade`] | out of the way of those who move |
//! | [`yielding`] | whose way it is: ground that somebody is about to walk over |
//! | [`leave`] | off what is all but touched |
//! | [`feasible`] | whether a motion keeps off everything |
//! | [`navigator`] | [`Navigator`]: to a goal, with a ladder of what to do when a planner does not go on |
//! | [`mppi`] | [`Mppi`]: many disturbed continuations, averaged; a yardstick |
//! | [`follower`] | [`Follower`]: pure pursuit that stops before obstacles; a yardstick too |

pub mod astar;
pub mod costmap;
pub mod evade;
pub mod feasible;
pub mod follower;
pub mod leave;
pub mod local;
pub mod maneuver;
pub mod mppi;
pub mod navigator;
pub mod obstacles;
pub mod search;
pub mod shape;
pub mod teb;
pub mod tracking;
pub mod yielding;

pub use astar::{PlanError, costs, plan};
pub use costmap::{Costmap, CostmapError};
pub use follower::{Follower, FollowerError};
pub use local::{Blocked, LocalPlanner, Progress, Situation};
pub use mppi::{Mppi, MppiError};
pub use navigator::{Guide, Navigation, Navigator, Surroundings};
pub use obstacles::RangeRing;
pub use search::{Costs, CostsError, Search};
pub use shape::{Contact, Footprint, Obstacle, ShapeError};
pub use teb::planner::{Teb, TebError, TebSettings};
pub use tracking::Tracker;
