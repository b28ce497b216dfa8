//! The parameters of a run, sufficient to repeat it: the file `run.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use openbench_osm::{OsmData, merge_entrances};
use serde::{Deserialize, Serialize};

use super::files::{RUN, read_json, write_json};
use super::recorder::Level;
use super::registry::AgentFactory;
use super::request::RunRequest;
use crate::BenchError;
use crate::score::provenance::{Build, ModelDigest, Provenance, Setting};
use crate::score::results::MemoryUse;
use crate::suite::Suite;
use crate::worlds::hashes::hash_bytes;
use crate::worlds::{Hashes, Prepared};

/// The parameters of a run. Results follow from them and from the recordings of the episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRecord {
    /// Version of OpenBench.
    pub version: String,
    /// The program that made the run.
    pub build: Build,
    /// Model name of the processor, if the system tells.
    pub processor: Option<String>,
    /// Name of the agent.
    pub agent: String,
    /// The agent's settings as they were given (`--set KEY=VALUE`).
    pub settings: BTreeMap<String, String>,
    /// All its settings in force.
    pub in_force: BTreeMap<String, Setting>,
    /// The model files that the agent uses.
    pub models: Vec<ModelDigest>,
    /// Whether the agent, or a part of it, was told the truth about its episodes.
    pub uses_truth: bool,
    /// Why the agent cannot be run again; null if it can.
    pub cannot_repeat: Option<String>,
    /// Seed of all random numbers of the run.
    pub seed: u64,
    /// Number of episodes.
    pub episodes: usize,
    /// The content of the logs.
    pub logs: Level,
    /// The command line.
    pub command: String,
    /// The doors from earlier runs that the agent knew.
    pub memory: Option<MemoryUse>,
    /// The file in which doors are kept from run to run.
    pub memory_file: Option<PathBuf>,
    /// The file with the true positions of the doors, if one was given.
    pub truth: Option<PathBuf>,
    /// BLAKE3 of what the run was made in.
    pub hashes: Hashes,
    /// The suite.
    pub suite: Suite,
}

impl RunRecord {
    /// The record of a run that is about to begin.
    ///
    /// # Errors
    /// A file that has gone since the suite was prepared, or a model file that is not here.
    pub fn of(request: &RunRequest<'_>) -> Result<Self, BenchError> {
        let prepared = request.prepared;
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: request.build.clone(),
            processor: processor(),
            agent: request.agent.to_owned(),
            settings: request.settings.clone(),
            in_force: request.factory.in_force(request.settings),
            models: models_of(request.agent, request.factory, request.settings)?,
            uses_truth: request.factory.uses_truth(request.settings),
            cannot_repeat: request.factory.cannot_repeat(request.settings),
            seed: request.seed,
            episodes: prepared.episodes.len(),
            logs: request.level,
            command: request.command.to_owned(),
            memory: request.memory.map(|memory| memory_use(prepared, memory)),
            memory_file: request.memory_file.map(Path::to_owned),
            truth: prepared.truth.clone(),
            hashes: Hashes::of(prepared)?,
            suite: prepared.suite.clone(),
        })
    }

    /// The request for this run again, on one thread. Nothing is written, and no memory is known.
    pub fn request<'a>(
        &'a self,
        prepared: &'a Prepared,
        factory: &'a dyn AgentFactory,
    ) -> RunRequest<'a> {
        RunRequest {
            settings: &self.settings,
            seed: self.seed,
            build: &self.build,
            command: &self.command,
            ..RunRequest::new(prepared, &self.agent, factory)
        }
    }

    /// Reads the record of the run in the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::File`] or [`BenchError::WrongFormat`].
    pub fn read(run: &Path) -> Result<Self, BenchError> {
        read_json(&run.join(RUN), "record of a run")
    }

    /// Writes the record of the run into the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::BadFile`].
    pub fn write(&self, run: &Path) -> Result<(), BenchError> {
        write_json(&run.join(RUN), self)
    }

    /// What recordings of this run are sealed with: nothing in the record can be exchanged
    /// afterwards.
    pub(super) fn hash(&self) -> [u8; 32] {
        // Strings, numbers and lists: every value has a JSON form.
        let json = serde_json::to_vec(self).unwrap_or_default();
        *blake3::hash(&json).as_bytes()
    }

    /// What the results say about their making.
    pub(super) fn provenance(&self) -> Provenance {
        Provenance {
            build: self.build.clone(),
            processor: self.processor.clone(),
            hashes: self.hashes.clone(),
            models: self.models.clone(),
            uses_truth: self.uses_truth,
            cannot_repeat: self.cannot_repeat.clone(),
        }
    }

    /// In what a run that would begin now differs from this one; `None` if this one can be
    /// continued.
    pub(super) fn difference(&self, now: &Self) -> Option<String> {
        let pairs = [
            ("agent", &self.agent, &now.agent),
            ("version", &self.version, &now.version),
            ("commit", &self.build.commit, &now.build.commit),
            ("program", &self.build.program, &now.build.program),
            ("world", &self.hashes.world, &now.hashes.world),
            ("map", &self.hashes.map, &now.hashes.map),
            ("suite", &self.hashes.suite, &now.hashes.suite),
        ];
        let other = pairs.into_iter().find(|(_, then, now)| then != now);
        if let Some((what, then, now)) = other {
            return Some(format!("its {what} is {then}, now it is {now}"));
        }
        // Strings, numbers and lists: every value has a JSON form.
        let [then, now] =
            [self, now].map(|record| serde_json::to_value(record).unwrap_or_default());
        let mut keys = then.as_object()?.keys();
        let key =
            keys.find(|key| !MAY_DIFFER.contains(&key.as_str()) && then[*key] != now[*key])?;
        let [then, now] = [&then[key], &now[key]].map(ToString::to_string);
        let is_short = then.len().max(now.len()) <= MOST_SHOWN;
        Some(if is_short {
            format!("its `{key}` is {then}, now it is {now}")
        } else {
            format!("its `{key}` is another one now")
        })
    }
}

/// Keys of records in which runs may differ that give the same: another processor may continue a
/// run, another command line may say the same, and files may lie elsewhere if their hashes agree.
const MAY_DIFFER: [&str; 5] = ["processor", "command", "build", "suite", "truth"];
/// Most characters of a value in the description of a difference.
const MOST_SHOWN: usize = 80;

/// The model files of an agent.
pub(super) fn models_of(
    name: &str,
    factory: &dyn AgentFactory,
    settings: &BTreeMap<String, String>,
) -> Result<Vec<ModelDigest>, BenchError> {
    factory
        .models(settings)
        .map_err(|source| BenchError::Agent {
            name: name.to_owned(),
            source,
        })
}

/// What a memory adds to the public map.
pub(super) fn memory_use(prepared: &Prepared, memory: &OsmData) -> MemoryUse {
    let mut merged = prepared.public_data().clone();
    MemoryUse {
        doors: merge_entrances(&mut merged, memory),
        hash: hash_bytes(&memory.to_xml()),
    }
}

/// The model name of the processor, where Linux tells.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
