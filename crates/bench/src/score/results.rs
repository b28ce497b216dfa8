//! `results.json`: the results of a run for programs.
//!
//! Rates and ratios are between 0 and 1. A metric without a value (LSR without sequences) is null.
//! Confidence intervals are in `intervals`, under the names of their metrics.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use openbench_core::{
    Address, FailureCause, Fallback, MapPoint, ModelUse, Pose2, Start, Work, input,
};
use openbench_osm::disturb::MapState;
use openbench_scene::DrawnDoors;
use openbench_scene::plates::DrawnPlates;
use openbench_scene::scenery::DrawnScenery;
use openbench_sim::traffic::TrafficPlan;
use openbench_sim::{Daylight, Defects, LensBuild};
use serde::{Deserialize, Serialize};

use crate::error::ResultsError;
use crate::score::health::HealthSpan;
use crate::score::metrics::{CollisionSum, DoorScore, EncounterSum, LocalizationSum};
use crate::score::provenance::{Provenance, Setting};
use crate::score::stages::StageSpan;
use crate::suite::split::Split;
use crate::suite::{Conditions, GoalKind, Sensors, TargetSource};
use crate::trace::{Computing, SmoothnessSum};
use crate::worlds::DrawnMap;

/// Bound for a file of results, bytes.
const MOST_BYTES: u64 = 256 << 20;

/// The results of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Results {
    /// Name of the suite.
    pub suite: String,
    /// Name of the agent.
    pub agent: String,
    /// Seed of all random numbers of the run.
    pub seed: u64,
    /// What the world may be used for; absent for worlds from files, which nobody has assigned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split: Option<Split>,
    /// Version of OpenBench.
    pub version: String,
    /// What the results were made from and with.
    #[serde(default)]
    pub provenance: Provenance,
    /// The agent's settings in force.
    #[serde(default)]
    pub settings: BTreeMap<String, Setting>,
    /// Where the doors that the judge expects are known from.
    #[serde(default)]
    pub targets: TargetSource,
    /// What the agent was told to do.
    #[serde(default)]
    pub goal: GoalKind,
    /// People and cars requested by the suite.
    #[serde(default)]
    pub traffic: TrafficPlan,
    /// Sensors in addition to the benchmark's own.
    #[serde(default)]
    pub sensors: Sensors,
    /// What makes the run harder than the paper's; absent if nothing does.
    #[serde(default, skip_serializing_if = "Conditions::are_off")]
    pub conditions: Conditions,
    /// What was drawn for the public map; absent if it is right.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_map: Option<DrawnMap>,
    /// Pose of the world's `map` frame in that of the public map; absent if they are the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub public_frame: Option<Pose2>,
    /// How the robot differed from its description; absent if it did not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_robot: Option<Defects>,
    /// The lens of the camera as it was; absent if it was perfect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_lens: Option<LensBuild>,
    /// Hour, sun, clouds and lamps; absent if the light was the world's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_light: Option<Daylight>,
    /// The doors that were drawn where the map has none; absent if none were to be drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_doors: Option<DrawnDoors>,
    /// The plates that were drawn as in streets; absent if all are as in the published worlds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_plates: Option<DrawnPlates>,
    /// What was drawn to make streets differ; absent if nothing was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_scenery: Option<DrawnScenery>,
    /// The doors from earlier runs that the agent knew; absent without a memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<MemoryUse>,
    /// The metrics.
    pub metrics: Metrics,
    /// The results of the episodes.
    #[serde(default)]
    pub episodes: Vec<EpisodeResult>,
    /// The results of the deliveries, by episode and task.
    pub deliveries: Vec<DeliveryResult>,
    /// The agent's use of language and vision models in all episodes; absent if it used none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub models: Option<ModelTotals>,
    /// Score of the doors that the agent wrote into its map; null if it edits no map.
    #[serde(default)]
    pub doors: Option<DoorScore>,
    /// Attribution required by the licences of the data.
    #[serde(default)]
    pub attribution: Vec<String>,
}

/// The memory that agents began with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryUse {
    /// Number of its doors that the public map does not have.
    pub doors: usize,
    /// BLAKE3 of its map.
    pub hash: String,
}

