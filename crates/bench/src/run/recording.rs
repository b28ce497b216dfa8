//! What an agent did in an episode, so that it can be driven again and compared.

use std::path::{Path, PathBuf};

use openbench_core::{Action, Velocity};
use openbench_osm::write_atomically;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::BenchError;
use crate::run::rollout::Rollout;
use crate::run::trace::EpisodeTrace;
use crate::suite::Suite;
use crate::worlds::Prepared;

/// Steps of 50 ms in a day: no episode is longer.
const MOST_STEPS: u64 = 24 * 3600 * 20;

/// What was run: enough to run it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Version of OpenBench.
    pub version: String,
    /// The suite.
    pub suite: Suite,
    /// Name of the agent.
    pub agent: String,
    /// What was set with `--set`.
    pub settings: std::collections::BTreeMap<String, String>,
    /// The seed.
    pub seed: u64,
    /// Number of episodes.
    pub episodes: usize,
    /// The file with the true positions, if one was given.
    #[serde(default)]
    pub truth: Option<PathBuf>,
}

impl RunRecord {
    /// Reads the record of the run in a folder.
    pub fn read(run: &Path) -> Result<Self, BenchError> {
        read_json(&run.join("run.json"))
    }

    /// Writes the record of the run in a folder.
    pub fn write(&self, run: &Path) -> Result<(), BenchError> {
        write_json(&run.join("run.json"), self)
    }
}

/// A velocity that was driven for some steps on end.
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
    /// What was driven.
    pub driven: Vec<Stretch>,
    /// SHA-256 over what else the agent did: its plan, which deliveries it declared where or why not, its copy of the map.
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

    /// Whether another drive of the same episode does the same.
    ///
    /// # Errors
    /// [`BenchError::Differs`] with the first step that differs.
    pub fn compare(&self, episode: usize, other: &Self) -> Result<(), BenchError> {
        let steps = |recording: &Self| -> Vec<Velocity> {
            let stretch = |s: &Stretch| {
                std::iter::repeat_n(s.velocity, s.steps.min(MOST_STEPS as u32) as usize)
            };
            recording
                .driven
                .iter()
                .flat_map(stretch)
                .take(MOST_STEPS as usize)
                .collect()
        };
        let (mine, others) = (steps(self), steps(other));
        let say = |v: Option<&Velocity>| {
            v.map_or("has ended".to_owned(), |v| {
                format!("drives {:.3} m/s, {:.3} rad/s", v.linear, v.angular)
            })
        };
        let longer = mine.len().max(others.len());
        let detail = match (0..longer).find(|&i| mine.get(i) != others.get(i)) {
            Some(i) => {
                let (then, now) = (say(mine.get(i)), say(others.get(i)));
                format!(
                    "at step {i} ({:.2} s) the agent {now}; recorded is that it {then}",
                    i as f64 * 0.05
                )
            }
            None if self.chain != other.chain => {
                format!(
                    "after the same steps the hash chain is {}, recorded is {}",
                    other.chain, self.chain
                )
            }
            None if self.deeds != other.deeds => {
                "it drives the same, but plans, declares or maps something else".to_owned()
            }
            None => return Ok(()),
        };
        Err(BenchError::Differs { episode, detail })
    }

    /// The file of an episode's recording.
    pub fn path(run: &Path, episode: usize) -> PathBuf {
        run.join("episodes")
            .join(format!("{episode:03}.actions.json"))
    }

    /// Reads the recording of an episode.
    pub fn read(run: &Path, episode: usize) -> Result<Self, BenchError> {
        read_json(&Self::path(run, episode))
    }

    /// Writes the recording of an episode.
    pub fn write(&self, run: &Path, episode: usize) -> Result<(), BenchError> {
        write_json(&Self::path(run, episode), self)
    }
}

/// Drives the recorded actions of an episode again and compares the hash chains.
pub fn verify(
    prepared: &Prepared,
    episode: usize,
    recording: &Recording,
) -> Result<(), BenchError> {
    let steps: u64 = recording.driven.iter().map(|s| u64::from(s.steps)).sum();
    if steps > MOST_STEPS {
        let detail =
            format!("{steps} recorded steps are more than a day; the recording is damaged");
        return Err(BenchError::Differs { episode, detail });
    }
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
    let detail = format!("after {seconds:.2} s the hash chain is {chain}, recorded is {recorded}");
    Err(BenchError::Differs { episode, detail })
}

fn deeds(trace: &EpisodeTrace) -> String {
    let mut hasher = Sha256::new();
    let mut part = |bytes: &[u8]| {
        hasher.update((bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    part(&serde_json::to_vec(&trace.plan).unwrap_or_default());
    for task in &trace.tasks {
        part(
            format!(
                "{} {} {:?} {:?}",
                task.target, task.declared, task.ended, task.failure
            )
            .as_bytes(),
        );
    }
    part(trace.map.as_deref().unwrap_or_default());
    hex(&hasher.finalize())
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
    fn the_first_step_that_differs_is_named() {
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
    fn equal_velocities_are_counted() {
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
