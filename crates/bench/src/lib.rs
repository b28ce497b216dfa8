#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | content |
//! |---|---|
//! | [`suite`] | [`Suite`], [`Episode`], [`WorldSource`]: the input of a run, as files |
//! | [`worlds`] | [`Prepared`]: a loaded world with its doors looked up; worlds as folders |
//! | [`trace`] | [`EpisodeTrace`]: the record of an episode |
//! | [`score`] | [`Results`]: from traces to metrics |
//! | [`report`] | results for people: terminal table and HTML |
//! | [`mod@run`] | [`Rollout`]: agents drive episodes; results, logs and reports are written |
//! | [`yardsticks`] | agents and parts that know the truth, or know nothing |
//! | [`error`] | [`BenchError`] |
//! | [`image_file`] | encoding of images as JPEG and PNG |
//! | [`line_problem`] | a line of a text file that cannot be parsed |
//!
//! Each folder imports from those above it in this table only, and all of them from the last three
//! files; a test checks that.

pub mod error;
pub mod image_file;
pub mod line_problem;
pub mod plural;
pub mod report;
pub mod run;
pub mod score;
pub mod suite;
pub mod trace;
pub mod worlds;
pub mod yardsticks;

pub use error::BenchError;
pub use openbench_sim::traffic::TrafficPlan;
pub use run::{
    AgentFactory, AgentRequest, Agents, EpisodeEnd, Faults, FinishedBefore, ImuRange,
    InterruptedRun, Level, MEMORY_BEFORE, Observer, Rollout, RunRecord, RunRequest, Status, Truth,
    TruthHandle, UNFINISHED, Unfinished, interrupted, memory_of, repeat, run, verify, verify_agent,
};
pub use score::Results;
pub use score::provenance::{Build, ModelDigest, Setting};
pub use suite::builtin::builtin_suites;
pub use suite::{Episode, Sensors, Suite, TargetSource, WorldSource};
pub use trace::EpisodeTrace;
pub use worlds::{Prepared, builtin_suite};