/// The use of language and vision models in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ModelTotals {
    /// Questions.
    pub calls: u32,
    /// Those without an answer.
    pub failed: u32,
    /// Tokens of the questions, as servers count them.
    pub prompt_tokens: u64,
    /// Tokens of the answers.
    pub completion_tokens: u64,
    /// Time that passed until they were answered, milliseconds; null for a run that was resumed.
    /// Depends on the machine.
    pub latency_ms: Option<u64>,
}

impl From<ModelUse> for ModelTotals {
    fn from(used: ModelUse) -> Self {
        let ModelUse {
            calls,
            failed,
            prompt_tokens,
            completion_tokens,
            latency_ms,
        } = used;
        Self {
            calls,
            failed,
            prompt_tokens,
            completion_tokens,
            latency_ms: Some(latency_ms),
        }
    }
}

/// The result of one episode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EpisodeResult {
    /// Its number in the suite, from 0.
    pub episode: usize,
    /// Simulated time, seconds.
    pub sim_seconds: f64,
    /// Whether the plan was exactly right; false if a planner failed, null if the agent plans none.
    pub understood: Option<bool>,
    /// Parts of the plan that another planner had to make.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallbacks: Vec<Fallback>,
    /// Localization errors; null if the agent reported no pose.
    pub localization: Option<LocalizationSum>,
    /// What the agent was told about the start, in the frame of the public map; absent if that is
    /// the exact pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
    /// The agent's reports on its own pose, in spans of equal health.
    pub health: Vec<HealthSpan>,
    /// What the agent did about its deliveries, one stage after another; absent if it did not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageSpan>,
    /// What computing cost; absent if it was free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub computing: Option<ComputingSum>,
}

/// What computing cost in an episode, in simulated time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ComputingSum {
    /// Time for all of it, seconds.
    pub busy_s: f64,
    /// The part of it that was measured by the clock of the machine, seconds; absent if it is zero.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub by_clock_s: f64,
    /// The longest time between an observation and the decision on it, seconds.
    pub latest_s: f64,
    /// Time in which the robot stood because no decision came, seconds.
    pub held_up_s: f64,
    /// Observations that were lost because the agent was too far behind.
    pub lost_observations: u32,
    /// Requests to language and vision models.
    pub model_calls: u32,
    /// How often each kind of work was done.
    pub work: BTreeMap<Work, u32>,
}

fn is_zero(seconds: &f64) -> bool {
    *seconds == 0.0
}

impl From<&Computing> for ComputingSum {
    fn from(sum: &Computing) -> Self {
        let seconds = |nanoseconds: u64| nanoseconds as f64 * 1e-9;
        Self {
            busy_s: seconds(sum.busy_ns),
            by_clock_s: seconds(sum.by_clock_ns),
            latest_s: seconds(sum.latest_ns),
            held_up_s: seconds(sum.held_up_ns),
            lost_observations: sum.lost_observations,
            model_calls: sum.model_calls,
            work: sum.work.clone(),
        }
    }
}

