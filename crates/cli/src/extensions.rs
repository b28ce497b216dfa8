//! What a binary of one's own adds to the built-in agents and parts.

use std::sync::Arc;

use openbench_agents::open::Catalogue;
use openbench_agents::open::parts::{LocalizerPart, PartError};
use openbench_bench::run::registry::AgentError;
use openbench_bench::{AgentFactory, AgentRequest, Agents};
use openbench_core::{Agent, RobotDescription};
use openbench_localization::Localizer;
use openbench_motion::local::Entry;
use openbench_vision::{PlateReader, ReaderEntry};

use crate::open_agent::OpenFactory;

/// Agents, and parts of OPEN, beside the built-in ones.
///
/// ```no_run
/// use openbench::Extensions;
/// use openbench_localization::DeadReckoning;
///
/// fn main() -> std::process::ExitCode {
///     let wheels = |robot: &openbench_core::RobotDescription| DeadReckoning::new(robot.clone());
///     openbench::main_with(Extensions::new().with_localizer(
///         "wheels",
///         "wheel odometry of my own",
///         move |robot| Box::new(wheels(robot)),
///     ))
/// }
/// ```
#[derive(Clone)]
pub struct Extensions {
    agents: Agents,
    parts: Catalogue,
}

impl Default for Extensions {
    fn default() -> Self {
        Self::new()
    }
}

impl Extensions {
    /// The built-in agents and parts alone.
    pub fn new() -> Self {
        Self {
            agents: Agents::new("agent"),
            parts: Catalogue::default(),
        }
    }

    /// Adds an agent: `--agent NAME`.
    #[must_use]
    pub fn with_agent<F>(mut self, name: &str, about: &str, make: F) -> Self
    where
        F: Fn(&AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> + Send + Sync + 'static,
    {
        self.agents = self.agents.with(name, about, Arc::new(make));
        self
    }

    /// Adds a plate reader: `--set reader=NAME`.
    #[must_use]
    pub fn with_reader(
        mut self,
        name: &str,
        about: &str,
        make: impl Fn() -> Result<Box<dyn PlateReader>, PartError> + Send + Sync + 'static,
    ) -> Self {
        let entry = ReaderEntry::new(name, about, move |_, _| make());
        self.parts.readers = self.parts.readers.with(entry);
        self
    }

    /// Adds a localizer: `--set localizer=NAME`.
    #[must_use]
    pub fn with_localizer(
        mut self,
        name: &str,
        about: &str,
        make: impl Fn(&RobotDescription) -> Box<dyn Localizer> + Send + Sync + 'static,
    ) -> Self {
        let part = LocalizerPart::WithoutFixes(Arc::new(make));
        self.parts.localizers = self.parts.localizers.with(name, about, part);
        self
    }

    /// Adds a local planner: `--set motion=NAME`.
    #[must_use]
    pub fn with_local_planner(mut self, entry: Entry) -> Self {
        self.parts.local_planners = self.parts.local_planners.with(entry);
        self
    }

    /// All agents, OPEN among them.
    pub(crate) fn agents(&self) -> Agents {
        let open: Arc<dyn AgentFactory> = Arc::new(OpenFactory::new(self.parts.clone()));
        self.agents
            .clone()
            .with("open", "the baseline of the paper", open)
    }

    /// The parts that OPEN can be made of.
    pub(crate) fn parts(&self) -> &Catalogue {
        &self.parts
    }
}
