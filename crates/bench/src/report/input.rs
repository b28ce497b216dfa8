//! What a report is made from, beside the results.

use openbench_core::{Address, MapPoint, PlannedDelivery, Pose2, SimTime};

use crate::score::metrics::PoseError;
use crate::score::results::Results;

/// All that a report shows.
#[derive(Debug, Clone)]
pub struct ReportInput<'a> {
    /// The numbers.
    pub results: &'a Results,
    /// The command line that makes the same run.
    pub command: String,
    /// The maps of the worlds.
    pub worlds: Vec<WorldMap>,
    /// In the order they are to be shown.
    pub episodes: Vec<EpisodeReport>,
}

/// What is drawn of a world, in its `map` frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorldMap {
    /// Name of the world.
    pub name: String,
    /// Buildings.
    pub buildings: Vec<MapArea>,
    /// Middle lines of roads and paths.
    pub roads: Vec<Vec<MapPoint>>,
    /// Walls, fences, hedges.
    pub barriers: Vec<Vec<MapPoint>>,
    /// Other areas, such as parks and water, drawn behind everything.
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

/// What is drawn of an episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeReport {
    /// Its number in the results.
    pub episode: usize,
    /// Which of the report's worlds it was driven in.
    pub world: usize,
    /// Where the robot began.
    pub start: Pose2,
    /// Where the robot was.
    pub driven: Vec<MapPoint>,
    /// Where the agent believed to be; empty if it said nothing.
    pub estimated: Vec<MapPoint>,
    /// How far that was from where it was.
    pub pose_errors: Vec<PoseError>,
    /// Routes over roads that the agent planned.
    pub routes: Vec<Vec<MapPoint>>,
    /// Doors of the world.
    pub true_doors: Vec<DoorMark>,
    /// Doors that the agent wrote into its map.
    pub found_doors: Vec<DoorMark>,
    /// Where the robot declared deliveries.
    pub declared: Vec<Declaration>,
    /// Where it collided.
    pub collisions: Vec<MapPoint>,
    /// Frames in which a plate was read.
    pub plates: Vec<PlateFrame>,
    /// The deliveries as the agent understood them.
    pub plan: Vec<PlannedDelivery>,
}

/// A door on the map.
#[derive(Debug, Clone, PartialEq)]
pub struct DoorMark {
    /// Its address.
    pub address: Address,
    /// Where it is, or was written to be.
    pub position: MapPoint,
    /// Whether something was to be delivered there.
    pub wanted: bool,
}

/// A delivery that was declared.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Which delivery of the episode, from 0.
    pub task: usize,
    /// For which door.
    pub address: Address,
    /// Where the robot was.
    pub position: MapPoint,
    /// Whether it succeeded by the strict count.
    pub success: bool,
}

/// A camera frame in which a plate was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateFrame {
    /// The frame as a JPEG file.
    pub jpeg: Vec<u8>,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// When it was taken.
    pub time: SimTime,
    /// The text as read.
    pub text: String,
    /// Confidence of the reader, 0 to 1.
    pub confidence: f32,
    /// Corners of the text in pixels, clockwise from its top left.
    pub corners: [[f32; 2]; 4],
}
