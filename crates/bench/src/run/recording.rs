//! The recorded actions of an episode, which can be replayed and compared.

use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use openbench_core::{Action, SimTime, Velocity};
use serde::{Deserialize, Serialize};

use super::files::{actions_path, exchanges_path, log_path, map_path, read_json, write_json};
use super::record::RunRecord;
use crate::BenchError;
use crate::run::rollout::Rollout;
use crate::trace::{Deed, EpisodeTrace, Frame, Number, Reading, TimedDeed};
use crate::worlds::Prepared;
use crate::worlds::hashes::{hash_bytes, hash_file};

/// Simulated time of a step.
const STEP_S: f64 = 0.05;
/// Steps of 50 ms in a day, which no episode exceeds.
const MAX_STEPS: u64 = 24 * 3600 * 20;

/// A velocity that was commanded for a number of consecutive steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Number of steps of 50 ms.
    pub steps: u32,
    /// The velocity.
    pub velocity: Velocity,
}

/// An image of the trace, as JPEG in base64.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptFrame {
    /// Time of the event with the image.
    pub time: SimTime,
    /// Columns, pixels.
    pub width: u32,
    /// Rows, pixels.
    pub height: u32,
    /// The image.
    pub jpeg: String,
}

/// BLAKE3 of the other files of an episode, hexadecimal; null for files that there are not.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileHashes {
    /// The agent's copy of the map.
    pub map: Option<String>,
    /// The log.
    pub log: Option<String>,
    /// The answers of models.
    pub models: Option<String>,
}

impl FileHashes {
    /// The hashes of an episode's files in the folder `run`.
    pub(super) fn of(run: &Path, number: usize) -> Result<Self, BenchError> {
        let hash = |path: PathBuf| path.exists().then(|| hash_file(&path)).transpose();
        Ok(Self {
            map: hash(map_path(run, number))?,
            log: hash(log_path(run, number))?,
            models: hash(exchanges_path(run, number))?,
        })
    }

    /// The kind of file that is another one.
    pub(super) fn difference(&self, found: &Self) -> Option<&'static str> {
        let kinds = [
            ("map", &self.map, &found.map),
            ("log", &self.log, &found.log),
            ("record of answers", &self.models, &found.models),
        ];
        let other = kinds.into_iter().find(|(_, then, now)| then != now);
        other.map(|(kind, _, _)| kind)
    }
}

/// All that an agent did in an episode, and the hash chain over the states that followed. The
/// trace of the episode is what a replay gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Seed of the episode.
    pub seed: u64,
    /// Hash chain over all states, after the last step, hexadecimal.
    pub chain: String,
    /// BLAKE3 over the record of the run, the number of the episode and this recording,
    /// hexadecimal.
    pub seal: String,
    /// The other files of the episode.
    pub files: FileHashes,
    /// The commanded velocities, run-length encoded.
    pub driven: Vec<Stretch>,
    /// What the agent did besides driving, in the order of time.
    pub deeds: Vec<TimedDeed>,
    /// The last images in which plates were read, oldest first.
    pub frames: Vec<KeptFrame>,
}

impl Recording {
    /// The recording of a trace, without a seal.
    pub fn of(trace: &EpisodeTrace, seed: u64) -> Self {
        let mut driven: Vec<Stretch> = Vec::new();
        for &velocity in &trace.velocities {
            match driven.last_mut() {
                Some(last) if is_same(last.velocity, velocity) => last.steps += 1,
                _ => driven.push(Stretch { steps: 1, velocity }),
            }
        }
        Self {
            seed,
            chain: hex(&trace.chain),
            seal: String::new(),
            files: FileHashes {
                map: trace.map.as_deref().map(hash_bytes),
                ..FileHashes::default()
            },
            driven,
            deeds: trace.deeds.clone(),
            frames: trace.frames.iter().map(kept).collect(),
        }
    }

    /// The recording of episode `number` of a run, sealed: neither its own content nor the record
    /// of the run can be edited without breaking the seal.
    #[must_use]
    pub fn sealed(mut self, run: &RunRecord, number: usize) -> Self {
        self.seal = self.seal_of(run, number);
        self
    }

    /// Whether the seal is that of the run, the episode and the content.
    pub fn is_sealed_by(&self, run: &RunRecord, number: usize) -> bool {
        self.seal == self.seal_of(run, number)
    }

