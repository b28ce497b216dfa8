//! The recorded actions of an episode, which can be replayed and compared.

use std::path::{Path, PathBuf};

use openbench_core::{Action, Velocity};
use openbench_osm::write_atomically;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::BenchError;
use crate::run::rollout::Rollout;
use crate::suite::Suite;
use crate::trace::{EpisodeTrace, TaskOutcome};
use crate::worlds::Prepared;

/// Simulated time of a step.
const STEP_S: f64 = 0.05;
/// Steps of 50 ms in a day, which no episode exceeds.
const MAX_STEPS: u64 = 24 * 3600 * 20;

/// The parameters of a run, sufficient to repeat it: the file `run.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Version of OpenBench.
    pub version: String,
    /// The suite.
    pub suite: Suite,
    /// Name of the agent.
    pub agent: String,
    /// The agent's settings (`--set KEY=VALUE`).
    pub settings: std::collections::BTreeMap<String, String>,
    /// Seed of all random numbers of the run.
    pub seed: u64,
    /// Number of episodes.
    pub episodes: usize,
    /// The file with the true positions of the doors, if one was given.
    #[serde(default)]
    pub truth: Option<PathBuf>,
}

impl RunRecord {
    /// Reads the record of the run in the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::File`] or [`BenchError::WrongFormat`].
    pub fn read(run: &Path) -> Result<Self, BenchError> {
        read_json(&run.join("run.json"))
    }

    /// Writes the record of the run into the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::BadFile`].
    pub fn write(&self, run: &Path) -> Result<(), BenchError> {
        write_json(&run.join("run.json"), self)
    }
}

/// A velocity that was commanded for a number of consecutive steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Number of steps of 50 ms.
    pub steps: u32,
    /// The velocity.
    pub velocity: Velocity,
}

/// The actions of an episode and the hash chain over its states.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Seed of the episode.
    pub seed: u64,
    /// Hash chain after the last step, hexadecimal.
    pub chain: String,
    /// The commanded velocities, run-length encoded.
    pub driven: Vec<Stretch>,
    /// SHA-256 over the agent's other actions, hexadecimal: its plan, its declarations and
    /// failures, and its copy of the map.
    #[serde(default)]
    pub deeds: String,
}

impl Recording {
    /// The recording of a trace.
    pub fn of(trace: &EpisodeTrace, seed: u64) -> Self {
        let mut driven: Vec<Stretch> = Vec::new();
        for &velocity in &trace.velocities {
            match driven.last_mut() {
                Some(last) if last.velocity == velocity => last.steps += 1,
                _ => driven.push(Stretch { steps: 1, velocity }),
            }
        }
        Self {
            seed,
            chain: hex(&trace.chain),
            driven,
            deeds: deeds(trace),
        }
    }

    /// Compares with a recording of the same episode, made later.
    ///
    /// # Errors
    /// [`BenchError::Differs`] with the first step that differs.
    pub fn compare(&self, episode: usize, other: &Self) -> Result<(), BenchError> {
        let (recorded, repeated) = (self.velocities(), other.velocities());
        let longer = recorded.len().max(repeated.len());
        // Equal to the bit: JSON keeps every digit of a double.
        let first = (0..longer).find(|&step| recorded.get(step) != repeated.get(step));
        let detail = match first {
            Some(step) => format!(
                "at step {step} ({:.2} s) the agent {}, but in the recording it {}",
                step as f64 * STEP_S,
                describe(repeated.get(step)),
                describe(recorded.get(step)),
            ),
            // Equal velocities must lead to equal states. The simulation differs here, not the
            // agent.
            None if self.chain != other.chain => format!(
                "the velocities are the same, but the hash chain is {} instead of {}",
                other.chain, self.chain
            ),
            None if self.deeds != other.deeds => {
                "the velocities are the same, but the plan, the declarations or the map differ"
                    .to_owned()
            }
            None => return Ok(()),
        };
        Err(BenchError::Differs { episode, detail })
    }

    /// The velocity of each step, for a day at most: a damaged file may contain any count.
    fn velocities(&self) -> Vec<Velocity> {
        self.driven
            .iter()
            .flat_map(|s| std::iter::repeat_n(s.velocity, s.steps.min(MAX_STEPS as u32) as usize))
            .take(MAX_STEPS as usize)
            .collect()
    }

    /// The file of an episode's recording in the folder `run`.
    pub fn path(run: &Path, episode: usize) -> PathBuf {
        run.join("episodes")
            .join(format!("{episode:03}.actions.json"))
    }

    /// Reads the recording of an episode from the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::File`] or [`BenchError::WrongFormat`].
    pub fn read(run: &Path, episode: usize) -> Result<Self, BenchError> {
        read_json(&Self::path(run, episode))
    }

    /// Writes the recording of an episode into the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::BadFile`].
    pub fn write(&self, run: &Path, episode: usize) -> Result<(), BenchError> {
        write_json(&Self::path(run, episode), self)
    }
}

