//! `results.json`: what a run yields for programs.
//!
//! Rates and ratios are between 0 and 1. A metric that has no value (LSR without sequences) is null. Intervals stand
//! beside the plain numbers, under the same names.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use openbench_core::{Address, FailureCause, MapPoint, ModelUse};
use openbench_sim::traffic::TrafficPlan;
use serde::{Deserialize, Serialize};

use crate::score::metrics::{
    CollisionSum, DoorScore, EncounterSum, LocalizationSum, SmoothnessSum,
};

/// The results of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Name of the suite.
    pub suite: String,
    /// Name of the agent.
    pub agent: String,
    /// The seed that all randomness of the run comes from.
    pub seed: u64,
    /// Version of OpenBench.
    pub version: String,
    /// What was set with `--set`.
    #[serde(default)]
    pub settings: BTreeMap<String, String>,
    /// People and cars that the suite asks for.
    #[serde(default)]
    pub traffic: TrafficPlan,
    /// Over all deliveries.
    pub metrics: Metrics,
    /// One a delivery, by episode and task.
    pub deliveries: Vec<DeliveryResult>,
    /// What the agent asked of language and vision models in all episodes; not there if it asked none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub models: Option<ModelUse>,
    /// The doors that the agent wrote into its map; null if it edits none.
    #[serde(default)]
    pub doors: Option<DoorScore>,
    /// What the licences of the data ask to be said.
    #[serde(default)]
    pub attribution: Vec<String>,
}

/// Metrics of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Metrics {
    /// Share of deliveries declared within 10 m of the plate (paper).
    pub sr_10m: Option<f64>,
    /// SPL of those, against straight lines (paper).
    pub spl_straight: Option<f64>,
    /// Share of deliveries declared within 2 m of the right door's approach point, no other door's being nearer (strict).
    pub sr_2m: Option<f64>,
    /// Share of deliveries declared nearer to the right door's approach point than to any other's.
    pub correct_unit: Option<f64>,
    /// SPL of `sr_2m`, against the shortest drivable paths (strict).
    pub spl: Option<f64>,
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
    /// Share of instructions that were understood exactly.
    #[serde(default)]
    pub srtp: Option<f64>,
    /// Collisions in all.
    pub collisions: usize,
    /// Collisions by the class of what was hit.
    #[serde(default)]
    pub collisions_by_class: BTreeMap<String, CollisionSum>,
    /// How the robot met people and cars; null where nobody moves.
    #[serde(default)]
    pub encounters: Option<EncounterSum>,
    /// How far the agent was from where it believed to be; null if it did not say.
    #[serde(default)]
    pub localization: Option<LocalizationSum>,
    /// Metres driven in all.
    pub path_m: f64,
    /// How smoothly.
    #[serde(default)]
    pub smoothness: SmoothnessSum,
    /// Simulated seconds in all.
    pub sim_seconds: f64,
    /// Seconds that the run took. Depends on the machine.
    pub wall_seconds: f64,
    /// Simulated seconds in each CPU second of the workers. Depends on the machine.
    pub real_time_factor: f64,
    /// 95 % intervals, lower and upper end, of the metrics of these names.
    #[serde(default)]
    pub intervals: BTreeMap<String, [f64; 2]>,
}

/// The result of one delivery.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeliveryResult {
    /// Which episode of the suite, from 0.
    pub episode: usize,
    /// Which delivery of the episode, from 0, in driving order.
    pub task: usize,
    /// The instruction of the episode.
    pub instruction: String,
    /// Building of the door.
    pub building: String,
    /// Unit of the door.
    pub unit: Option<String>,
    /// Declared within 10 m of the plate.
    pub success_10m: bool,
    /// Declared within 2 m of the right door's approach point, no other door's being nearer.
    pub success_2m: bool,
    /// Declared with no other door's approach point nearer.
    pub correct_unit: bool,
    /// From where the robot declared (or stood at the end) to the plate in a straight line, metres.
    pub distance_to_door_m: Option<f64>,
    /// Metres driven for this delivery.
    pub path_m: f64,
    /// Shortest drivable path from where the task began to the approach point, metres; null where no way leads.
    pub shortest_path_m: Option<f64>,
    /// Straight line that the paper compares with, metres.
    pub straight_line_m: f64,
    /// Simulated seconds spent on this delivery.
    pub sim_seconds: f64,
    /// How smoothly the robot drove.
    #[serde(default)]
    pub smoothness: SmoothnessSum,
    /// Collisions during this delivery.
    pub collisions: usize,
    /// Those by the class of what was hit.
    #[serde(default)]
    pub collisions_by_class: BTreeMap<String, CollisionSum>,
    /// How the robot met people and cars; null where nobody moves.
    #[serde(default)]
    pub encounters: Option<EncounterSum>,
    /// Where the robot declared, in the map; null if it never did.
    #[serde(default)]
    pub declared_at: Option<MapPoint>,
    /// Distance between where the agent believed to be at the end and where it was, metres.
    #[serde(default)]
    pub pose_error_m: Option<f64>,
    /// Plates that were read during this delivery.
    #[serde(default)]
    pub plates_read: usize,
    /// Why the delivery failed; null if it did not.
    pub failure: Option<FailureCause>,
    /// The same in words.
    #[serde(default)]
    pub failure_detail: Option<String>,
}

