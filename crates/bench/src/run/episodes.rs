//! All episodes of a suite, on several threads; the results do not depend on their number.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ProcessTime;
use openbench_core::{Agent, ModelUse};
use openbench_models::Exchanges;
use openbench_osm::{OsmData, OsmError, merge_entrances, write_atomically};

use crate::BenchError;
use crate::report;
use crate::report::from_run::report_input;
use crate::run::episode::run_episode;
use crate::run::recorder::{Level, Recorder};
use crate::run::recording::{Recording, RunRecord};
use crate::run::registry::{AgentFactory, AgentRequest, AgentSettings};
use crate::run::rollout::Rollout;
use crate::run::threads;
use crate::run::trace::EpisodeTrace;
use crate::run::truth::TruthHandle;
use crate::score::deliveries;
use crate::score::metrics::localization::localization;
use crate::score::metrics::{ErrorCounts, RunTotals, summarize};
use crate::score::results::Results;
use crate::worlds::Prepared;

/// Name of the file, in a run's folder, with the doors known before the run.
pub const MEMORY_BEFORE: &str = "memory-before.osm";

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

/// The output of a run.
#[derive(Debug)]
pub struct RunOutput {
    /// The results.
    pub results: Results,
    /// The public map with every door that was found in this run or known before it.
    pub memory: OsmData,
    /// Errors of all poses that the agent reported.
    pub pose_errors: ErrorCounts,
}

/// Runs all episodes of a suite and writes the run's files.
///
/// Files of an earlier run in the same folder are removed first.
///
/// # Errors
/// The error of the first episode that cannot be finished, or of a file that cannot be written.
pub fn run(request: &RunRequest<'_>) -> Result<RunOutput, BenchError> {
    let began = Instant::now();
    if let Some(out) = request.out {
        let folder = out.join("episodes");
        std::fs::create_dir_all(&folder).map_err(|e| BenchError::file(&folder, e))?;
        clear(out)?;
    }
    // CPU time of the whole process: plate readers may have threads of their own.
    let cpu = ProcessTime::now();
    let traces = run_all(request)?;
    let results = results(
        request,
        &traces,
        began.elapsed().as_secs_f64(),
        cpu.elapsed().as_secs_f64(),
    );
    if let Some(out) = request.out {
        write_files(request, out, &traces, &results)?;
    }
    let pose_errors = ErrorCounts::of(traces.iter().flat_map(|t| &t.pose_errors));
    Ok(RunOutput {
        memory: merged_memory(request, &traces),
        results,
        pose_errors,
    })
}

/// Removes the files of an earlier run from a folder, and nothing else. An interrupted run must not
/// leave a mixture of two runs.
fn clear(out: &Path) -> Result<(), BenchError> {
    let remove = |path: PathBuf| match std::fs::remove_file(&path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(BenchError::file(&path, e)),
        _ => Ok(()),
    };
    for name in ["results.json", "report.html", "run.json", MEMORY_BEFORE] {
        remove(out.join(name))?;
    }
    let folder = out.join("episodes");
    for entry in std::fs::read_dir(&folder).map_err(|e| BenchError::file(&folder, e))? {
        let path = entry.map_err(|e| BenchError::file(&folder, e))?.path();
        let name = path
            .file_name()
            .and_then(|n| n.to_str())
            .unwrap_or_default();
        let (number, kind) = name.split_once('.').unwrap_or_default();
        let numbered = number.len() >= 3 && number.bytes().all(|b| b.is_ascii_digit());
        if numbered && ["mcap", "osm", "actions.json", "models.jsonl"].contains(&kind) {
            remove(path)?;
        }
    }
    Ok(())
}

fn run_all(request: &RunRequest<'_>) -> Result<Vec<EpisodeTrace>, BenchError> {
    let count = request.prepared.episodes.len();
    let mut finished = 0;
    let collect = |trace| {
        finished += 1;
        (request.progress)(finished);
        Ok(trace)
    };
    threads::each(
        0..count,
        request.jobs,
        |number| run_one(request, number),
        collect,
    )
}

/// The seed of an episode.
fn episode_seed(seed: u64, number: usize) -> u64 {
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(number as u64)
}

