//! All episodes of a suite, on several threads; the results do not depend on their number.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use cpu_time::ProcessTime;
use openbench_core::{Agent, Velocity};
use openbench_models::Exchanges;
use openbench_sim::Simulator;
use sha2::{Digest, Sha256};

use crate::BenchError;
use crate::report;
use crate::run::episode::run_episode;
use crate::run::files::{
    REPORT, RESULTS, RUN, actions_path, exchanges_path, log_path, map_path, read_file,
    remove_files_of, write_file,
};
use crate::run::folder::{RunFolder, interrupted_in};
use crate::run::observer::Observer;
use crate::run::output::{FinishedRun, MachineTimes, RunOutput};
use crate::run::reached::Reached;
use crate::run::record::RunRecord;
use crate::run::recorder::Recorder;
use crate::run::recording::{FileHashes, Recording, replay};
use crate::run::registry::AgentRequest;
use crate::run::request::{EpisodeEnd, RunRequest, Unfinished};
use crate::run::rollout::Rollout;
use crate::run::threads;
use crate::run::truth::{Truth, TruthHandle};
use crate::score::deliveries::score_episode;
use crate::score::results::Results;
use crate::trace::EpisodeTrace;
use crate::worlds::Prepared;

/// Runs all episodes of a suite and writes the run's files.
///
/// Files of an earlier run in the same folder are replaced when the new ones are complete. What an
/// interrupted run leaves can be resumed, see [`RunRequest::unfinished`].
///
/// # Errors
/// The error of the first episode that cannot be finished, or of a file that cannot be written;
/// [`BenchError::Busy`] while another process writes to the folder; [`BenchError::Interrupted`].
pub fn run(request: &RunRequest<'_>) -> Result<RunOutput, BenchError> {
    let record = RunRecord::of(request)?;
    match request.out {
        None => Ok(drive_all(request, &record, None)?),
        Some(out) => {
            let folder = match request.unfinished {
                Unfinished::Discard => RunFolder::lock_and_discard(out)?,
                Unfinished::Keep | Unfinished::Resume => RunFolder::lock(out)?,
            };
            begin(request, &record, &folder, out)?;
            let driven = drive_all(request, &record, Some(&folder.unfinished()));
            let output = driven.inspect_err(|_| folder.abandon())?;
            if let Some(path) = request.memory_file {
                write_file(path, &output.memory.to_xml())?;
            }
            folder.publish()?;
            Ok(output)
        }
    }
}

/// A finished run in the folder of a request, compared with what the request would run.
#[derive(Debug)]
#[non_exhaustive]
pub enum FinishedBefore {
    /// There is none.
    Nothing,
    /// The same program, agent and settings, in the same world: the request would give its results.
    Same(Box<Results>),
    /// Another run.
    Other {
        /// In what it differs, for people.
        difference: String,
    },
}

impl FinishedBefore {
    /// What is in the folder of `request`.
    ///
    /// # Errors
    /// Results of the same run that cannot be read, or a request that has no record.
    pub fn of(request: &RunRequest<'_>) -> Result<Self, BenchError> {
        let Some(out) = request.out.filter(|out| out.join(RUN).exists()) else {
            return Ok(Self::Nothing);
        };
        let now = RunRecord::of(request)?;
        // The record of another version, or a damaged one, is that of another run.
        let difference = match RunRecord::read(out) {
            Ok(before) => before.difference(&now),
            Err(unread) => Some(unread.to_string()),
        };
        Ok(match difference {
            None => Self::Same(Box::new(Results::read(&out.join(RESULTS))?)),
            Some(difference) => Self::Other { difference },
        })
    }
}

/// Begins a run in its folder, or checks that the one there can be resumed.
fn begin(
    request: &RunRequest<'_>,
    record: &RunRecord,
    folder: &RunFolder,
    out: &Path,
) -> Result<(), BenchError> {
    let left = interrupted_in(out)?;
    match (request.unfinished, left) {
        (Unfinished::Resume, Some(left)) => match left.record.difference(record) {
            Some(difference) => Err(BenchError::CannotResume {
                folder: out.to_owned(),
                difference,
            }),
            None => Ok(()),
        },
        (Unfinished::Keep, Some(left)) if left.finished > 0 => Err(BenchError::Unfinished {
            folder: out.to_owned(),
            finished: left.finished,
            episodes: left.record.episodes,
        }),
        _ => folder.begin(record, request.memory),
    }
}

