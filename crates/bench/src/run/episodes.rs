//! All episodes of a suite, on several threads; the results do not depend on their number.

use std::path::Path;
use std::time::Instant;

use cpu_time::ProcessTime;
use openbench_core::Agent;
use openbench_models::Exchanges;

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
    let traces = for_each_episode(request, |number| run_one(request, number))?;
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
