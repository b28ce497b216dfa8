//! Where the robot is, from what its sensors say.
//!
//! | module | its one job |
//! |---|---|
//! | [`dead_reckoning`] | [`DeadReckoning`]: wheels for the way, gyroscope for the heading, from a known start |
//! | [`graph`] | pose graphs |
//! | [`lio`] | LiDAR-inertial odometry |
//! | [`wheels`] | wheels' angles as velocities |
//! | [`lidar_inertial`] | [`LidarInertial`]: that odometry with wheels, from a known start |
//! | [`fixes`] | [`FixSource`]: what says where the robot is in `map`; [`Gnss`](fixes::Gnss) |
//! | [`fused`] | [`Fused`]: odometry and fixes in a pose graph |
//!
//! [`Localizer`] is the seam: agents know only it.

pub mod dead_reckoning;
mod deviation;
pub mod fixes;
pub mod fused;
pub mod graph;
mod history;
pub mod lidar_inertial;
pub mod lio;
pub mod wheels;

use nalgebra::Matrix3;
use openbench_core::{Health, Observation, Pose2, SimTime};

pub use dead_reckoning::DeadReckoning;
pub use fixes::{Fix, FixSource};
pub use fused::Fused;
pub use lidar_inertial::LidarInertial;

/// Tells where the robot is. Given each observation in turn.
pub trait Localizer {
    /// Short name, as in results.
    fn name(&self) -> &str;

    /// Begins anew at `start` in `map`.
    fn reset(&mut self, start: Pose2);

    /// Takes in what the sensors delivered.
    fn update(&mut self, observation: &Observation<'_>);

    /// Pose of `base_link` in `map` at an instant not long ago: within the last second, else the nearest known.
    fn pose_at(&self, time: SimTime) -> Pose2;

    /// The newest pose of `base_link` in `map`.
    fn pose(&self) -> Pose2;

    /// Whether the pose can be trusted already; a robot does better to stand still until then.
    fn ready(&self) -> bool;

    /// How far the pose can be trusted. It must not say [`Health::Good`] more than two seconds after trouble began.
    fn health(&self) -> Health {
        Health::Good
    }

    /// Pose of `odom` in `map` (REP 105). It changes with corrections only: what is planned in `odom` stays where the robot sees it. They are the same where nothing
    /// corrects.
    fn odom(&self) -> Pose2 {
        Pose2::default()
    }

    /// Covariance of the newest pose as of the last scan: x and y in `map`, yaw; m² and rad². `None` if it does not say.
    fn covariance(&self) -> Option<Matrix3<f64>> {
        None
    }

    /// How far the newest pose is from where the robot is thought to be, metres: corrections are passed on slowly, and this says what is still to come.
    fn pending(&self) -> f64 {
        0.0
    }
}