impl DeliveryResult {
    /// The door to deliver to.
    pub fn address(&self) -> Address {
        Address {
            building: self.building.clone(),
            unit: self.unit.clone(),
        }
    }
}

/// A results file that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file holds something else.
    #[error("{}:{}:{}: this is no results.json of OpenBench: {source}", path.display(), source.line(), source.column())]
    Json {
        /// Which file.
        path: PathBuf,
        /// What does not fit.
        source: serde_json::Error,
    },
}

impl Results {
    /// The same results without what depends on the machine and its load: two runs of the same episodes give the same.
    pub fn machine_independent(&self) -> Self {
        let mut results = self.clone();
        (
            results.metrics.wall_seconds,
            results.metrics.real_time_factor,
        ) = (0.0, 0.0);
        if let Some(used) = &mut results.models {
            used.latency_ms = 0;
        }
        results
    }

    /// Writes the file beside its place and moves it there, so that `path` never holds half a file.
    pub fn write(&self, path: &Path) -> Result<(), ResultsError> {
        let file_error = |source| ResultsError::File {
            path: path.to_owned(),
            source,
        };
        let mut json = serde_json::to_vec_pretty(self).map_err(|source| ResultsError::Json {
            path: path.to_owned(),
            source,
        })?;
        json.push(b'\n');
        let partial = path.with_extension("json.partial");
        fs::write(&partial, json)
            .and_then(|()| fs::rename(&partial, path))
            .map_err(file_error)
    }

    /// Reads a file that [`write`](Self::write) wrote.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let json = fs::read(path).map_err(|source| ResultsError::File {
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

    /// A delivery that succeeded: 8 m driven where 6 m would do.
    pub(crate) fn delivery(episode: usize, task: usize) -> DeliveryResult {
        DeliveryResult {
            episode,
            task,
            instruction: "Please deliver this box into unit1, building3.".into(),
            building: "building3".into(),
            unit: Some("unit1".into()),
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
            collisions_by_class: BTreeMap::new(),
            encounters: None,
            declared_at: Some(MapPoint::new(1.0, 2.0)),
            pose_error_m: Some(0.125),
            plates_read: 2,
            failure: None,
            failure_detail: None,
        }
    }

    pub(crate) fn results(deliveries: Vec<DeliveryResult>) -> Results {
        Results {
            suite: "small".into(),
            agent: "open".into(),
            seed: 7,
            version: "0.1.0".into(),
            settings: BTreeMap::new(),
            traffic: TrafficPlan::default(),
            metrics: Metrics::default(),
            deliveries,
            models: None,
            doors: None,
            attribution: vec![],
        }
    }

    #[test]
    fn results_are_read_as_they_were_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("results.json");
        let mut written = results(vec![delivery(0, 0)]);
        written.metrics.sr_2m = Some(1.0 / 3.0);
        written.metrics.intervals.insert("sr_2m".into(), [0.1, 0.9]);
        written.write(&path).unwrap();
        assert_eq!(Results::read(&path).unwrap(), written);
        assert_eq!(
            fs::read_dir(dir.path()).unwrap().count(),
            1,
            "no partial file stays behind"
        );
    }

    #[test]
    fn names_are_those_that_programs_read() {
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
    fn other_json_is_refused_with_its_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("results.json");
        fs::write(&path, "{\n  \"suite\": 3\n}").unwrap();
        let error = Results::read(&path).unwrap_err().to_string();
        assert!(error.contains("results.json:2:"), "{error}");
        assert!(Results::read(&dir.path().join("none.json")).is_err());
    }
}