    fn seal_of(&self, run: &RunRecord, number: usize) -> String {
        let open = Self {
            seal: String::new(),
            ..self.clone()
        };
        let mut hasher = blake3::Hasher::new();
        hasher.update(&run.hash());
        hasher.update(&(number as u64).to_le_bytes());
        // Numbers, strings and lists: every value has a JSON form.
        hasher.update(&serde_json::to_vec(&open).unwrap_or_default());
        hasher.finalize().to_hex().to_string()
    }

    /// Compares with a recording of the same episode, made later by its agent.
    ///
    /// # Errors
    /// [`BenchError::Differs`] with the first step that differs.
    pub fn compare(&self, episode: usize, other: &Self) -> Result<(), BenchError> {
        let (recorded, repeated) = (self.velocities(), other.velocities());
        let longer = recorded.len().max(repeated.len());
        // Equal to the bit: JSON keeps every digit of a double.
        let first = (0..longer).find(|&step| match (recorded.get(step), repeated.get(step)) {
            (Some(a), Some(b)) => !is_same(*a, *b),
            _ => true,
        });
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
            None => match self.other_deed(other) {
                Some(detail) => detail,
                None if self.files.map != other.files.map => {
                    "all actions are the same, but the agent's map differs".to_owned()
                }
                None => return Ok(()),
            },
        };
        Err(BenchError::Differs { episode, detail })
    }

    /// The first deed that another recording has otherwise.
    fn other_deed(&self, other: &Self) -> Option<String> {
        let longer = self.deeds.len().max(other.deeds.len());
        let repeatable = |deeds: &[TimedDeed], i: usize| deeds.get(i).map(repeatable);
        let first =
            (0..longer).find(|&i| repeatable(&self.deeds, i) != repeatable(&other.deeds, i))?;
        let deed = self.deeds.get(first).or(other.deeds.get(first))?;
        Some(format!(
            "the velocities are the same, but {} differs at step {} ({:.2} s)",
            name(&deed.deed),
            deed.step,
            f64::from(deed.step) * STEP_S
        ))
    }

    /// The velocity of each step, for a day at most: a damaged file may contain any count.
    fn velocities(&self) -> Vec<Velocity> {
        self.driven
            .iter()
            .flat_map(|s| std::iter::repeat_n(s.velocity, s.steps.min(MAX_STEPS as u32) as usize))
            .take(MAX_STEPS as usize)
            .collect()
    }

    /// Reads the recording of an episode from the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::File`] or [`BenchError::WrongFormat`].
    pub fn read(run: &Path, episode: usize) -> Result<Self, BenchError> {
        read_json(&actions_path(run, episode), "recording of an episode")
    }

    /// Writes the recording of an episode into the folder `run`.
    ///
    /// # Errors
    /// [`BenchError::BadFile`].
    pub fn write(&self, run: &Path, episode: usize) -> Result<(), BenchError> {
        write_json(&actions_path(run, episode), self)
    }
}

/// Replays a recorded episode: the trace of the same actions in the same world. `map` is the
/// agent's copy of the map, if it edited one.
///
/// # Errors
/// [`BenchError::Differs`] if the replay gives other states or ends earlier, or an error of the
/// rollout.
pub fn replay(
    prepared: &Prepared,
    episode: usize,
    recording: &Recording,
    map: Option<Vec<u8>>,
) -> Result<EpisodeTrace, BenchError> {
    let differs = |detail: String| Err(BenchError::Differs { episode, detail });
    // In 64 bits: the counts of a damaged file may overflow 32.
    let steps: u64 = recording.driven.iter().map(|s| u64::from(s.steps)).sum();
    if steps > MAX_STEPS {
        return differs(format!(
            "the recording is damaged: its {steps} steps are longer than a day"
        ));
    }
    let mut rollout = Rollout::new(prepared, episode, recording.seed)?;
    let mut deeds = recording.deeds.iter().peekable();
    let stretches = recording.driven.iter();
    let velocities = stretches.flat_map(|s| std::iter::repeat_n(s.velocity, s.steps as usize));
    for velocity in velocities {
        let step = rollout.steps();
        let mut action = Action::Drive(velocity);
        while let Some(timed) = deeds.next_if(|timed| timed.step <= step) {
            match &timed.deed {
                Deed::Delivered(address) => action = Action::Delivered(address.clone()),
                Deed::GaveUp(give_up) => action = Action::GiveUp(give_up.clone()),
                report => rollout.repeat(report),
            }
        }
        rollout.step(action);
        if rollout.steps() == step {
            break;
        }
    }
    deeds.for_each(|timed| rollout.repeat(&timed.deed));
    let mut trace = rollout.finish(map)?;
    trace.frames = frames(&recording.frames);
    let again = Recording::of(&trace, recording.seed);
    let (seconds, recorded) = (trace.sim_seconds, &recording.chain);
    if again.chain != *recorded {
        let chain = again.chain;
        return differs(format!(
            "after {seconds:.2} s the hash chain is {chain} instead of {recorded}"
        ));
    }
    if again.driven != recording.driven || again.deeds != recording.deeds {
        return differs(format!(
            "the episode ends after {seconds:.2} s, but the recording contains other or further \
             actions"
        ));
    }
    Ok(trace)
}

