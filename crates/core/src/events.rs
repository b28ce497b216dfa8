//! Events that an agent reports for the log. Agents print nothing and write no files.

use std::sync::Arc;
use std::time::Duration;

use crate::address::Address;
use crate::comparison::MapComparison;
use crate::frames::{MapPoint, Pose2};
use crate::health::Health;
use crate::model_use::ModelUse;
use crate::plan::Plan;
use crate::sensors::Image;
use crate::stage::Stage;
use crate::work::Work;

/// An agent's estimate of its pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoseEstimate {
    /// Pose of `base_link` in `map`.
    pub pose: Pose2,
    /// How far the estimate can be trusted.
    pub health: Health,
}

/// The ground around an agent, as it takes it to be.
#[derive(Debug, Clone, PartialEq)]
pub struct CostGrid {
    /// South-west corner in `map`.
    pub origin: MapPoint,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Columns.
    pub width: usize,
    /// The cells, row by row from the south-west: -1 unknown, 0 free to 100 occupied. As in ROS, 99
    /// is free ground on which the robot does not fit.
    pub cells: Vec<i8>,
}

/// An event for the log.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The deliveries that the agent understood from its instruction.
    Plan(Plan),
    /// Work on a delivery begins.
    Task(Address),
    /// What the agent does from now on.
    Stage(Stage),
    /// A route over roads, in `map`.
    Route(Vec<MapPoint>),
    /// The path that is being followed, in `map`.
    Path(Vec<MapPoint>),
    /// The ground around the agent.
    Costmap(CostGrid),
    /// The agent's estimate of its pose.
    PoseEstimate(PoseEstimate),
    /// Where the agent may be, by what it sees of its map.
    MapComparison(MapComparison),
    /// Candidate poses from which to look for a door.
    Waypoints(Vec<Pose2>),
    /// A plate was read in an image.
    PlateRead {
        /// The text as read.
        text: String,
        /// Confidence of the reader, 0 to 1.
        confidence: f32,
        /// Corners of the text in pixels, clockwise from its top left.
        corners: [[f32; 2]; 4],
        /// Estimated position of the plate, if the agent could tell.
        position: Option<MapPoint>,
        /// The image it was read in.
        image: Arc<Image>,
    },
    /// A door was added to the agent's map.
    DoorWritten {
        /// The door's address.
        address: Address,
        /// Position of the door on the building's outline.
        position: MapPoint,
    },
    /// Use of models so far, whenever it has grown.
    Models(ModelUse),
    /// Work that was done for the decision on this observation.
    Work(Work),
    /// Wall time that the decision on this observation took, of an agent whose computing is charged
    /// by the clock.
    WallTime(Duration),
    /// Anything else, as text.
    Note(String),
}

/// Receives the events of an agent.
pub trait Events {
    /// Records `event`.
    fn record(&mut self, event: Event);
}

/// Keeps every event.
impl Events for Vec<Event> {
    fn record(&mut self, event: Event) {
        self.push(event);
    }
}

/// Drops every event.
#[derive(Debug, Clone, Copy, Default)]
pub struct Discard;

impl Events for Discard {
    fn record(&mut self, _event: Event) {}
}
