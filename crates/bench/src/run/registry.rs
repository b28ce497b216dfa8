//! The agents that can be run, by name.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

use openbench_core::Agent;
use openbench_models::{Exchanges, PullEvent};
use openbench_osm::OsmData;

use super::truth::TruthHandle;

/// What was set with `--set`: keys and values.
pub type AgentSettings = BTreeMap<String, String>;
/// Why an agent cannot be made.
pub type AgentError = Box<dyn Error + Send + Sync>;

/// What an agent is made from, beside its own settings.
#[derive(Debug, Clone)]
pub struct AgentRequest<'a> {
    /// Where the robot truly is: for a localizer that is to be compared with, never for the agent itself.
    pub truth: TruthHandle,
    /// Doors found in earlier runs.
    pub memory: Option<&'a OsmData>,
    /// What was set with `--set`.
    pub settings: &'a AgentSettings,
    /// Seed of the episode.
    pub seed: u64,
    /// Where what models answer goes, or comes from.
    pub exchanges: Exchanges,
}

/// Makes agents of one kind. Any function from an [`AgentRequest`] to an agent does.
pub trait AgentFactory: Send + Sync {
    /// Makes an agent, a fresh one for each episode.
    ///
    /// # Errors
    /// An error that says which setting names what does not exist.
    fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError>;

    /// Checks settings and downloads what they need, once before a run. `observer` sees the progress.
    ///
    /// # Errors
    /// As of [`make`](Self::make); or a file that cannot be had.
    fn prepare(
        &self,
        settings: &AgentSettings,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), AgentError> {
        let _ = (settings, observer);
        Ok(())
    }

    /// Files that settings name: a run must not clear them before they are read.
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

/// Agents by name.
pub type Agents = openbench_core::Registry<std::sync::Arc<dyn AgentFactory>>;
