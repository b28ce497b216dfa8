//! All episodes of a suite, on several threads; the results do not depend on their number.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use cpu_time::ProcessTime;
use openbench_core::{Agent, FailureCause};
use openbench_models::Exchanges;
use sha2::{Digest, Sha256};

use crate::BenchError;
use crate::run::episode::run_episode;
use crate::run::folder::{create_folder, exchanges_path, log_path, write_files};
use crate::run::output::{MachineTimes, RunOutput};
use crate::run::recorder::Recorder;
use crate::run::recording::Recording;
use crate::run::registry::{AgentFactory, AgentRequest, AgentSettings};
use crate::run::request::RunRequest;
use crate::run::rollout::Rollout;
use crate::run::threads;
use crate::run::truth::TruthHandle;
use crate::trace::EpisodeTrace;

/// Runs all episodes of a suite and writes the run's files.
///
/// Files of an earlier run in the same folder are removed first.
///
/// # Errors
/// The error of the first episode that cannot be finished, or of a file that cannot be written.
pub fn run(request: &RunRequest<'_>) -> Result<RunOutput, BenchError> {
    let began = Instant::now();
    if let Some(out) = request.out {
        // An agent that refuses its settings must not cost the results of the run before. This one
        // is dropped: that of episode 0 keeps its models' answers in the new folder.
        if !request.prepared.episodes.is_empty() {
            make(request, 0, Exchanges::Unkept)?;
        }
        create_folder(out)?;
    }
    // CPU time of the whole process: plate readers may have threads of their own.
    let cpu = ProcessTime::now();
    let reached = AtomicBool::new(false);
    let traces = for_each_episode(request, |number| {
        let trace = run_one(request, number)?;
        check_reached(&trace, number, &reached)?;
        Ok(trace)
    })?;
    let times = MachineTimes {
        wall_seconds: began.elapsed().as_secs_f64(),
        cpu_seconds: cpu.elapsed().as_secs_f64(),
    };
    let output = RunOutput::new(request, &traces, times);
    if let Some(out) = request.out {
        write_files(request, out, &traces, &output.results)?;
    }
    Ok(output)
}

/// Does `work` for the number of each episode, on the threads of the request, and reports progress.
fn for_each_episode<T: Send>(
    request: &RunRequest<'_>,
    work: impl Fn(usize) -> Result<T, BenchError> + Sync,
) -> Result<Vec<T>, BenchError> {
    let numbers = 0..request.prepared.episodes.len();
    // A plain counter: outcomes are collected on this thread alone.
    let mut finished = 0;
    threads::each(numbers, request.jobs, work, |outcome| {
        finished += 1;
        (request.progress)(finished);
        Ok(outcome)
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

/// Ends a run whose planner asks a model that has never answered: all its deliveries would fail for
/// a reason that says nothing about the model. `reached` says whether one has answered so far.
fn check_reached(
    trace: &EpisodeTrace,
    episode: usize,
    reached: &AtomicBool,
) -> Result<(), BenchError> {
    // Relaxed suffices: the flag alone is shared, and it only ever rises.
    if trace.models.calls > trace.models.failed {
        reached.store(true, Ordering::Relaxed);
    }
    let gave_up = trace.tasks.iter().find_map(|task| {
        let failure = task.failure.as_ref()?;
        (failure.cause == FailureCause::PlannerUnavailable).then_some(failure)
    });
    match gave_up {
        Some(failure) if trace.models.failed > 0 && !reached.load(Ordering::Relaxed) => {
            Err(BenchError::Unreachable {
                episode,
                detail: failure.detail.clone(),
            })
        }
        _ => Ok(()),
    }
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

fn repeat_one(request: &RunRequest<'_>, run: &Path, number: usize) -> Result<(), BenchError> {
    let recording = Recording::read(run, number)?;
    let exchanges = Exchanges::Repeat(exchanges_path(run, number));
    let made = make(request, number, exchanges)?;
    let trace = drive(request, number, made, &mut Recorder::none())?;
    let repeated = Recording::of(&trace, episode_seed(request.seed, number));
    recording.compare(number, &repeated)
}

/// An agent for an episode.
struct Made {
    agent: Box<dyn Agent>,
    /// What the simulator writes the true pose to.
    truth: TruthHandle,
}

fn make(request: &RunRequest<'_>, number: usize, exchanges: Exchanges) -> Result<Made, BenchError> {
    // A handle for each episode, since episodes run on several threads at once.
    let truth = TruthHandle::default();
    let agent_request = AgentRequest {
        truth: requested_truth(request.factory, request.settings, &truth),
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
    let rollout = Rollout::new(request.prepared, number, episode_seed(request.seed, number))?
        // Adding it stores the pose at time zero, before the agent gets its first observation.
        .with_observer(truth)
        .with_observer(recorder);
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

#[cfg(test)]
mod tests {
    use openbench_core::{ModelUse, Pose2, SimTime};

    use super::*;
    use crate::run::registry::AgentError;
    use crate::trace::{Failure, TaskOutcome};

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

    /// An episode whose planner got no answer to some of its questions.
    fn unanswered(calls: u32, failed: u32) -> EpisodeTrace {
        let failure = Failure {
            cause: FailureCause::PlannerUnavailable,
            detail: "connection refused".into(),
        };
        EpisodeTrace {
            tasks: vec![TaskOutcome::failed(0, failure)],
            models: ModelUse {
                calls,
                failed,
                ..ModelUse::default()
            },
            ..EpisodeTrace::default()
        }
    }

    #[test]
    fn a_run_ends_if_its_model_has_never_answered() {
        let reached = AtomicBool::new(false);
        let error = check_reached(&unanswered(1, 1), 3, &reached).unwrap_err();
        assert!(error.to_string().contains("connection refused"), "{error}");
        // A planner that asks no model, and one whose model answered nonsense, fail deliveries.
        assert!(check_reached(&unanswered(0, 0), 3, &reached).is_ok());
        assert!(check_reached(&unanswered(2, 0), 3, &reached).is_ok());
        // Once it has answered, a silence fails a delivery only.
        assert!(check_reached(&unanswered(1, 1), 4, &reached).is_ok());
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