/// Metrics of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Metrics {
    /// Share of single deliveries declared within 10 m of the plate (paper).
    pub sr_10m: Option<f64>,
    /// SPL of `sr_10m`, where straight lines are the shortest paths (paper).
    pub spl_straight: Option<f64>,
    /// Share of single deliveries declared within 2 m of the correct door's approach point, with
    /// no other door's approach point nearer (strict).
    pub sr_2m: Option<f64>,
    /// `sr_2m` without deliveries in which the robot touched anything.
    #[serde(default)]
    pub sr_clean: Option<f64>,
    /// Share of single deliveries declared with no other door's approach point nearer.
    pub correct_unit: Option<f64>,
    /// SPL of `sr_2m`, with the shortest drivable paths (strict).
    pub spl: Option<f64>,
    /// `sr_10m` of the deliveries of sequences, each of which starts where the last one ended.
    #[serde(default)]
    pub member_sr_10m: Option<f64>,
    /// `spl_straight` of the deliveries of sequences.
    #[serde(default)]
    pub member_spl_straight: Option<f64>,
    /// `sr_2m` of the deliveries of sequences.
    #[serde(default)]
    pub member_sr_2m: Option<f64>,
    /// `sr_clean` of the deliveries of sequences.
    #[serde(default)]
    pub member_sr_clean: Option<f64>,
    /// `correct_unit` of the deliveries of sequences.
    #[serde(default)]
    pub member_correct_unit: Option<f64>,
    /// `spl` of the deliveries of sequences.
    #[serde(default)]
    pub member_spl: Option<f64>,
    /// Mean LSR of the sequences (strict).
    pub lsr: Option<f64>,
    /// Mean LSPL of the sequences (strict).
    pub lspl: Option<f64>,
    /// Mean LSR of the sequences (paper).
    #[serde(default)]
    pub lsr_10m: Option<f64>,
    /// Mean LSPL of the sequences (paper).
    #[serde(default)]
    pub lspl_straight: Option<f64>,
    /// Share of instructions whose plan has exactly the requested doors in an admissible order,
    /// and was made by the requested planner alone.
    #[serde(default)]
    pub srtp: Option<f64>,
    /// The same with plans of which another planner had to make a part.
    #[serde(default)]
    pub srtp_with_fallback: Option<f64>,
    /// Deliveries to buildings that the public map lacks or misnames. The rates above are without
    /// them, apart from LSR and LSPL. Absent if there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmapped: Option<Unmapped>,
    /// Number of collisions.
    pub collisions: usize,
    /// Time in contact with obstacles, seconds.
    #[serde(default)]
    pub contact_s: f64,
    /// Collisions and contacts by class of the object that was hit.
    #[serde(default)]
    pub collisions_by_class: BTreeMap<String, CollisionSum>,
    /// Encounters with people and cars; null in a world without traffic.
    #[serde(default)]
    pub encounters: Option<EncounterSum>,
    /// Localization errors of the agent; null if it reported no pose.
    #[serde(default)]
    pub localization: Option<LocalizationSum>,
    /// Driven distance, metres.
    pub path_m: f64,
    /// Smoothness of the drive.
    #[serde(default)]
    pub smoothness: SmoothnessSum,
    /// Simulated time, seconds.
    pub sim_seconds: f64,
    /// Wall-clock time of the run, seconds; null for a run that was resumed. Depends on the
    /// machine.
    pub wall_seconds: Option<f64>,
    /// Simulated time per CPU time of the process; null for a run that was resumed. Depends on the
    /// machine.
    pub real_time_factor: Option<f64>,
    /// 95 % confidence intervals, lower and upper bound, by name of the metric; null below five
    /// episodes.
    #[serde(default)]
    pub intervals: BTreeMap<String, Option<[f64; 2]>>,
}

/// Metrics of the deliveries to buildings that the public map lacks or misnames.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Unmapped {
    /// Number of these deliveries, in sequences or not.
    pub deliveries: usize,
    /// `sr_10m` of these deliveries.
    pub sr_10m: Option<f64>,
    /// `sr_2m` of these deliveries.
    pub sr_2m: Option<f64>,
    /// `spl` of these deliveries.
    pub spl: Option<f64>,
}

