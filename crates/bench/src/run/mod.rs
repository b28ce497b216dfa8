//! Running: agents drive episodes, and what happens is kept.
//!
//! | module | its one job |
//! |---|---|
//! | [`registry`] | [`Agents`]: agents by name |
//! | [`rollout`] | [`Rollout`]: an episode, one step at a time |
//! | [`trace`] | [`EpisodeTrace`]: what happened in an episode |
//! | [`observer`] | [`Observer`]: who watches an episode |
//! | [`episode`] | one agent through one episode |
//! | [`episodes`] | all episodes of a suite, on several threads, with results and files |
//! | [`recorder`] | the log of an episode |
//! | [`recording`] | the actions of an episode, and [`verify`](recording::verify): driving them again |
//! | [`threads`] | numbered work on several threads |
//! | [`truth`] | the truth as a localizer, for comparisons |
//! | [`disturbed`] | fixes made from the truth, for trials |

pub mod disturbed;
pub mod episode;
pub mod episodes;
pub mod observer;
pub mod recorder;
pub mod recording;
pub mod registry;
pub mod rollout;
pub mod threads;
pub mod trace;
pub mod truth;

pub use disturbed::{Disturbance, DisturbanceError, DisturbedTruth};
pub use episode::run_episode;
pub use episodes::{MEMORY_BEFORE, RunRequest, memory_of, repeat, run};
pub use observer::Observer;
pub use recorder::{Faults, Level};
pub use registry::{AgentFactory, AgentRequest, Agents};
pub use rollout::{Rollout, Status};
pub use trace::EpisodeTrace;
pub use truth::{TruthHandle, TruthLocalizer};
