#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | module | its one job |
//! |---|---|
//! | [`shape`] | [`Footprint`] and [`Obstacle`]: outlines on the ground and their distances |
//! | [`limits`] | [`Limits`]: what a robot can do |
//! | [`kinematics`] | [`Motion`]: how a differential drive moves, and along which arcs |
//! | [`trajectory`] | [`Band`]: poses at times |
//! | [`feasible`] | whether a motion keeps off everything |
//! | [`obstacles`] | [`RangeRing`]: one LiDAR scan as obstacles around the robot and free beams |
//! | [`costmap`] | [`Costmap`]: buildings of the map and what the LiDAR saw, inflated |
//! | [`search`] | [`Search`]: A* over any cells with costs, for maps of a million of them |
//! | [`astar`] | [`plan`]: the cheapest path over a costmap |
//! | [`local`] | [`LocalPlanner`]: the trait of local planners, and the planners by name |
//! | [`teb`] | [`Teb`]: Timed Elastic Bands in several homotopy classes |
//! | [`mppi`] | [`Mppi`]: Model Predictive Path Integral control, for comparison |
//! | [`follower`] | [`Follower`]: pure pursuit that stops before obstacles, for comparison |
//! | [`people`] | [`Tracker`]: moving bodies, and how to drive near people |
//! | [`recovery`] | what to do where a local planner does not go on |
//! | [`route`] | [`Guide`]: the path to a goal, searched again when it is old or blocked |
//! | [`surroundings`] | [`Surroundings`]: what the robot knows of itself and what is around it |
//! | [`navigator`] | [`Navigator`]: to a goal along a path by a local planner, with recovery |
//! | [`vector`] | [`Vector2`]: a displacement or velocity on the ground |
//! | [`checks`] | [`SettingsError`]: limits and settings that make no sense |

pub mod astar;
pub mod checks;
pub mod costmap;
pub mod feasible;
pub mod follower;
pub mod kinematics;
pub mod limits;
pub mod local;
pub mod mppi;
pub mod navigator;
mod near_cells;
pub mod obstacles;
pub mod people;
pub mod recovery;
pub mod route;
pub mod search;
pub mod shape;
pub mod surroundings;
pub mod teb;
pub mod trajectory;
pub mod vector;

pub use astar::{PlanError, costs, plan};
pub use checks::SettingsError;
pub use costmap::{Costmap, CostmapError};
pub use follower::{Follower, FollowerError};
pub use kinematics::Motion;
pub use limits::Limits;
pub use local::{Blocked, LocalPlanner, LocalPlanners, PlannerSettings, Progress, Situation};
pub use mppi::{Mppi, MppiError};
pub use navigator::{Navigation, Navigator};
pub use obstacles::{RangeRing, ScanPoint};
pub use people::Tracker;
pub use route::Guide;
pub use search::{Costs, CostsError, Search};
pub use shape::{Contact, Footprint, Obstacle, ShapeError};
pub use surroundings::Surroundings;
pub use teb::planner::{Teb, TebError};
pub use teb::settings::TebSettings;
pub use trajectory::{Band, Knot};
pub use vector::Vector2;