/// The result of one delivery.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeliveryResult {
    /// Episode of the suite, from 0.
    pub episode: usize,
    /// Index of the delivery in the episode, from 0, in driving order.
    pub task: usize,
    /// The instruction of the episode.
    pub instruction: String,
    /// Building of the door.
    pub building: String,
    /// Unit of the door.
    pub unit: Option<String>,
    /// Whether the public map has the building; absent if it has it under its right name.
    #[serde(default, skip_serializing_if = "MapState::is_right")]
    pub on_map: MapState,
    /// Whether it was declared within 10 m of the plate.
    pub success_10m: bool,
    /// Whether it was declared within 2 m of the correct door's approach point, with no other
    /// door's approach point nearer.
    pub success_2m: bool,
    /// Whether it was declared with no other door's approach point nearer.
    pub correct_unit: bool,
    /// Straight-line distance from the position at the end of the delivery to the plate, metres.
    pub distance_to_door_m: Option<f64>,
    /// Distance driven for this delivery, metres.
    pub path_m: f64,
    /// Shortest drivable path from the start of the delivery to the approach point, metres; null if
    /// there is none.
    pub shortest_path_m: Option<f64>,
    /// Straight line that the paper takes as the shortest path, metres.
    pub straight_line_m: f64,
    /// Simulated time of this delivery, seconds.
    pub sim_seconds: f64,
    /// Smoothness of the drive.
    #[serde(default)]
    pub smoothness: SmoothnessSum,
    /// Collisions during this delivery.
    pub collisions: usize,
    /// Time in contact with obstacles, seconds.
    #[serde(default)]
    pub contact_s: f64,
    /// These collisions by class of the object that was hit.
    #[serde(default)]
    pub collisions_by_class: BTreeMap<String, CollisionSum>,
    /// Encounters with people and cars; null in a world without traffic.
    #[serde(default)]
    pub encounters: Option<EncounterSum>,
    /// Position of the declaration, in the `map` frame; null if it was never declared.
    #[serde(default)]
    pub declared_at: Option<MapPoint>,
    /// Position error of the last pose that the agent reported, at the time of the report, metres.
    #[serde(default)]
    pub pose_error_m: Option<f64>,
    /// Number of plates read during this delivery.
    #[serde(default)]
    pub plates_read: usize,
    /// Questions to language and vision models during this delivery.
    #[serde(default)]
    pub model_calls: u32,
    /// Those without an answer.
    #[serde(default)]
    pub model_calls_failed: u32,
    /// Cause of the failure; null if the delivery succeeded.
    pub failure: Option<FailureCause>,
    /// Description of the failure.
    #[serde(default)]
    pub failure_detail: Option<String>,
}

impl DeliveryResult {
    /// Address of the target door.
    pub fn address(&self) -> Address {
        Address {
            building: self.building.clone(),
            unit: self.unit.clone(),
        }
    }
}

impl Results {
    /// Name of the file in the folder of a run.
    pub const FILE: &str = "results.json";

    /// These results without machine-dependent times. Two runs of the same episodes
    /// have equal machine-independent results.
    pub fn machine_independent(&self) -> Self {
        let mut results = self.clone();
        results.metrics.wall_seconds = None;
        results.metrics.real_time_factor = None;
        if let Some(used) = &mut results.models {
            used.latency_ms = None;
        }
        results
    }

    /// Number of episodes in which the pose was wrong by more than a metre while the agent reported
    /// good health.
    pub fn silent_divergences(&self) -> usize {
        let sums = self.episodes.iter().filter_map(|e| e.localization);
        sums.filter(|sum| sum.silent_divergences > 0).count()
    }

    /// Whether a machine can have needed the times in these results. Nobody can compute them again.
    pub(crate) fn has_possible_times(&self) -> bool {
        let Metrics {
            wall_seconds,
            real_time_factor,
            sim_seconds,
            ..
        } = self.metrics;
        let positive = |time: f64| time.is_finite() && time > 0.0;
        // Where no time is simulated, none is simulated in a second of the machine either.
        let fits = |factor: f64| positive(factor) || (factor == 0.0 && sim_seconds == 0.0);
        match wall_seconds {
            Some(wall) => positive(wall) && real_time_factor.is_none_or(fits),
            // A run that was continued has neither.
            None => real_time_factor.is_none(),
        }
    }

    /// These results with the machine-dependent times of others.
    pub(crate) fn with_times_of(mut self, other: &Self) -> Self {
        self.metrics.wall_seconds = other.metrics.wall_seconds;
        self.metrics.real_time_factor = other.metrics.real_time_factor;
        if let (Some(models), Some(other)) = (&mut self.models, &other.models) {
            models.latency_ms = other.latency_ms;
        }
        self
    }

    /// The content of the file.
    pub(crate) fn to_json(&self) -> serde_json::Result<Vec<u8>> {
        let mut json = serde_json::to_vec_pretty(self)?;
        json.push(b'\n');
        Ok(json)
    }

