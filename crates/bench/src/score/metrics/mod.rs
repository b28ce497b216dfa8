//! The metrics, as functions of plain values.
//!
//! Success has two criteria. *Paper*: the robot declared within 10 m of the plate; path lengths are
//! compared with a straight line. *Strict*: within 2 m of the correct door's approach point, with
//! no other door's approach point nearer; path lengths are compared with the shortest path that the
//! robot's footprint can drive.
//!
//! | module | metric |
//! |---|---|
//! | [`success`] | success of a delivery, by both criteria |
//! | [`mod@path_ratio`] | SPL: success weighted by path length |
//! | [`sequence`] | LSR and LSPL: the same over sequences, where earlier deliveries weigh more |
//! | [`mod@srtp`] | SRTP: share of instructions with exactly the right plan |
//! | [`collisions`] | collisions by class, with their impulses |
//! | [`encounters`] | near misses with people and cars, time in people's personal space |
//! | [`doors`] | doors that an agent added to its map |
//! | [`mod@localization`] | localization errors |
//! | [`consistency`] | consistency of odometry errors with their covariances |
//! | `values` | what a delivery contributes to them |
//! | [`summary`] | all metrics over the deliveries of a run, with intervals |

pub mod collisions;
pub mod consistency;
pub mod doors;
pub mod encounters;
pub mod localization;
pub mod path_ratio;
pub mod sequence;
pub mod srtp;
pub mod success;
pub mod summary;
pub(crate) mod values;

pub use collisions::CollisionSum;
pub use consistency::{EstimatedPose, Nees, StampedPose, nees};
pub use doors::{DoorScore, score_doors};
pub use encounters::EncounterSum;
pub use localization::{ErrorCounts, LocalizationSum};
pub use path_ratio::{path_ratio, spl};
pub use sequence::sequence_mean;
pub use srtp::{ExpectedPlan, PAPER_SRTP, Understood};
pub use success::{Strict, paper_success};
pub use summary::{RunTotals, summarize};
