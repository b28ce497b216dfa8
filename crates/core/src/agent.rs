//! The contract between the benchmark and an agent.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::address::Address;
use crate::events::Events;
use crate::frames::{Georeference, MapPoint, Pose2};
use crate::robot::RobotDescription;
use crate::sensors::{Camera, GnssFix, Image, ImuSample, LidarScan, WheelSample};
use crate::time::SimTime;

/// A delivery robot's mind. The benchmark calls [`begin`](Agent::begin) once, then [`act`](Agent::act) every 50 ms of
/// simulated time until each delivery is declared or given up or the time is over, then [`finish`](Agent::finish).
///
/// An agent gets a [`Briefing`] and [`Observation`]s, nothing else. It keeps no wall clock and draws no unseeded random
/// number: the same briefing and observations must give the same actions.
pub trait Agent {
    /// Reads the map and the goal. An agent that cannot begin gives up on the whole episode.
    fn begin(&mut self, briefing: &Briefing, events: &mut dyn Events) -> Result<(), GiveUp>;

    /// Decides what to do until the next observation.
    fn act(&mut self, observation: &Observation<'_>, events: &mut dyn Events) -> Action;

    /// The agent's copy of the map with what it found, as OSM XML, if it edits one.
    fn finish(&mut self, events: &mut dyn Events) -> Option<Vec<u8>> {
        let _ = events;
        None
    }
}

/// All that an agent is told.
#[derive(Debug, Clone, PartialEq)]
pub struct Briefing {
    /// The public map, OSM XML.
    pub map_osm: Vec<u8>,
    /// How the `map` frame lies on the Earth.
    pub georeference: Georeference,
    /// What to do.
    pub goal: Goal,
    /// Where the robot stands, in `map`.
    pub start: Pose2,
    /// The robot.
    pub robot: RobotDescription,
    /// Simulated time after which the episode has certainly ended. The exact limit depends on how far the door is, which an agent
    /// is not to know: it lies up to ten minutes earlier.
    pub time_limit: Duration,
}

/// What an agent is to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// Deliver as a sentence says.
    Instruction(String),
    /// Go to where this image was taken.
    Image(Image),
    /// Go to a point.
    Point(MapPoint),
}

/// What the robot's sensors delivered since the last observation.
pub struct Observation<'a> {
    /// Now.
    pub time: SimTime,
    /// IMU samples since the last observation, oldest first.
    pub imu: &'a [ImuSample],
    /// Wheel samples since the last observation, oldest first.
    pub wheels: &'a [WheelSample],
    /// The scan, if one was completed since the last observation.
    pub scan: Option<&'a LidarScan>,
    /// The fix, if the robot has a satellite receiver and it got one since the last observation.
    pub gnss: Option<&'a GnssFix>,
    /// The camera, to be asked when an image is wanted.
    pub camera: &'a dyn Camera,
}

impl fmt::Debug for Observation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Observation")
            .field("time", &self.time)
            .field("imu", &self.imu.len())
            .field("wheels", &self.wheels.len())
            .field("scan", &self.scan.map(|s| s.points.len()))
            .field("gnss", &self.gnss)
            .finish_non_exhaustive()
    }
}

/// A wanted velocity in `base_link`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity {
    /// Forward, m/s.
    pub linear: f64,
    /// Counter-clockwise, rad/s.
    pub angular: f64,
}

impl Velocity {
    /// Standing still.
    pub const ZERO: Self = Self {
        linear: 0.0,
        angular: 0.0,
    };

    /// A velocity from m/s and rad/s.
    pub const fn new(linear: f64, angular: f64) -> Self {
        Self { linear, angular }
    }
}

/// What an agent decides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Drive with this velocity until the next observation.
    Drive(Velocity),
    /// The parcel for this address is delivered, here and now.
    Delivered(Address),
    /// A delivery, or all that is left, cannot be done.
    GiveUp(GiveUp),
}

/// Why an agent stops trying.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{cause}: {detail}")]
pub struct GiveUp {
    /// The delivery that is given up, or `None` for all that are left.
    pub address: Option<Address>,
    /// The kind of cause.
    pub cause: FailureCause,
    /// The cause in words.
    pub detail: String,
}

/// Why a delivery failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureCause {
    /// The agent could not read its briefing.
    Briefing,
    /// The instruction could not be understood.
    NotUnderstood,
    /// The map lacks the building that was named, or several fit.
    UnknownAddress,
    /// The language planner's model could not be reached or answered nonsense.
    PlannerUnavailable,
    /// The plate reader's model could not be reached or answered nonsense.
    ReaderUnavailable,
    /// No way leads to the building.
    NoRoute,
    /// The robot could not move on.
    Stuck,
    /// All places were looked at and the door was not found.
    DoorNotFound,
    /// The time was over.
    Timeout,
    /// The agent never declared this delivery.
    NotDeclared,
    /// The agent declared the delivery at the wrong place.
    WrongPlace,
    /// The agent itself failed.
    AgentError,
    /// The robot left the ground of the world or lies on its side.
    LeftWorld,
    /// The agent no longer knew where it was.
    Lost,
}

impl fmt::Display for FailureCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Briefing => "unreadable briefing",
            Self::NotUnderstood => "instruction not understood",
            Self::UnknownAddress => "unknown address",
            Self::PlannerUnavailable => "planner unavailable",
            Self::ReaderUnavailable => "plate reader unavailable",
            Self::NoRoute => "no route",
            Self::Stuck => "stuck",
            Self::DoorNotFound => "door not found",
            Self::Timeout => "time over",
            Self::NotDeclared => "not declared",
            Self::WrongPlace => "wrong place",
            Self::AgentError => "agent failed",
            Self::LeftWorld => "left the world",
            Self::Lost => "lost",
        })
    }
}
