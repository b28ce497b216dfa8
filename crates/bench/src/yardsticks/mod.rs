//! Yardsticks: agents and parts that know the truth, or know nothing. They show what a score is
//! worth, and the results name them.
//!
//! | module | content |
//! |---|---|
//! | `omniscient` | an agent that follows the shortest path to the right door |
//! | `straight_line` | an agent that drives straight at the right door |
//! | `random` | an agent that drives anywhere |
//! | `errands` | the doors of an episode, as these agents are told |
//! | `following` | driving along a path |
//! | `reader` | [`TruthReader`]: the plates in view, as a reader |
//! | `localizer` | [`TruthLocalizer`]: the true pose, as a localizer |
//! | `fixes` | [`SimulatedFixes`]: fixes made from the true pose |

mod errands;
mod fixes;
mod following;
mod localizer;
mod omniscient;
mod random;
mod reader;
#[cfg(test)]
mod scenery;
mod straight_line;

use std::sync::Arc;

use openbench_core::Agent;

use crate::run::registry::{AgentError, AgentSettings};
use crate::run::truth::Truth;
use crate::run::{AgentFactory, AgentRequest, Agents};

pub use fixes::{FixNoise, FixNoiseError, SimulatedFixes};
pub use localizer::TruthLocalizer;
pub use reader::{LetterHeight, LetterHeightError, TruthReader};

use omniscient::Omniscient;
use random::Random;
use straight_line::StraightLine;

/// The agents among the yardsticks, by name.
///
/// ```
/// let agents = openbench_bench::yardsticks::agents();
/// let names: Vec<&str> = agents.names().map(|(name, _)| name).collect();
/// assert_eq!(names, ["omniscient", "straight-line", "random"]);
/// ```
pub fn agents() -> Agents {
    KINDS.iter().fold(Agents::default(), |agents, kind| {
        agents.with(kind.name, kind.about, Arc::new(*kind))
    })
}

const KINDS: [Kind; 3] = [
    Kind {
        name: "omniscient",
        about: "a yardstick: follows the shortest path to the right door",
        make: |truth, _| Box::new(Omniscient::new(truth)),
    },
    Kind {
        name: "straight-line",
        about: "a yardstick: drives straight at the right door",
        make: |truth, _| Box::new(StraightLine::new(truth)),
    },
    Kind {
        name: "random",
        about: "a yardstick: drives anywhere and declares at any time",
        make: |truth, seed| Box::new(Random::new(truth, seed)),
    },
];

/// An agent among the yardsticks.
#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    about: &'static str,
    /// From the truth and the seed of the episode.
    make: fn(&Truth<'_>, u64) -> Box<dyn Agent>,
}

impl AgentFactory for Kind {
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        let truth = request.truth.as_ref();
        let truth = truth.ok_or("a yardstick needs the truth about its episode")?;
        Ok((self.make)(truth, request.seed))
    }

    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        match settings.keys().next() {
            Some(key) => Err(format!("{key}: the agent {} has no settings", self.name).into()),
            None => Ok(()),
        }
    }

    fn uses_truth(&self, _: &AgentSettings) -> bool {
        true
    }
}
