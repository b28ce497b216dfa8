//! The record of an episode: what [`run`](mod@crate::run) keeps and [`score`](crate::score) reads.
//!
//! | module | content |
//! |---|---|
//! | `computing` | [`Computing`]: what computing cost |
//! | `deed` | [`Deed`]: what an agent does besides driving |
//! | `pose_error` | [`PoseError`]: the error of an estimated pose |
//! | `smoothness` | [`Smoothness`]: turning, speed variation and stops along a drive |

mod computing;
mod deed;
mod pose_error;
mod smoothness;

use std::collections::BTreeMap;
use std::time::Duration;

use openbench_core::{
    Address, FailureCause, GiveUp, MapComparison, MapPoint, ModelUse, Plan, Pose2, SimTime, Stage,
    Start, Velocity,
};
use openbench_scene::SemanticClass;
use openbench_sim::Collision;
use openbench_sim::traffic::EncounterTotals;

pub use computing::Computing;
pub use deed::{Comparison, Deed, Number, Reading, TimedDeed};
pub use pose_error::PoseError;
pub use smoothness::{Smoothness, SmoothnessSum};

/// The outcome of one delivery.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TaskOutcome {
    /// Index into the episode's targets.
    pub target: usize,
    /// True position at the beginning: the start, or the end of the previous delivery.
    pub began_at: MapPoint,
    /// Time of the beginning.
    pub began: SimTime,
    /// Time of the end.
    pub ended: SimTime,
    /// True position at the end.
    pub ended_at: MapPoint,
    /// Whether the agent declared the delivery there.
    pub declared: bool,
    /// Driven distance, metres.
    pub path_m: f64,
    /// Smoothness of the drive.
    pub smoothness: SmoothnessSum,
    /// Collisions during the delivery.
    pub collisions: Vec<Collision>,
    /// Time in contact with each class of objects during the delivery; classes that were not
    /// touched may be absent.
    pub contacts: BTreeMap<SemanticClass, Duration>,
    /// Encounters with people and cars; `None` in a world without traffic.
    pub encounters: Option<EncounterTotals>,
    /// Position error of the last pose that the agent reported, at the time of the report, metres;
    /// `None` if it reported no pose.
    pub pose_error_m: Option<f64>,
    /// Plates read during the delivery.
    pub plates_read: usize,
    /// The agent's use of models during the delivery.
    pub models: ModelUse,
    /// The failure, if it was not declared.
    pub failure: Option<Failure>,
}

impl TaskOutcome {
    /// A delivery that failed before it began.
    pub fn failed(target: usize, failure: Failure) -> Self {
        Self {
            target,
            began_at: MapPoint::default(),
            began: SimTime::ZERO,
            ended: SimTime::ZERO,
            ended_at: MapPoint::default(),
            declared: false,
            path_m: 0.0,
            smoothness: SmoothnessSum::default(),
            collisions: Vec::new(),
            contacts: BTreeMap::new(),
            encounters: None,
            pose_error_m: None,
            plates_read: 0,
            models: ModelUse::default(),
            failure: Some(failure),
        }
    }
}

/// Why a delivery failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The kind of cause.
    pub cause: FailureCause,
    /// Description, for people.
    pub detail: String,
}

impl From<&GiveUp> for Failure {
    fn from(give_up: &GiveUp) -> Self {
        Self {
            cause: give_up.cause,
            detail: give_up.detail.clone(),
        }
    }
}

/// A door on a map.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedDoor {
    /// Its address.
    pub address: Address,
    /// Its position on the outline of the building, as in OSM, in the `map` frame.
    pub position: MapPoint,
}

/// What an agent found when it looked for itself on its map.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedComparison {
    /// Time of the event.
    pub time: SimTime,
    /// True pose then, in the frame of the public map.
    pub truth: Pose2,
    /// What it found.
    pub found: MapComparison,
}

/// What an agent did from a time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedStage {
    /// Time of the event.
    pub time: SimTime,
    /// What it did.
    pub stage: Stage,
}

/// A plate that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateRead {
    /// Time of the event.
    pub time: SimTime,
    /// The text.
    pub text: String,
    /// Confidence of the reader, 0 to 1.
    pub confidence: f32,
    /// Corners of the text, pixels, clockwise from the top left.
    pub corners: [[f32; 2]; 4],
}

/// An image in which plates were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Time of the event with the image.
    pub time: SimTime,
    /// Columns, pixels.
    pub width: u32,
    /// Rows, pixels.
    pub height: u32,
    /// The image as JPEG; empty if JPEG cannot hold it.
    pub jpeg: Vec<u8>,
}

/// The record of an episode.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct EpisodeTrace {
    /// What the agent was told about the start.
    pub start: Option<Start>,
    /// Outcomes of the deliveries, in the order in which they ended.
    pub tasks: Vec<TaskOutcome>,
    /// True positions, five per second.
    pub driven: Vec<MapPoint>,
    /// Positions estimated by the agent.
    pub estimated: Vec<MapPoint>,
    /// Errors of the estimated poses.
    pub pose_errors: Vec<PoseError>,
    /// What the agent found when it looked for itself on its map.
    pub comparisons: Vec<TimedComparison>,
    /// What the agent did about its deliveries, one stage after another.
    pub stages: Vec<TimedStage>,
    /// Routes planned by the agent.
    pub routes: Vec<Vec<MapPoint>>,
    /// Doors that the agent wrote into its map.
    pub doors: Vec<PlacedDoor>,
    /// Plates read by the agent.
    pub plates: Vec<PlateRead>,
    /// The last images in which plates were read, oldest first.
    pub frames: Vec<Frame>,
    /// The agent's plan.
    pub plan: Option<Plan>,
    /// The agent's use of language and vision models.
    pub models: ModelUse,
    /// What computing cost; `None` if it was free.
    pub computing: Option<Computing>,
    /// All collisions.
    pub collisions: Vec<Collision>,
    /// Simulated time, seconds.
    pub sim_seconds: f64,
    /// The commanded velocities, one per step of 50 ms.
    pub velocities: Vec<Velocity>,
    /// What the agent did besides driving, in the order of time.
    pub deeds: Vec<TimedDeed>,
    /// Hash chain over all states.
    pub chain: [u8; 32],
    /// The agent's copy of the map, OSM XML.
    pub map: Option<Vec<u8>>,
}

impl EpisodeTrace {
    /// Whether the agent reported one of these causes for a delivery.
    pub fn failed_by(&self, causes: &[FailureCause]) -> bool {
        let mut failures = self.tasks.iter().filter_map(|task| task.failure.as_ref());
        failures.any(|failure| causes.contains(&failure.cause))
    }
}
