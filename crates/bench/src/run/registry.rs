//! The agents that can be run, by name.

use std::collections::BTreeMap;
use std::path::PathBuf;

use openbench_core::Agent;
use openbench_osm::OsmData;

use crate::run::truth::TruthHandle;

/// What an agent is made from, beside its own settings.
#[derive(Debug, Clone)]
pub struct AgentRequest<'a> {
    /// Where the robot truly is: for a localizer that is to be compared with, never for the agent itself.
    pub truth: TruthHandle,
    /// Doors found in earlier runs.
    pub memory: Option<&'a OsmData>,
    /// What was set with `--set`.
    pub settings: &'a BTreeMap<String, String>,
    /// Seed of the episode.
    pub seed: u64,
    /// Where what models answer goes, or comes from.
    pub exchanges: Exchanges,
}

/// Where what language and vision models answer in an episode goes, or comes from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Exchanges {
    /// Models are asked, and nothing is kept.
    #[default]
    Unkept,
    /// Models are asked, and what they answer is kept in this file. An agent without models makes none.
    Keep(PathBuf),
    /// Nobody is asked: the answers are those in this file.
    Repeat(PathBuf),
}

/// Makes an agent, a fresh one for each episode.
pub type AgentFactory = Box<dyn Fn(&AgentRequest<'_>) -> Result<Box<dyn Agent>, String> + Send + Sync>;

/// Agents by name.
#[derive(Default)]
pub struct Registry {
    agents: BTreeMap<String, AgentFactory>,
}

impl Registry {
    /// No agents.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an agent, or replaces the one of that name.
    #[must_use]
    pub fn with(mut self, name: &str, factory: AgentFactory) -> Self {
        self.agents.insert(name.to_owned(), factory);
        self
    }

    /// The factory of an agent.
    pub fn get(&self, name: &str) -> Option<&AgentFactory> {
        self.agents.get(name)
    }

    /// All names.
    pub fn names(&self) -> Vec<String> {
        self.agents.keys().cloned().collect()
    }
}
