//! What an agent wishes to have recorded. Agents print nothing and write no files.

use std::sync::Arc;

use crate::address::Address;
use crate::frames::{MapPoint, Pose2};
use crate::health::Health;
use crate::model_use::ModelUse;
use crate::plan::Plan;
use crate::sensors::Image;

/// Where an agent believes to be.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoseEstimate {
    /// Of `base_link` in `map`.
    pub pose: Pose2,
    /// How far it trusts that.
    pub health: Health,
}

/// Something worth recording.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The deliveries as understood.
    Plan(Plan),
    /// Work on a delivery begins.
    Task(Address),
    /// A route over roads, in the map.
    Route(Vec<MapPoint>),
    /// The path that is being followed, in the map.
    Path(Vec<MapPoint>),
    /// Where the agent believes to be.
    PoseEstimate(PoseEstimate),
    /// Candidate places to look for a door from.
    Waypoints(Vec<Pose2>),
    /// A plate was read in an image.
    PlateRead {
        /// The text as read.
        text: String,
        /// Confidence of the reader, 0 to 1.
        confidence: f32,
        /// Corners of the text in pixels, clockwise from its top left.
        corners: [[f32; 2]; 4],
        /// Where the agent believes the plate to be, if it could tell.
        position: Option<MapPoint>,
        /// The image it was read in.
        image: Arc<Image>,
    },
    /// A door was written into the agent's map.
    DoorWritten {
        /// The door's address.
        address: Address,
        /// The door's place on the building's outline.
        position: MapPoint,
    },
    /// What was asked of models so far, whenever it has grown.
    Models(ModelUse),
    /// Anything else, in words.
    Note(String),
}

/// Takes the events of an agent.
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
