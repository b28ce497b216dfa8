#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | module | contents |
//! |---|---|
//! | [`costmap`] | [`Costmap`]: buildings of the map and LiDAR data, inflated; [`plan`] searches it |
//! | [`local`] | [`LocalPlanner`]: the trait of local planners, and the planners by name |
//! | [`teb`] | [`Teb`]: Timed Elastic Bands in several homotopy classes |
//! | [`follower`] | [`Follower`]: pure pursuit that stops before obstacles, for comparison |
//! | [`trajectory`] | [`Trajectory`]: poses at times |
//! | [`kinematics`] | [`Motion`]: how a differential drive moves, and along which arcs |
//! | [`feasible`] | whether a motion keeps its distance from all obstacles |
//! | [`recovery`] | what to do where a local planner does not drive on |
//!
//! At the top level are, besides: [`Footprint`] and [`Obstacle`], outlines on the ground with
//! their distances; [`RangeRing`], a LiDAR scan as obstacles and free beams; [`Search`], A* over
//! any cells with costs; [`Tracker`] of moving bodies; [`Mppi`], Model Predictive Path Integral
//! control for comparison; [`Navigator`], which drives to a goal along the path of a [`Guide`]
//! with a local planner and recovery.

mod astar;
mod checks;
pub mod costmap;
pub mod feasible;
pub mod follower;
pub mod kinematics;
mod limits;
pub mod local;
mod mppi;
mod navigator;
mod near_cells;
mod obstacles;
mod people;
pub mod recovery;
mod route;
mod search;
mod shape;
mod surroundings;
pub mod teb;
pub mod trajectory;
mod vector;

pub use astar::{PlanError, costs, plan};
pub use checks::SettingsError;
pub use costmap::{Costmap, CostmapError};
pub use follower::{Follower, FollowerError};
pub use kinematics::Motion;
pub use limits::Limits;
pub use local::{Blocked, LocalPlanner, LocalPlanners, PlannerSettings, Progress, Situation};
pub use mppi::{Mppi, MppiError};
pub use navigator::{FailureReason, Navigation, Navigator, NavigatorError};
pub use obstacles::{Beam, RangeRing, ScanPoint};
pub use people::{NewPoints, Tracker};
pub use route::Guide;
pub use search::{Costs, CostsError, GridPath, Search};
pub use shape::{Footprint, Obstacle, ShapeError};
pub use surroundings::Surroundings;
pub use teb::{Teb, TebError, TebSettings};
pub use trajectory::{TimedPose, Trajectory};
pub use vector::Vector2;
