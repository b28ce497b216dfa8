//! The input of a run.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use openbench_osm::OsmData;

use super::recorder::Level;
use super::registry::AgentFactory;
use crate::score::provenance::Build;
use crate::score::results::DeliveryResult;
use crate::worlds::Prepared;

/// What to do with a run that was interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unfinished {
    /// Refuse to begin if it has finished episodes.
    #[default]
    Keep,
    /// Remove it.
    Discard,
    /// Run only those of its episodes that are missing.
    Resume,
}

/// The end of an episode, as progress is reported.
#[derive(Debug, Clone, PartialEq)]
pub struct EpisodeEnd {
    /// Number of episodes that have ended.
    pub ended: usize,
    /// The results of this episode's deliveries.
    pub deliveries: Vec<DeliveryResult>,
}

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
    /// What to do with an interrupted run in that folder.
    pub unfinished: Unfinished,
    /// A map with the doors found in earlier runs.
    pub memory: Option<&'a OsmData>,
    /// The file that gets this map and the doors found in this run, when it is complete.
    pub memory_file: Option<&'a Path>,
    /// The program, for the results.
    pub build: &'a Build,
    /// The command line, for the report.
    pub command: &'a str,
    /// Called after each episode.
    pub progress: &'a (dyn Fn(&EpisodeEnd) + Sync),
    /// When set, the run ends after the current step with [`BenchError::Interrupted`]. What is
    /// finished remains and can be resumed.
    ///
    /// [`BenchError::Interrupted`]: crate::BenchError::Interrupted
    pub stop: &'a AtomicBool,
}

impl<'a> RunRequest<'a> {
    /// A run with the agent's defaults and seed 0, on one thread. Nothing is written, and nothing
    /// stops it.
    pub fn new(prepared: &'a Prepared, agent: &'a str, factory: &'a dyn AgentFactory) -> Self {
        static NO_SETTINGS: BTreeMap<String, String> = BTreeMap::new();
        static UNKNOWN: Build = Build {
            commit: String::new(),
            program: String::new(),
            target: String::new(),
        };
        static GO_ON: AtomicBool = AtomicBool::new(false);
        Self {
            prepared,
            agent,
            factory,
            settings: &NO_SETTINGS,
            seed: 0,
            jobs: 1,
            level: Level::None,
            out: None,
            unfinished: Unfinished::Keep,
            memory: None,
            memory_file: None,
            build: &UNKNOWN,
            command: "",
            progress: &|_| {},
            stop: &GO_ON,
        }
    }
}
