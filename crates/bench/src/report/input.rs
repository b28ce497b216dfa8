//! The input of a report.

use openbench_core::{Address, MapPoint, PlannedDelivery, Pose2, SimTime};

use crate::score::results::Results;
use crate::trace::{PoseError, TimedComparison};

/// Everything that a report shows.
#[derive(Debug, Clone)]
pub struct ReportInput<'a> {
    /// The results.
    pub results: &'a Results,
    /// The command line that reproduces the run.
    pub command: String,
    /// The maps of the worlds.
    pub worlds: Vec<WorldMap>,
    /// The episodes, in display order.
    pub episodes: Vec<EpisodeReport>,
}

/// The map of a world, in its `map` frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorldMap {
    /// Name of the world.
    pub name: String,
    /// Buildings.
    pub buildings: Vec<MapArea>,
    /// Centre lines of roads and paths.
    pub roads: Vec<Vec<MapPoint>>,
    /// Walls, fences, hedges.
    pub barriers: Vec<Vec<MapPoint>>,
    /// Other areas, such as parks and water, drawn below everything else.
    pub areas: Vec<MapArea>,
}

/// A polygon with holes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MapArea {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Outer ring; the last point may repeat the first.
    pub outline: Vec<MapPoint>,
    /// Inner rings.
    pub holes: Vec<Vec<MapPoint>>,
}

/// One episode of the report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeReport {
    /// Episode number in the results.
    pub episode: usize,
    /// Index into [`ReportInput::worlds`].
    pub world: usize,
    /// Start pose.
    pub start: Pose2,
    /// True positions.
    pub driven: Vec<MapPoint>,
    /// Positions estimated by the agent; empty if it reported none.
    pub estimated: Vec<MapPoint>,
    /// Errors of the estimated poses.
    pub pose_errors: Vec<PoseError>,
    /// What the agent found when it looked for itself on its map.
    pub comparisons: Vec<TimedComparison>,
    /// Routes planned by the agent.
    pub routes: Vec<Vec<MapPoint>>,
    /// Doors of the world.
    pub true_doors: Vec<DoorMark>,
    /// Doors that the agent added to its map.
    pub found_doors: Vec<DoorMark>,
    /// Declared deliveries.
    pub declared: Vec<Declaration>,
    /// Positions of collisions.
    pub collisions: Vec<MapPoint>,
    /// Frames in which a plate was read.
    pub plates: Vec<PlateFrame>,
    /// The deliveries that the agent planned.
    pub plan: Vec<PlannedDelivery>,
}

/// A door on the map.
#[derive(Debug, Clone, PartialEq)]
pub struct DoorMark {
    /// Its address.
    pub address: Address,
    /// True position, or the position in the agent's map.
    pub position: MapPoint,
    /// Whether the episode has a delivery to this door.
    pub wanted: bool,
}

/// A delivery that was declared.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Index of the delivery in the episode, from 0.
    pub task: usize,
    /// Address of the target door.
    pub address: Address,
    /// Position of the robot.
    pub position: MapPoint,
    /// Whether it succeeded by the strict criterion.
    pub success: bool,
}

/// A camera frame in which a plate was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateFrame {
    /// The frame as a JPEG file.
    pub jpeg: Vec<u8>,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Time of the frame.
    pub time: SimTime,
    /// The text as read.
    pub text: String,
    /// Confidence of the reader, 0 to 1.
    pub confidence: f32,
    /// Corners of the text in pixels, clockwise from the top left.
    pub corners: [[f32; 2]; 4],
}