fn run_one(request: &RunRequest<'_>, number: usize) -> Result<EpisodeTrace, BenchError> {
    let exchanges = request.out.map_or(Exchanges::Unkept, |out| {
        Exchanges::Keep(exchanges_path(out, number))
    });
    // Before the log is begun, so that an agent that cannot be made leaves none behind.
    let made = make(request, number, exchanges)?;
    let mut recorder = match request.out {
        Some(out) => Recorder::create(
            &log_path(out, number),
            request.level,
            request.prepared.world.georeference,
        )?,
        None => Recorder::none(),
    };
    let trace = drive(request, number, made, &mut recorder)?;
    recorder.finish()?;
    if let Some(out) = request.out {
        Recording::of(&trace, episode_seed(request.seed, number)).write(out, number)?;
    }
    Ok(trace)
}

/// Runs the agent of a recorded run again with the recorded answers of its models, and compares its
/// actions with the recorded ones.
///
/// Nothing is written; `request.out` is ignored.
///
/// # Errors
/// [`BenchError::Differs`] with the first step that differs.
pub fn repeat(request: &RunRequest<'_>, run: &Path) -> Result<(), BenchError> {
    let one = |number: usize| {
        let recording = Recording::read(run, number)?;
        let exchanges = Exchanges::Repeat(exchanges_path(run, number));
        let made = make(request, number, exchanges)?;
        let trace = drive(request, number, made, &mut Recorder::none())?;
        recording.compare(
            number,
            &Recording::of(&trace, episode_seed(request.seed, number)),
        )
    };
    let mut finished = 0;
    let collect = |()| {
        finished += 1;
        (request.progress)(finished);
        Ok(())
    };
    let numbers = 0..request.prepared.episodes.len();
    threads::each(numbers, request.jobs, one, collect).map(|_: Vec<()>| ())
}

/// The map of earlier doors with which the agents of a recorded run started; `None` if it had none.
///
/// # Errors
/// [`BenchError::BadFile`] if the map cannot be read.
pub fn memory_of(run: &Path) -> Result<Option<OsmData>, BenchError> {
    let path = run.join(MEMORY_BEFORE);
    let bad = |e: OsmError| BenchError::bad_file(&path, e);
    path.exists()
        .then(|| OsmData::read(&path).map_err(bad))
        .transpose()
}

/// An agent for an episode.
struct Made {
    agent: Box<dyn Agent>,
    /// What the simulator writes the true pose to.
    truth: TruthHandle,
}

fn make(request: &RunRequest<'_>, number: usize, exchanges: Exchanges) -> Result<Made, BenchError> {
    let truth = TruthHandle::default();
    let agent_request = AgentRequest {
        truth: requested_truth(request.factory, request.settings, &truth),
        memory: request.memory,
        settings: request.settings,
        seed: episode_seed(request.seed, number),
        exchanges,
    };
    let made = request.factory.make(&agent_request);
    let agent = made.map_err(|source| BenchError::Agent {
        name: request.agent.to_owned(),
        source,
    })?;
    Ok(Made { agent, truth })
}

fn drive(
    request: &RunRequest<'_>,
    number: usize,
    made: Made,
    recorder: &mut Recorder,
) -> Result<EpisodeTrace, BenchError> {
    let Made { mut agent, truth } = made;
    let rollout = Rollout::new(request.prepared, number, episode_seed(request.seed, number))?
        .watched_by(truth)
        .watched_by(recorder);
    run_episode(rollout, agent.as_mut())
}

/// The handle of the true pose if the agent uses it; otherwise an empty handle.
fn requested_truth(
    factory: &dyn AgentFactory,
    settings: &AgentSettings,
    truth: &TruthHandle,
) -> TruthHandle {
    if factory.uses_truth(settings) {
        truth.clone()
    } else {
        TruthHandle::default()
    }
}

/// The file with the models' answers in an episode.
fn exchanges_path(out: &Path, number: usize) -> PathBuf {
    out.join("episodes")
        .join(format!("{number:03}.models.jsonl"))
}

fn log_path(out: &Path, number: usize) -> PathBuf {
    out.join("episodes").join(format!("{number:03}.mcap"))
}

