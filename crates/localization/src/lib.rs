//! Where the robot is, from what its sensors say.
//!
//! | module | its one job |
//! |---|---|
//! | [`dead_reckoning`] | [`DeadReckoning`]: wheels for the way, gyroscope for the heading, from a known start |
//! | [`graph`] | pose graphs |
//! | [`lio`] | LiDAR-inertial odometry |
//! | [`wheels`] | wheels' angles as velocities |
//! | [`lidar_inertial`] | [`LidarInertial`]: that odometry with wheels, from a known start |
//!
//! [`Localizer`] is the seam: agents know only it.

pub mod dead_reckoning;
pub mod graph;
mod history;
pub mod lidar_inertial;
pub mod lio;
pub mod wheels;

use openbench_core::{Observation, Pose2, SimTime};

pub use dead_reckoning::DeadReckoning;
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
}