/// By bits, as the recording keeps them: 0.0 is not -0.0.
fn is_same(a: Velocity, b: Velocity) -> bool {
    let bits = |v: Velocity| (v.linear.to_bits(), v.angular.to_bits());
    bits(a) == bits(b)
}

/// A deed without what a repetition may have otherwise: the last bits of networks, which depend on
/// the processor.
fn repeatable(timed: &TimedDeed) -> TimedDeed {
    let none = Number::new(0.0);
    let deed = match &timed.deed {
        Deed::Read(reading) => Deed::Read(Reading {
            text: reading.text.clone(),
            confidence: none,
            corners: [[none; 2]; 4],
        }),
        other => other.clone(),
    };
    TimedDeed { deed, ..*timed }
}

fn name(deed: &Deed) -> &'static str {
    match deed {
        Deed::Refused(_) => "the refusal",
        Deed::Planned(_) => "the plan",
        Deed::Began(_) => "a stage",
        Deed::Routed(_) => "a route",
        Deed::Estimated(..) | Deed::EstimatedAt(..) => "an estimated pose",
        Deed::Compared(_) => "what was found on the map",
        Deed::WroteDoor(..) => "a door in the agent's map",
        Deed::Read(_) => "a plate",
        Deed::Asked(_) => "the use of models",
        Deed::Computed(_) => "what was computed",
        Deed::Delivered(_) | Deed::GaveUp(_) => "a declaration",
    }
}

fn kept(frame: &Frame) -> KeptFrame {
    KeptFrame {
        time: frame.time,
        width: frame.width,
        height: frame.height,
        jpeg: STANDARD.encode(&frame.jpeg),
    }
}

fn frames(kept: &[KeptFrame]) -> Vec<Frame> {
    let frame = |kept: &KeptFrame| Frame {
        time: kept.time,
        width: kept.width,
        height: kept.height,
        // What is no base64 is no image; the seal tells.
        jpeg: STANDARD.decode(&kept.jpeg).unwrap_or_default(),
    };
    kept.iter().map(frame).collect()
}

/// A velocity in words; `None` after the end of the episode.
fn describe(velocity: Option<&Velocity>) -> String {
    match velocity {
        Some(v) => format!("drives {:.3} m/s, {:.3} rad/s", v.linear, v.angular),
        None => "has ended".to_owned(),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use openbench_core::Address;

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
        let declared = TimedDeed {
            step: 2,
            deed: Deed::Delivered(Address::new("building1", "unit1")),
        };
        let other_deed = Recording {
            deeds: vec![declared],
            ..then.clone()
        };
        let error = then.compare(0, &other_deed).unwrap_err().to_string();
        assert!(error.contains("a declaration differs at step 2"), "{error}");
    }

    #[test]
    fn the_last_bits_of_networks_may_differ() {
        let of = |confidence: f64| {
            let reading = Reading {
                text: "UNIT 1".into(),
                confidence: Number::new(confidence),
                corners: [[Number::new(1.0); 2]; 4],
            };
            let deed = Deed::Read(reading);
            EpisodeTrace {
                deeds: vec![TimedDeed { step: 1, deed }],
                ..EpisodeTrace::default()
            }
        };
        let then = Recording::of(&of(0.9), 0);
        assert!(then.compare(0, &Recording::of(&of(0.900001), 0)).is_ok());
    }

    #[test]
    fn equal_velocities_are_run_length_encoded() {
        let (go, stop) = (Velocity::new(0.1 + 0.2, 0.0), Velocity::ZERO);
        let trace = EpisodeTrace {
            velocities: vec![go, go, stop, Velocity::new(-0.0, 0.0), go],
            ..EpisodeTrace::default()
        };
        let recording = Recording::of(&trace, 3);
        assert_eq!(
            recording.driven.iter().map(|s| s.steps).collect::<Vec<_>>(),
            [2, 1, 1, 1]
        );
        let json = serde_json::to_string(&recording).unwrap();
        assert_eq!(
            serde_json::from_str::<Recording>(&json).unwrap(),
            recording,
            "to the last bit"
        );
    }
}
