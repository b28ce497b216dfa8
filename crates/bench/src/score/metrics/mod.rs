//! The metrics, as functions of plain values.
//!
//! Every metric has two readings. *Paper*: the robot declared within 10 m of the plate; path lengths are compared with
//! a straight line. *Strict*: within 2 m of the right door's approach point with no other door's nearer; path lengths
//! are compared with the shortest path that the robot's footprint can drive.
//!
//! | module | metric |
//! |---|---|
//! | [`success`] | whether a delivery succeeded, in both readings |
//! | [`mod@path_ratio`] | SPL: success weighted by path length |
//! | [`sequence`] | LSR and LSPL: the same over sequences, where an early failure weighs more |
//! | [`mod@srtp`] | SRTP: share of instructions that were understood exactly |
//! | [`collisions`] | collisions by class, with their impulses |
//! | [`encounters`] | near misses with people and cars, and time spent too near to people |
//! | [`smoothness`] | how much the robot turns, speeds up and down, and stops |
//! | [`doors`] | doors that an agent wrote into its map |
//! | [`mod@localization`] | how far the agent was from where it believed to be |
//! | [`consistency`] | whether odometry is as far off as its covariance says |
//! | [`summary`] | all of them over the deliveries of a run, with intervals |

pub mod collisions;
pub mod consistency;
pub mod doors;
pub mod encounters;
pub mod localization;
pub mod path_ratio;
pub mod sequence;
pub mod smoothness;
pub mod srtp;
pub mod success;
pub mod summary;

pub use collisions::CollisionSum;
pub use consistency::{Nees, nees};
pub use doors::{DoorScore, score_doors};
pub use encounters::EncounterSum;
pub use localization::{ErrorCounts, LocalizationSum, PoseError};
pub use path_ratio::{path_ratio, spl};
pub use sequence::{sequence_mean, sequence_weights};
pub use smoothness::{Smoothness, SmoothnessSum};
pub use srtp::{ExpectedPlan, srtp};
pub use success::{Strict, paper_success};
pub use summary::{RunTotals, summarize};