/// Runs the episodes; files go into the folder `into`.
fn drive_all(
    request: &RunRequest<'_>,
    record: &RunRecord,
    into: Option<&Path>,
) -> Result<RunOutput, BenchError> {
    let began = Instant::now();
    // CPU time of the whole process: plate readers may have threads of their own.
    let cpu = ProcessTime::now();
    let (reached, resumed) = (Reached::default(), AtomicBool::new(false));
    let sealed_with = resumed_record(request, record, into)?;
    let record = sealed_with.as_ref().unwrap_or(record);
    let traces = for_each_episode(request, |number| {
        // Relaxed suffices: no other memory depends on the flag.
        if request.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Interrupted);
        }
        let finished = into.and_then(|run| finished_episode(request, record, run, number));
        match finished {
            Some(trace) => {
                // Relaxed suffices: the flag is read after all threads have ended.
                resumed.store(true, Ordering::Relaxed);
                reached.note(&trace);
                Ok(trace)
            }
            None => run_one(request, record, into, number, &reached),
        }
    })?;
    let times = MachineTimes {
        wall_seconds: began.elapsed().as_secs_f64(),
        cpu_seconds: cpu.elapsed().as_secs_f64(),
    };
    let run = FinishedRun {
        record,
        prepared: request.prepared,
        memory: request.memory,
        traces: &traces,
        times: Some(times).filter(|_| !resumed.into_inner()),
    };
    let output = run.output();
    if let Some(into) = into {
        let report = report_of(&run, &output.results);
        write_file(&into.join(REPORT), report.as_bytes())?;
        output.results.write(&into.join(RESULTS))?;
    }
    Ok(output)
}

/// The record of the run that is resumed; `None` for a run that begins.
fn resumed_record(
    request: &RunRequest<'_>,
    record: &RunRecord,
    into: Option<&Path>,
) -> Result<Option<RunRecord>, BenchError> {
    // Its processor may be another one, and the recordings are sealed with it.
    let into = into.filter(|_| request.unfinished == Unfinished::Resume);
    let kept = into.map(RunRecord::read).transpose()?;
    Ok(kept.filter(|kept| kept != record))
}

/// The report of a run.
pub(super) fn report_of(run: &FinishedRun<'_>, results: &Results) -> String {
    let command = &run.record.command;
    let input = report::report_input(run.prepared, results, run.traces, command);
    report::render(&input)
}

/// The trace of an episode that the interrupted run has finished. One whose files are damaged is
/// driven again.
fn finished_episode(
    request: &RunRequest<'_>,
    record: &RunRecord,
    run: &Path,
    number: usize,
) -> Option<EpisodeTrace> {
    let replayed = actions_path(run, number)
        .exists()
        .then(|| replay_sealed(request.prepared, record, run, number))?;
    replayed.ok()
}

/// Replays an episode of a run whose files are what its recording says.
pub(super) fn replay_sealed(
    prepared: &Prepared,
    record: &RunRecord,
    run: &Path,
    number: usize,
) -> Result<EpisodeTrace, BenchError> {
    let recording = Recording::read(run, number)?;
    let differs = |detail: String| BenchError::Differs {
        episode: number,
        detail,
    };
    if recording.seed != episode_seed(record.seed, number) {
        return Err(differs("its seed is not that of the run".to_owned()));
    }
    if !recording.is_sealed_by(record, number) {
        let detail = "its seal is broken: the recording or run.json was edited";
        return Err(differs(detail.to_owned()));
    }
    let files = FileHashes::of(run, number)?;
    if let Some(kind) = recording.files.difference(&files) {
        return Err(differs(format!("its {kind} is not the recorded one")));
    }
    let map = files
        .map
        .as_ref()
        .map(|_| read_file(&map_path(run, number)));
    replay(prepared, number, &recording, map.transpose()?)
}

/// Does `work` for the number of each episode, on the threads of the request, and reports progress.
fn for_each_episode(
    request: &RunRequest<'_>,
    work: impl Fn(usize) -> Result<EpisodeTrace, BenchError> + Sync,
) -> Result<Vec<EpisodeTrace>, BenchError> {
    let prepared = request.prepared;
    let numbers = 0..prepared.episodes.len();
    // A plain counter: outcomes are collected on this thread alone.
    let mut ended = 0;
    let work = |number| {
        let trace = work(number)?;
        let episode = &prepared.episodes[number];
        let deliveries = score_episode(prepared, number, episode, &trace);
        Ok::<_, BenchError>((trace, deliveries))
    };
    threads::each(numbers, request.jobs, work, |(trace, deliveries)| {
        ended += 1;
        (request.progress)(&EpisodeEnd { ended, deliveries });
        Ok(trace)
    })
}

/// The seed of an episode.
fn episode_seed(seed: u64, number: usize) -> u64 {
    // 2^64 divided by the golden ratio: the episodes of nearby seeds share no seed.
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(number as u64)
}

/// The seed of an agent in the episode with this seed: an agent that knew the simulator's could
/// draw its noise beforehand.
fn agent_seed(episode: u64) -> u64 {
    let mut hasher = Sha256::new();
    hasher.update(b"agent");
    hasher.update(episode.to_le_bytes());
    let digest = hasher.finalize();
    u64::from_le_bytes(std::array::from_fn(|i| digest[i]))
}

