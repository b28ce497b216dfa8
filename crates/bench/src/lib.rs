//! The benchmark: suites and episodes, the runner, the recorder, metrics and reports.
//!
//! | module | its one job |
//! |---|---|
//! | [`suite`] | [`Suite`], [`Episode`], [`WorldSource`]: what is run, as files |
//! | [`deliveries`] | the published files of deliveries |
//! | [`draw`] | deliveries with instructions, from a seed |
//! | [`stage`] | [`Prepared`]: a suite with its world built and its doors looked up |
//! | [`registry`] | [`Registry`]: agents by name |
//! | [`rollout`] | an episode, one step at a time |
//! | [`runner`] | one agent through one episode |
//! | [`mod@run`] | all episodes of a suite, on several threads, with results and files |
//! | [`recorder`] | the log of an episode |
//! | [`recording`] | the actions of an episode, and [`verify`](recording::verify): driving them again |
//! | [`scoring`] | from what happened to results |
//! | [`metrics`], [`statistics`], [`results`] | the numbers |
//! | [`evaluate`] | the reference's recorder files |
//! | [`instructions`] | instructions with right answers, and SRTP of planners |
//! | [`report`] | results for people |
//! | [`motion`] | how well local planners drive |
//! | [`speed`] | how fast the parts are |
//! | [`world_folder`] | worlds as folders: recipe, maps, suite |
//! | [`threads`] | numbered work on several threads |
//! | [`tour`] | drives for the sake of their logs |
//! | [`towns`] | neighbourhoods from a seed, and an agent's deliveries in each |
//! | [`truth`] | the truth as a localizer, for comparisons |
//! | [`degraded`] | drives with sensors that are worse than believed |
//! | [`disturbed`] | fixes made from the truth, for trials |

pub mod degraded;
pub mod deliveries;
pub mod disturbed;
pub mod draw;
pub mod error;
pub mod evaluate;
pub mod instructions;
pub mod metrics;
pub mod motion;
pub mod picture;
pub mod recorder;
pub mod recording;
pub mod registry;
pub mod report;
mod report_input;
pub mod results;
pub mod rollout;
pub mod run;
pub mod runner;
pub mod scoring;
pub mod speed;
pub mod stage;
pub mod statistics;
pub mod suite;
pub mod threads;
pub mod tour;
pub mod towns;
pub mod truth;
pub mod world_folder;

pub use disturbed::{Disturbance, DisturbanceError, DisturbedTruth};
pub use error::BenchError;
pub use openbench_sim::traffic::TrafficPlan;
pub use recorder::{Faults, Level};
pub use registry::{AgentFactory, AgentRequest, Exchanges, Registry};
pub use results::Results;
pub use rollout::{EpisodeTrace, Observer, Rollout, Status};
pub use run::{MEMORY_BEFORE, RunRequest, memory_of, repeat, run};
pub use stage::Prepared;
pub use suite::{Episode, Sensors, Suite, WorldSource};
pub use truth::{TruthHandle, TruthLocalizer};
