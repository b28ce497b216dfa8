#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | contents |
//! |---|---|
//! | `localizer` | [`Localizer`]: what every localizer offers; agents know only it |
//! | `dead_reckoning` | [`DeadReckoning`]: distance from wheels, heading from the gyroscope |
//! | `track` | [`Track`]: where the robot was while a scan was taken |
//! | [`lio`] | LiDAR-inertial odometry |
//! | [`lidar_inertial`] | [`LidarInertial`]: that odometry with wheels, from a known start |
//! | [`wheels`] | wheel angles as velocities |
//! | [`graph`] | pose graphs |
//! | [`fixes`] | [`FixSource`]: poses in `map` that do not drift; [`Gnss`](fixes::Gnss) |
//! | [`registration`] | LiDAR scans against the public map |
//! | `fused` | [`Fused`]: odometry and fixes in a pose graph |

mod dead_reckoning;
mod deviation;
pub mod fixes;
mod fused;
pub mod graph;
mod history;
pub mod lidar_inertial;
pub mod lio;
mod localizer;
mod reckoned;
pub mod registration;
mod so3;
mod track;
pub mod wheels;

pub use dead_reckoning::DeadReckoning;
pub use deviation::PoseDeviation;
pub use fixes::{Fix, FixSource, Presumption};
pub use fused::Fused;
pub use lidar_inertial::LidarInertial;
pub use localizer::Localizer;
pub use track::Track;
