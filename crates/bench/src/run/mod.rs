//! Running: agents drive episodes, and traces, logs and recordings are kept.
//!
//! | module | content |
//! |---|---|
//! | [`registry`] | [`Agents`]: agents by name |
//! | [`rollout`] | [`Rollout`]: an episode, one step at a time |
//! | [`trace`] | [`EpisodeTrace`]: the record of an episode, for scoring |
//! | [`observer`] | [`Observer`]: a passive observer of an episode |
//! | [`episode`] | one episode driven by an agent |
//! | [`episodes`] | all episodes of a suite, on several threads, with results and files |
//! | [`recorder`] | the sensor log of an episode |
//! | [`recording`] | the actions of an episode, and [`verify`](recording::verify), which replays them |
//! | [`threads`] | numbered jobs on several threads |
//! | [`truth`] | the true pose as a localizer, for comparisons |
//! | [`disturbed`] | fixes simulated from the true pose, for experiments |

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
