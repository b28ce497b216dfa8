//! Agents by name.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use openbench_core::{Agent, Registry, RobotDescription};
use openbench_models::{Exchanges, PullEvent};
use openbench_osm::OsmData;

use super::truth::Truth;
use crate::score::provenance::{ModelDigest, Setting};

/// An agent's settings (`--set KEY=VALUE`).
pub type AgentSettings = BTreeMap<String, String>;
/// The error of a factory that cannot create its agent.
pub type AgentError = Box<dyn Error + Send + Sync>;

/// The input of an [`AgentFactory`].
#[derive(Debug, Clone)]
pub struct AgentRequest<'a> {
    /// The truth about the episode, for yardsticks; `None` unless [`AgentFactory::uses_truth`].
    pub truth: Option<Truth<'a>>,
    /// A map with the doors found in earlier runs.
    pub memory: Option<&'a OsmData>,
    /// The agent's settings.
    pub settings: &'a AgentSettings,
    /// Seed of the episode.
    pub seed: u64,
    /// Whether the answers of models are recorded, or replayed from a recording.
    pub exchanges: Exchanges,
}

/// Creates agents of one kind. Any function from an [`AgentRequest`] to an agent is a factory.
pub trait AgentFactory: Send + Sync {
    /// Creates an agent; called once for each episode.
    ///
    /// # Errors
    /// An error that names the setting with an unknown or invalid value.
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError>;

    /// Checks keys, values and names of parts, without opening or downloading anything; called
    /// before a world is loaded.
    ///
    /// # Errors
    /// An error that names the setting with an unknown or invalid value.
    fn check(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        let _ = settings;
        Ok(())
    }

    /// Checks that the robot has what the settings need, such as a receiver.
    ///
    /// # Errors
    /// An error that names the setting, and what the robot lacks.
    fn check_robot(
        &self,
        settings: &AgentSettings,
        robot: &RobotDescription,
    ) -> Result<(), AgentError> {
        let _ = (settings, robot);
        Ok(())
    }

    /// Downloads the files that the settings need; called once before a run. `observer` receives
    /// the progress of downloads.
    ///
    /// # Errors
    /// As [`check`](Self::check), or a file that cannot be downloaded.
    fn prepare(
        &self,
        settings: &AgentSettings,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), AgentError> {
        let _ = (settings, observer);
        Ok(())
    }

    /// Checks that a server which the agent asks can be reached; called once before a run, but not
    /// before recorded answers are repeated.
    ///
    /// # Errors
    /// An error that names the server.
    fn reach(&self, settings: &AgentSettings) -> Result<(), AgentError> {
        let _ = settings;
        Ok(())
    }

    /// Whether an agent with these settings uses the truth about its episodes; by default it does
    /// not. The results of an agent that does say so.
    fn uses_truth(&self, settings: &AgentSettings) -> bool {
        let _ = settings;
        false
    }

    /// All settings in force, those that were not given with their defaults. By default only the
    /// given ones are known.
    fn in_force(&self, settings: &AgentSettings) -> BTreeMap<String, Setting> {
        let given = |value: &String| Setting {
            value: value.clone(),
            default: false,
        };
        settings
            .iter()
            .map(|(key, value)| (key.clone(), given(value)))
            .collect()
    }

    /// The model files that an agent with these settings uses.
    ///
    /// # Errors
    /// A file that is not here.
    fn models(&self, settings: &AgentSettings) -> Result<Vec<ModelDigest>, AgentError> {
        let _ = settings;
        Ok(Vec::new())
    }

    /// Whether the wall time of its decisions is charged as simulated time, see
    /// [`Event::WallTime`](openbench_core::Event::WallTime); by default it is not. Such an agent
    /// cannot repeat what it did.
    fn is_charged_by_clock(&self, settings: &AgentSettings) -> bool {
        let _ = settings;
        false
    }

    /// Why an agent with these settings cannot repeat what it did, so that nobody can check who
    /// made its results; `None` if it can.
    fn cannot_repeat(&self, settings: &AgentSettings) -> Option<String> {
        let _ = settings;
        None
    }

    /// Files named in the settings, which a run must not remove before they are read.
    fn inputs(&self, settings: &AgentSettings) -> Vec<PathBuf> {
        let _ = settings;
        Vec::new()
    }
}

impl<F> AgentFactory for F
where
    F: Fn(&AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> + Send + Sync,
{
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
        self(request)
    }
}

/// Makes a factory from what is written after the colon of `NAME:ARGUMENT`.
type MakeFactory = dyn Fn(&str) -> Result<Arc<dyn AgentFactory>, AgentError> + Send + Sync;

/// How an agent is found by its name.
#[derive(Clone)]
enum Part {
    /// By the name alone.
    Plain(Arc<dyn AgentFactory>),
    /// By the name and an argument.
    OfArgument(Arc<MakeFactory>),
}

/// Agents by name.
#[derive(Clone)]
pub struct Agents {
    parts: Registry<Part>,
}

impl Default for Agents {
    fn default() -> Self {
        Self {
            parts: Registry::new("agent"),
        }
    }
}

impl Agents {
    /// The same with one more agent. One of the same name is replaced.
    #[must_use]
    pub fn with(self, name: &str, about: &str, factory: Arc<dyn AgentFactory>) -> Self {
        Self {
            parts: self.parts.with(name, about, Part::Plain(factory)),
        }
    }

    /// The same with agents that take an argument: `name` has its form, as in `program:COMMAND`.
    #[must_use]
    pub fn with_argument(
        self,
        name: &str,
        about: &str,
        make: impl Fn(&str) -> Result<Arc<dyn AgentFactory>, AgentError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            parts: self
                .parts
                .with(name, about, Part::OfArgument(Arc::new(make))),
        }
    }

    /// The same with the agents of another registry, in whose places they come.
    #[must_use]
    pub fn with_all(self, others: &Self) -> Self {
        Self {
            parts: self.parts.with_entries(others.parts.entries().cloned()),
        }
    }

    /// The factory of the agent that `NAME` or `NAME:ARGUMENT` names.
    ///
    /// # Errors
    /// [`UnknownName`](openbench_core::UnknownName) with the names that there are, or the error of
    /// an argument.
    pub fn get(&self, name: &str) -> Result<Arc<dyn AgentFactory>, AgentError> {
        let found = self.parts.find(name)?;
        match &found.entry.part {
            Part::Plain(factory) => Ok(Arc::clone(factory)),
            Part::OfArgument(make) => make(found.argument),
        }
    }

    /// What kind of part it contains.
    pub fn kind(&self) -> &'static str {
        self.parts.kind()
    }

    /// All names with the forms of their arguments, and what the agents are, in the order in which
    /// they were registered.
    pub fn names(&self) -> impl Iterator<Item = (&str, &str)> {
        let entries = self.parts.entries();
        entries.map(|entry| (entry.name.as_str(), entry.about.as_str()))
    }
}
