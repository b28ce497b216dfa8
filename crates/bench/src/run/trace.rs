//! What happened in an episode, as the judge sees it.

use std::collections::VecDeque;
use std::sync::Arc;

use openbench_core::{Address, FailureCause, Image, MapPoint, ModelUse, Plan, SimTime, Velocity};
use openbench_sim::Collision;
use openbench_sim::traffic::Totals;

use crate::score::metrics::{PoseError, SmoothnessSum};

/// How one delivery ended.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskOutcome {
    /// Index into the episode's targets.
    pub target: usize,
    /// Where the robot was when the delivery began: at the start, or where the last one was declared.
    pub began_at: MapPoint,
    /// When it began.
    pub began: SimTime,
    /// When it ended.
    pub ended: SimTime,
    /// Where the robot was at the end.
    pub ended_at: MapPoint,
    /// Whether the agent declared it delivered there.
    pub declared: bool,
    /// Metres driven meanwhile.
    pub path_m: f64,
    /// How smoothly.
    pub smoothness: SmoothnessSum,
    /// Collisions meanwhile.
    pub collisions: Vec<Collision>,
    /// How near the robot came to people and cars meanwhile; `None` where nobody moves.
    pub encounters: Option<Totals>,
    /// Distance between where the agent believed to be and where it was, metres.
    pub pose_error_m: Option<f64>,
    /// Plates read meanwhile.
    pub plates_read: usize,
    /// Why it failed, if it was not declared.
    pub failure: Option<(FailureCause, String)>,
}

/// A plate that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateRead {
    /// When.
    pub time: SimTime,
    /// The text.
    pub text: String,
    /// How sure the reader was, 0 to 1.
    pub confidence: f32,
    /// The text's corners, pixels.
    pub corners: [[f32; 2]; 4],
}

/// An image in which plates were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// When it was taken.
    pub time: SimTime,
    /// The image.
    pub image: Arc<Image>,
}

/// What happened in an episode.
#[derive(Debug, Clone, Default)]
pub struct EpisodeTrace {
    /// In the order in which they ended.
    pub tasks: Vec<TaskOutcome>,
    /// True poses, five a second.
    pub driven: Vec<MapPoint>,
    /// Where the agent believed to be.
    pub estimated: Vec<MapPoint>,
    /// How far that was from where it was.
    pub pose_errors: Vec<PoseError>,
    /// Routes over roads.
    pub routes: Vec<Vec<MapPoint>>,
    /// Doors written by the agent.
    pub doors: Vec<(Address, MapPoint)>,
    /// Plates read.
    pub plates: Vec<PlateRead>,
    /// The last images in which plates were read, oldest first.
    pub frames: VecDeque<Frame>,
    /// The agent's plan.
    pub plan: Option<Plan>,
    /// What the agent asked of models.
    pub models: ModelUse,
    /// All collisions.
    pub collisions: Vec<Collision>,
    /// Simulated seconds.
    pub sim_seconds: f64,
    /// The velocities that were driven, one a step.
    pub velocities: Vec<Velocity>,
    /// Hash over all states.
    pub chain: [u8; 32],
    /// The agent's copy of the map.
    pub map: Option<Vec<u8>>,
}
