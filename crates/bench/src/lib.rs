//! The benchmark: suites and worlds, running, scoring, reports.
//!
//! | module | its one job |
//! |---|---|
//! | [`suite`] | [`Suite`], [`Episode`], [`WorldSource`]: what is run, as files |
//! | [`worlds`] | [`Prepared`]: worlds loaded and doors looked up; worlds as folders |
//! | [`mod@run`] | [`Rollout`]: agents drive episodes, and what happens is kept |
//! | [`score`] | [`Results`]: from what happened to numbers |
//! | [`report`] | results for people |
//! | [`error`] | [`BenchError`] |
//! | [`image_file`] | images as JPEG and PNG |
//! | [`line_problem`] | what is wrong with a line of a text file |

pub mod error;
pub mod image_file;
pub mod line_problem;
mod plural;
pub mod report;
pub mod run;
pub mod score;
pub mod suite;
pub mod worlds;

pub use error::BenchError;
pub use openbench_sim::traffic::TrafficPlan;
pub use run::{
    AgentFactory, AgentRequest, Agents, Disturbance, DisturbanceError, DisturbedTruth,
    EpisodeTrace, Faults, Level, MEMORY_BEFORE, Observer, Rollout, RunRequest, Status, TruthHandle,
    TruthLocalizer, memory_of, repeat, run,
};
pub use score::Results;
pub use suite::builtin::builtin_suites;
pub use suite::{Episode, Sensors, Suite, WorldSource};
pub use worlds::{Prepared, builtin_suite};