    /// Writes the results to `path`, through a temporary file that is renamed: `path` never
    /// contains a partial file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ResultsError> {
        let file_error = |source| ResultsError::File {
            path: path.to_owned(),
            source,
        };
        let json = self.to_json().map_err(|source| ResultsError::Json {
            path: path.to_owned(),
            source,
        })?;
        let partial = path.with_extension("json.partial");
        fs::write(&partial, json)
            .and_then(|()| fs::rename(&partial, path))
            .map_err(file_error)
    }

    /// Reads a file written by [`write`](Self::write).
    ///
    /// # Errors
    /// A file that cannot be read, or is no results file; the error has line and column.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let json = input::read(path, MOST_BYTES).map_err(|source| ResultsError::File {
            path: path.to_owned(),
            source,
        })?;
        serde_json::from_slice(&json).map_err(|source| ResultsError::Json {
            path: path.to_owned(),
            source,
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A successful delivery: 8 m driven, shortest path 6 m.
    pub(crate) fn delivery(episode: usize, task: usize) -> DeliveryResult {
        DeliveryResult {
            episode,
            task,
            instruction: "Please deliver this box into unit1, building3.".into(),
            building: "building3".into(),
            unit: Some("unit1".into()),
            on_map: MapState::Right,
            success_10m: true,
            success_2m: true,
            correct_unit: true,
            distance_to_door_m: Some(1.5),
            path_m: 8.0,
            shortest_path_m: Some(6.0),
            straight_line_m: 4.0,
            sim_seconds: 20.0,
            smoothness: SmoothnessSum {
                turned_rad: 4.0,
                speed_changes_mps: 2.0,
                stops: 1,
            },
            collisions: 0,
            contact_s: 0.0,
            collisions_by_class: BTreeMap::new(),
            encounters: None,
            declared_at: Some(MapPoint::new(1.0, 2.0)),
            pose_error_m: Some(0.125),
            plates_read: 2,
            model_calls: 0,
            model_calls_failed: 0,
            failure: None,
            failure_detail: None,
        }
    }

    pub(crate) fn results(deliveries: Vec<DeliveryResult>) -> Results {
        Results {
            suite: "small".into(),
            agent: "open".into(),
            seed: 7,
            split: None,
            version: "0.1.0".into(),
            provenance: Provenance::default(),
            settings: BTreeMap::new(),
            targets: TargetSource::World,
            goal: GoalKind::Instruction,
            traffic: TrafficPlan::default(),
            sensors: Sensors::default(),
            conditions: Conditions::default(),
            drawn_map: None,
            public_frame: None,
            drawn_robot: None,
            drawn_lens: None,
            drawn_light: None,
            drawn_doors: None,
            drawn_plates: None,
            drawn_scenery: None,
            memory: None,
            metrics: Metrics::default(),
            episodes: vec![],
            deliveries,
            models: None,
            doors: None,
            attribution: vec![],
        }
    }

    #[test]
    fn results_are_equal_after_writing_and_reading() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("results.json");
        let mut written = results(vec![delivery(0, 0)]);
        written.metrics.sr_2m = Some(1.0 / 3.0);
        written
            .metrics
            .intervals
            .insert("sr_2m".into(), Some([0.1, 0.9]));
        written.write(&path).unwrap();
        assert_eq!(Results::read(&path).unwrap(), written);
        assert_eq!(
            fs::read_dir(dir.path()).unwrap().count(),
            1,
            "the temporary file remains"
        );
    }

    #[test]
    fn json_keys_are_stable() {
        let mut failed = delivery(0, 0);
        failed.failure = Some(FailureCause::DoorNotFound);
        let json = serde_json::to_value(results(vec![failed])).unwrap();
        for key in [
            "sr_10m",
            "spl_straight",
            "sr_2m",
            "correct_unit",
            "spl",
            "lsr",
            "lspl",
            "path_m",
            "real_time_factor",
        ] {
            assert!(json["metrics"].get(key).is_some(), "{key}");
        }
        assert!(json["metrics"]["lsr"].is_null());
        assert_eq!(json["deliveries"][0]["failure"], "door_not_found");
        assert_eq!(json["deliveries"][0]["unit"], "unit1");
    }

    #[test]
    fn other_json_is_rejected_with_line_and_column() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("results.json");
        fs::write(&path, "{\n  \"suite\": 3\n}").unwrap();
        let error = Results::read(&path).unwrap_err().to_string();
        assert!(error.contains("results.json:2:"), "{error}");
        assert!(Results::read(&dir.path().join("none.json")).is_err());
    }
}