fn run_one(
    request: &RunRequest<'_>,
    record: &RunRecord,
    into: Option<&Path>,
    number: usize,
    reached: &Reached,
) -> Result<EpisodeTrace, BenchError> {
    if let Some(run) = into {
        remove_files_of(run, number)?;
    }
    let exchanges = into.map_or(Exchanges::Unkept, |run| {
        Exchanges::Keep(exchanges_path(run, number))
    });
    // Before the log is begun, so that an agent that cannot be made leaves none behind.
    let made = make(request, number, exchanges)?;
    let mut recorder = match into {
        Some(run) => Recorder::create(&log_path(run, number), request.level, request.prepared)?,
        None => Recorder::none(),
    };
    let trace = drive(request, number, made, &mut recorder)?;
    recorder.finish()?;
    // Before it counts as finished: when the model can be reached, it is driven again.
    reached.check(&trace, number)?;
    if let Some(run) = into {
        if let Some(map) = &trace.map {
            write_file(&map_path(run, number), map)?;
        }
        let mut recording = Recording::of(&trace, episode_seed(request.seed, number));
        recording.files = FileHashes::of(run, number)?;
        // Last: an episode with its recording is finished.
        recording.sealed(record, number).write(run, number)?;
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
    for_each_episode(request, |number| repeat_one(request, run, number))?;
    Ok(())
}

fn repeat_one(
    request: &RunRequest<'_>,
    run: &Path,
    number: usize,
) -> Result<EpisodeTrace, BenchError> {
    let recording = Recording::read(run, number)?;
    let exchanges = Exchanges::Repeat(exchanges_path(run, number));
    let made = make(request, number, exchanges)?;
    let trace = drive(request, number, made, &mut Recorder::none())?;
    let repeated = Recording::of(&trace, episode_seed(request.seed, number));
    recording.compare(number, &repeated)?;
    Ok(trace)
}

/// An agent for an episode.
struct Made {
    agent: Box<dyn Agent>,
    /// What the simulator writes the truth to, for an agent that uses it.
    truth: Option<TruthHandle>,
}

fn make(request: &RunRequest<'_>, number: usize, exchanges: Exchanges) -> Result<Made, BenchError> {
    // A handle for each episode, since episodes run on several threads at once.
    let uses_truth = request.factory.uses_truth(request.settings);
    let truth = uses_truth.then(TruthHandle::default);
    let agent_request = AgentRequest {
        truth: truth.clone().map(|handle| Truth {
            handle,
            prepared: request.prepared,
            episode: number,
        }),
        memory: request.memory,
        settings: request.settings,
        seed: agent_seed(episode_seed(request.seed, number)),
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
    let is_charged_by_clock = request.factory.is_charged_by_clock(request.settings);
    let mut rollout = Rollout::new(request.prepared, number, episode_seed(request.seed, number))?
        .charged_by_clock(is_charged_by_clock)
        .with_observer(StopSign(request.stop))
        .with_observer(recorder);
    if let Some(truth) = truth {
        // Adding it stores time zero, before the agent gets its first observation.
        rollout = rollout.with_observer(truth);
    }
    run_episode(rollout, agent.as_mut())
}

/// Ends an episode when the run is asked to stop.
struct StopSign<'a>(&'a AtomicBool);

impl Observer for StopSign<'_> {
    fn step(&mut self, _: &Simulator, _: Velocity) -> Result<(), BenchError> {
        // Relaxed suffices: no other memory depends on the flag.
        if self.0.load(Ordering::Relaxed) {
            Err(BenchError::Interrupted)
        } else {
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::sync::Mutex;

    use openbench_core::{Action, Agent, Briefing, Events, FailureCause, GiveUp, Observation};

    use super::*;
    use crate::run::registry::AgentError;
    use crate::run::{AgentFactory, AgentRequest};
    use crate::worlds::builtin_suite;

    /// Gives up at once.
    struct Idle;

    impl Agent for Idle {
        fn begin(&mut self, _: &Briefing, _: &mut dyn Events) -> Result<(), GiveUp> {
            Err(GiveUp {
                address: None,
                cause: FailureCause::Briefing,
                detail: String::new(),
            })
        }

        fn act(&mut self, _: &Observation<'_>, _: &mut dyn Events) -> Action {
            Action::Drive(openbench_core::Velocity::ZERO)
        }
    }

    /// Notes the seeds with which it makes agents.
    #[derive(Default)]
    struct Factory(Mutex<Vec<u64>>);

    impl AgentFactory for Factory {
        fn make(&self, request: &AgentRequest<'_>) -> Result<Box<dyn Agent>, AgentError> {
            self.0.lock().unwrap().push(request.seed);
            Ok(Box::new(Idle))
        }
    }

    #[test]
    fn no_agent_gets_a_seed_of_the_simulator() {
        let prepared = Prepared::new(builtin_suite("small").unwrap(), None).unwrap();
        let factory = Factory::default();
        let request = RunRequest::new(&prepared, "idle", &factory);
        for seed in [0, 1] {
            run(&RunRequest { seed, ..request }).unwrap();
        }
        let given = factory.0.into_inner().unwrap();
        assert_eq!(given.len(), 2 * prepared.episodes.len());
        let distinct: BTreeSet<u64> = given.iter().copied().collect();
        assert_eq!(distinct.len(), given.len());
        for seed in [0, 1] {
            let numbers = 0..prepared.episodes.len();
            for used in numbers
                .map(|number| episode_seed(seed, number))
                .chain([seed])
            {
                assert!(!distinct.contains(&used));
            }
        }
    }
}
