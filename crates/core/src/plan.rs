//! What language planners, routers and agents exchange.

use serde::{Deserialize, Serialize};

use crate::address::Address;
use crate::frames::MapPoint;

/// Deliveries in driving order, as a planner has understood an instruction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Name of the planner that made it.
    pub planner: String,
    /// In driving order.
    pub deliveries: Vec<PlannedDelivery>,
    /// Parts that another planner had to make, and why; empty in most plans.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallbacks: Vec<Fallback>,
}

/// A part of a plan that was not made by the requested planner.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fallback {
    /// Which part.
    pub part: PlanPart,
    /// Name of the planner that made it.
    pub from: String,
    /// Why the requested planner's part was not used, as text.
    pub because: String,
}

/// The parts of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanPart {
    /// The doors.
    Addresses,
    /// The order of the deliveries.
    Order,
}

/// One door to deliver to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedDelivery {
    /// Position of this delivery in the instruction, counted from 0.
    pub instruction_index: usize,
    /// What is delivered, in the instruction's words. Several items for one door are separated by
    /// commas.
    pub item: String,
    /// Name of the building.
    pub building: String,
    /// Name of the unit, if the instruction names one.
    pub unit: Option<String>,
    /// Levels of the address above the building and below the unit that the instruction names, the
    /// widest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<AddressLevel>,
    /// How to get there.
    pub steps: Vec<Step>,
    /// Confidence in the building, 0 to 1: the share of its name's letters that the instruction has
    /// as in the map, divided among all buildings that match; 0 without a match.
    #[serde(default = "sure")]
    pub confidence: f64,
    /// Why this cannot be delivered as understood (the map lacks the building, or several match),
    /// as text.
    pub problem: Option<String>,
    /// The deadline, if the instruction has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline: Option<Deadline>,
}

/// A level of an address above the building or below the unit, the widest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// A town, a quarter, an estate.
    District,
    /// A street.
    Street,
    /// A floor inside the building.
    Floor,
    /// A flat or a room behind the unit's door.
    Flat,
}

/// The name of one level of an address.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct AddressLevel {
    /// Which level.
    pub level: Level,
    /// The map's own name, else `floor<N>` or `flat<N>`.
    pub name: String,
}

/// A deadline of a delivery. Durations order before times of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Deadline {
    /// A duration from the beginning of the drive.
    Within {
        /// Seconds.
        seconds: u32,
    },
    /// A time of day.
    Clock {
        /// Minutes since midnight.
        minutes: u32,
    },
}

fn sure() -> f64 {
    // Plans without the field were made before confidence was reported.
    1.0
}

impl PlannedDelivery {
    /// A delivery to an address, of which nothing else is known.
    pub fn to(instruction_index: usize, address: Address) -> Self {
        Self {
            instruction_index,
            item: String::new(),
            building: address.building,
            unit: address.unit,
            levels: Vec::new(),
            steps: Vec::new(),
            confidence: sure(),
            problem: None,
            deadline: None,
        }
    }

    /// The address of the door.
    pub fn address(&self) -> Address {
        Address {
            building: self.building.clone(),
            unit: self.unit.clone(),
        }
    }
}

/// One leg of a delivery, as the paper's *location query* yields it. The robot navigates to the
/// level that the map knows, and explores to find the levels below.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// Whether the map knows the target.
    pub mode: StepMode,
    /// Name of the target: a street, a building, a unit or another level.
    pub target: String,
}

/// Whether a step's target is on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepMode {
    /// The map has it: drive there.
    Navigate,
    /// The map lacks it: search for it.
    Explore,
}

/// Driving times between places. Language planners order deliveries by them.
/// `openbench_routing::RouterTimes` computes them with a router.
pub trait TravelTimes {
    /// Seconds from each of `places` to each, row by row (`from * n + to`); infinite without a
    /// route.
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64>;
}