fn results(
    request: &RunRequest<'_>,
    traces: &[EpisodeTrace],
    wall_seconds: f64,
    cpu_seconds: f64,
) -> Results {
    let prepared = request.prepared;
    let pairs = prepared.episodes.iter().zip(traces).enumerate();
    let deliveries: Vec<_> = pairs
        .flat_map(|(i, (episode, trace))| deliveries::score_episode(prepared, i, episode, trace))
        .collect();
    let totals = RunTotals {
        sim_seconds: traces.iter().map(|t| t.sim_seconds).sum(),
        wall_seconds,
        cpu_seconds,
        instructions: deliveries::understood(prepared, traces),
        localization: localization(traces.iter().map(|t| &t.pose_errors[..])),
        seed: request.seed,
    };
    Results {
        suite: prepared.suite.name.clone(),
        agent: request.agent.to_owned(),
        seed: request.seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        settings: request.settings.clone(),
        traffic: prepared.suite.traffic,
        metrics: summarize(&deliveries, &totals),
        deliveries,
        models: Some(model_use(traces)).filter(|used| used.calls > 0),
        doors: deliveries::score_written_doors(prepared, traces),
        attribution: prepared.world.attribution.clone(),
    }
}

fn model_use(traces: &[EpisodeTrace]) -> ModelUse {
    traces
        .iter()
        .fold(ModelUse::default(), |sum, trace| sum.plus(trace.models))
}

fn write_files(
    request: &RunRequest<'_>,
    out: &Path,
    traces: &[EpisodeTrace],
    results: &Results,
) -> Result<(), BenchError> {
    let write = |path: PathBuf, bytes: &[u8]| {
        write_atomically(&path, bytes).map_err(|e| BenchError::bad_file(&path, e))
    };
    for (number, trace) in traces.iter().enumerate() {
        if let Some(map) = &trace.map {
            write(out.join("episodes").join(format!("{number:03}.osm")), map)?;
        }
    }
    if let Some(memory) = request.memory {
        write(out.join(MEMORY_BEFORE), &memory.to_xml())?;
    }
    let record = RunRecord {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        suite: request.prepared.suite.clone(),
        agent: request.agent.to_owned(),
        settings: request.settings.clone(),
        seed: request.seed,
        episodes: traces.len(),
        truth: request.prepared.truth.clone(),
    };
    record.write(out)?;
    let input = report_input(request.prepared, results, traces, request.command);
    write(out.join("report.html"), report::render(&input).as_bytes())?;
    Ok(results.write(&out.join("results.json"))?)
}

/// The public map with the doors known before and those found in each episode, in the order of the
/// episodes.
fn merged_memory(request: &RunRequest<'_>, traces: &[EpisodeTrace]) -> OsmData {
    let mut merged = request.prepared.world.map.clone();
    if let Some(memory) = request.memory {
        merge_entrances(&mut merged, memory);
    }
    let maps = traces
        .iter()
        .filter_map(|t| OsmData::from_bytes(t.map.as_deref()?).ok());
    for map in maps {
        merge_entrances(&mut merged, &map);
    }
    merged
}

#[cfg(test)]
mod tests {
    use openbench_core::{Pose2, SimTime};

    use super::*;
    use crate::run::registry::AgentError;

    /// Uses the truth where `pose=true`.
    struct Cheat;

    impl AgentFactory for Cheat {
        fn make(&self, _: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
            Err("not needed here".into())
        }

        fn uses_truth(&self, settings: &AgentSettings) -> bool {
            settings.get("pose").is_some_and(|value| value == "true")
        }
    }

    #[test]
    fn the_true_pose_is_available_only_to_agents_that_use_it() {
        let truth = TruthHandle::default();
        truth.set(SimTime::ZERO, Pose2::new(5.0, 6.0, 0.0));
        let is_available = |value: &str| {
            let settings = AgentSettings::from([("pose".to_owned(), value.to_owned())]);
            let handle = requested_truth(&Cheat, &settings, &truth);
            handle.at(SimTime::ZERO) == Pose2::new(5.0, 6.0, 0.0)
        };
        assert!(is_available("true"));
        assert!(!is_available("estimated"));
    }
}
