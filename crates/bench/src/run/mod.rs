//! Running: agents drive episodes, and traces, logs and recordings are kept.
//!
//! | module | content |
//! |---|---|
//! | [`registry`] | [`Agents`]: agents by name |
//! | [`rollout`] | [`Rollout`]: an episode, one step at a time |
//! | [`observer`] | [`Observer`]: a passive observer of an episode |
//! | [`episode`] | one episode driven by an agent |
//! | [`request`] | [`RunRequest`]: the input of a run |
//! | [`episodes`] | all episodes of a suite, on several threads |
//! | [`output`] | [`RunOutput`]: results and merged map |
//! | [`folder`] | the files in the folder of a run |
//! | [`recorder`] | the sensor log of an episode |
//! | [`recording`] | the actions of an episode, and [`verify`](recording::verify), which replays them |
//! | [`threads`] | numbered jobs on several threads |
//! | [`truth`] | the true pose as a localizer, for comparisons |
//! | [`simulated_fixes`] | fixes simulated from the true pose, for experiments |

pub mod episode;
pub mod episodes;
pub mod folder;
pub mod observer;
pub mod output;
pub mod recorder;
pub mod recording;
pub mod registry;
pub mod request;
pub mod rollout;
pub mod simulated_fixes;
pub mod threads;
pub mod truth;

pub use episode::run_episode;
pub use episodes::{repeat, run};
pub use folder::{MEMORY_BEFORE, memory_of};
pub use observer::Observer;
pub use output::RunOutput;
pub use recorder::{Faults, ImuRange, Level};
pub use registry::{AgentFactory, AgentRequest, Agents};
pub use request::RunRequest;
pub use rollout::{Rollout, Status};
pub use simulated_fixes::{FixNoise, FixNoiseError, SimulatedFixes};
pub use truth::{TruthHandle, TruthLocalizer};
