//! The input of a run.

use std::collections::BTreeMap;
use std::path::Path;

use openbench_osm::OsmData;

use super::recorder::Level;
use super::registry::AgentFactory;
use crate::worlds::Prepared;

/// A run: suite, agent and options.
pub struct RunRequest<'a> {
    /// The suite with its world loaded.
    pub prepared: &'a Prepared,
    /// Name of the agent, for the results.
    pub agent: &'a str,
    /// The factory of the agent.
    pub factory: &'a dyn AgentFactory,
    /// The agent's settings (`--set KEY=VALUE`).
    pub settings: &'a BTreeMap<String, String>,
    /// Seed of all random numbers of the run.
    pub seed: u64,
    /// Number of threads.
    pub jobs: usize,
    /// The content of the logs.
    pub level: Level,
    /// Folder for all files of the run; `None` writes nothing.
    pub out: Option<&'a Path>,
    /// A map with the doors found in earlier runs.
    pub memory: Option<&'a OsmData>,
    /// The command line, for the report.
    pub command: &'a str,
    /// Called after each episode with the number of finished episodes.
    pub progress: &'a (dyn Fn(usize) + Sync),
}