/// Replays the recorded velocities of an episode and compares the hash chains.
///
/// # Errors
/// [`BenchError::Differs`], or an error of the rollout.
pub fn verify(
    prepared: &Prepared,
    episode: usize,
    recording: &Recording,
) -> Result<(), BenchError> {
    // In 64 bits: the counts of a damaged file may overflow 32.
    let steps: u64 = recording.driven.iter().map(|s| u64::from(s.steps)).sum();
    if steps > MAX_STEPS {
        let detail = format!("the recording is damaged: its {steps} steps are longer than a day");
        return Err(BenchError::Differs { episode, detail });
    }
    // Declarations are not replayed. They do not move the robot, and without them the episode
    // cannot end before its last step.
    let mut rollout = Rollout::new(prepared, episode, recording.seed)?;
    for stretch in &recording.driven {
        for _ in 0..stretch.steps {
            rollout.step(Action::Drive(stretch.velocity));
        }
    }
    let trace = rollout.finish(None)?;
    let chain = hex(&trace.chain);
    if chain == recording.chain {
        return Ok(());
    }
    let (seconds, recorded) = (trace.sim_seconds, &recording.chain);
    let detail = format!("after {seconds:.2} s the hash chain is {chain} instead of {recorded}");
    Err(BenchError::Differs { episode, detail })
}

/// A velocity in words; `None` after the end of the episode.
fn describe(velocity: Option<&Velocity>) -> String {
    match velocity {
        Some(v) => format!("drives {:.3} m/s, {:.3} rad/s", v.linear, v.angular),
        None => "has ended".to_owned(),
    }
}

/// SHA-256 over plan, outcomes and map, each preceded by its length.
fn deeds(trace: &EpisodeTrace) -> String {
    let mut hasher = Sha256::new();
    update_with_length(
        &mut hasher,
        &serde_json::to_vec(&trace.plan).unwrap_or_default(),
    );
    for task in &trace.tasks {
        update_with_length(&mut hasher, describe_outcome(task).as_bytes());
    }
    update_with_length(&mut hasher, trace.map.as_deref().unwrap_or_default());
    hex(&hasher.finalize())
}

/// Without the lengths, different parts could be concatenated to the same bytes.
fn update_with_length(hasher: &mut Sha256, part: &[u8]) {
    hasher.update((part.len() as u64).to_le_bytes());
    hasher.update(part);
}

/// The outcome of a delivery as it is hashed.
///
/// The description of a failure is part of it, so another wording gives another hash. Recordings
/// are compared within one version only, where an agent that repeats repeats its words too.
fn describe_outcome(task: &TaskOutcome) -> String {
    let failure = task.failure.as_ref().map(|f| (f.cause, &f.detail));
    let TaskOutcome {
        target,
        declared,
        ended,
        ..
    } = task;
    format!("{target} {declared} {ended:?} {failure:?}")
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, BenchError> {
    let text = std::fs::read_to_string(path).map_err(|e| BenchError::file(path, e))?;
    serde_json::from_str(&text).map_err(|e| BenchError::wrong_format(path, "record of a run", e))
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), BenchError> {
    let json = serde_json::to_vec(value).map_err(|e| BenchError::bad_file(path, e))?;
    write_atomically(path, &json).map_err(|e| BenchError::bad_file(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_differing_step_is_reported() {
        let of = |velocities: &[f64]| {
            let velocities = velocities.iter().map(|v| Velocity::new(*v, 0.0)).collect();
            Recording::of(
                &EpisodeTrace {
                    velocities,
                    ..EpisodeTrace::default()
                },
                0,
            )
        };
        let then = of(&[0.1, 0.1, 0.2]);
        assert!(then.compare(0, &of(&[0.1, 0.1, 0.2])).is_ok());
        let said = |now: &[f64]| then.compare(3, &of(now)).unwrap_err().to_string();
        assert!(said(&[0.1, 0.3, 0.2]).contains("at step 1 (0.05 s) the agent drives 0.300"));
        assert!(said(&[0.1, 0.1]).contains("at step 2 (0.10 s) the agent has ended"));
        let other_state = Recording {
            chain: "00".into(),
            ..then.clone()
        };
        assert!(then.compare(0, &other_state).is_err());
        let other_deeds = Recording {
            deeds: "00".into(),
            ..then.clone()
        };
        assert!(then.compare(0, &other_deeds).is_err());
    }

    #[test]
    fn equal_velocities_are_run_length_encoded() {
        let (go, stop) = (Velocity::new(0.1 + 0.2, 0.0), Velocity::ZERO);
        let trace = EpisodeTrace {
            velocities: vec![go, go, stop, go],
            ..EpisodeTrace::default()
        };
        let recording = Recording::of(&trace, 3);
        assert_eq!(
            recording.driven.iter().map(|s| s.steps).collect::<Vec<_>>(),
            [2, 1, 1]
        );
        let json = serde_json::to_string(&recording).unwrap();
        assert_eq!(
            serde_json::from_str::<Recording>(&json).unwrap(),
            recording,
            "to the last bit"
        );
    }
}
