//! The delivery at hand, and the stage that it is in.

use openbench_core::{Address, MapPoint, SimTime, Stage as ReportedStage};

use crate::open::doorstep;
use crate::open::exploration::Waypoint;
use crate::open::sighting::Sighting;

/// What the robot is doing about the current delivery.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stage {
    /// About to drive.
    SetOut,
    /// Driving along the road towards the building.
    Travel,
    /// Driving to a waypoint.
    ToWaypoint,
    /// Standing at a waypoint since this instant, to look.
    Look(SimTime),
    /// Driving to the door.
    Approach(Aim),
}

impl Stage {
    /// The same in the words of events.
    pub(super) fn reported(&self) -> ReportedStage {
        match self {
            Self::SetOut | Self::Travel => ReportedStage::Travelling,
            Self::ToWaypoint | Self::Look(_) => ReportedStage::Searching,
            Self::Approach(_) => ReportedStage::Approaching,
        }
    }
}

/// A door that the robot drives to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Aim {
    pub(super) door: Sighting,
    /// Where the door was thought to be when the robot set out for its doorstep.
    pub(super) then: MapPoint,
}

impl Aim {
    pub(super) fn new(door: Sighting) -> Self {
        Self {
            then: door.position,
            door,
        }
    }
}

/// The current delivery.
pub(super) struct Task {
    pub(super) address: Address,
    pub(super) building: usize,
    pub(super) stage: Stage,
    /// Waypoints that were not visited yet.
    pub(super) waypoints: Vec<Waypoint>,
    /// The waypoint that the robot is at or drives to.
    pub(super) place: Option<Waypoint>,
    /// How often all waypoints were visited.
    pub(super) round: usize,
    /// Whether any waypoint was reached.
    pub(super) looked: bool,
    /// The door as map or memory have it, trusted if its plate cannot be read there.
    pub(super) expected: Option<Sighting>,
    /// Least distance of the next doorstep from the plate, metres.
    pub(super) doorstep: f64,
    /// Whether the robot resorts to a door that seemed to be of the building beside it.
    pub(super) is_last_resort: bool,
}

impl Task {
    /// A delivery at its beginning.
    pub(super) fn new(address: Address, building: usize, expected: Option<Sighting>) -> Self {
        Self {
            address,
            building,
            stage: Stage::SetOut,
            waypoints: Vec::new(),
            place: None,
            round: 0,
            looked: false,
            expected,
            doorstep: doorstep::NEAREST_M,
            is_last_resort: false,
        }
    }

    /// The doors that the delivery is about.
    pub(super) fn doors_mut(&mut self) -> impl Iterator<Item = &mut Sighting> {
        let aim = match &mut self.stage {
            Stage::Approach(aim) => Some(&mut aim.door),
            _ => None,
        };
        aim.into_iter().chain(&mut self.expected)
    }
}
