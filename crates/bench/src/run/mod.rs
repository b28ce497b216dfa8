//! Running: agents drive episodes, and traces, logs and recordings are kept.
//!
//! | module | content |
//! |---|---|
//! | [`registry`] | [`Agents`]: agents by name |
//! | `rollout` | [`Rollout`]: an episode, one step at a time |
//! | `observer` | [`Observer`]: a passive observer of an episode |
//! | `episode` | [`run_episode`]: one episode driven by an agent |
//! | [`computing`] | a computer that takes simulated time for what agents compute |
//! | `request` | [`RunRequest`]: the input of a run |
//! | `episodes` | [`run`] and [`repeat`]: all episodes of a suite, on several threads |
//! | `reached` | whether the models of a run can be reached at all |
//! | `output` | [`RunOutput`]: results and merged map |
//! | `folder` | the folder of a run: one process at a time, nothing lost |
//! | `files` | the files in it: names, reading, writing |
//! | [`record`] | [`RunRecord`]: the parameters of a run |
//! | [`recorder`] | the sensor log of an episode |
//! | [`recording`] | the actions of an episode, and [`replay`](recording::replay) |
//! | `verify` | [`verify`]: whether the files of a run follow from its actions |
//! | [`threads`] | numbered jobs on several threads |
//! | [`truth`] | [`Truth`]: what only the judge knows, for yardsticks |

pub mod computing;
mod episode;
mod episodes;
mod files;
mod folder;
mod observer;
mod output;
mod reached;
pub mod record;
pub mod recorder;
pub mod recording;
pub mod registry;
mod request;
mod rollout;
pub mod threads;
pub mod truth;
mod verify;

pub use episode::run_episode;
pub use episodes::{FinishedBefore, repeat, run};
pub use folder::{InterruptedRun, MEMORY_BEFORE, UNFINISHED, interrupted, memory_of};
pub use observer::Observer;
pub use output::RunOutput;
pub use record::RunRecord;
pub use recorder::{Faults, ImuRange, Level};
pub use registry::{AgentFactory, AgentRequest, Agents};
pub use request::{EpisodeEnd, RunRequest, Unfinished};
pub use rollout::{Rollout, Status};
pub use truth::{PosesOnMap, Truth, TruthHandle};
pub use verify::{verify, verify_agent};
