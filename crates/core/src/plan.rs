//! What a language planner, a router and an agent exchange.

use serde::{Deserialize, Serialize};

use crate::address::Address;
use crate::frames::MapPoint;

/// Deliveries in driving order, as a planner understood an instruction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Which planner made it.
    pub planner: String,
    /// In driving order.
    pub deliveries: Vec<PlannedDelivery>,
    /// What another planner had to make, and why; nothing in most plans.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fallbacks: Vec<Fallback>,
}

/// A part of a plan that comes from another planner than the one that was asked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fallback {
    /// Which part.
    pub part: PlanPart,
    /// Where it comes from.
    pub from: String,
    /// What was wrong with the planner that was asked, in words.
    pub because: String,
}

/// The parts of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanPart {
    /// Which doors.
    Addresses,
    /// In which order.
    Order,
}

/// One door to deliver to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannedDelivery {
    /// Position of this delivery in the instruction, from 0.
    pub instruction_index: usize,
    /// What is delivered, in the instruction's words; several items for one door are joined by `, `.
    pub item: String,
    /// Name of the building.
    pub building: String,
    /// Name of the unit, if the instruction names one.
    pub unit: Option<String>,
    /// What the instruction says of the address above the building and below the unit, the widest level first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<AddressLevel>,
    /// How to get there.
    pub steps: Vec<Step>,
    /// How surely the building is the one that is meant, 0 to 1: the share of its name's letters that stand in the instruction as the map has them, parted among all that
    /// fit; 0 where the map has none.
    #[serde(default = "sure")]
    pub confidence: f64,
    /// Why this cannot be delivered as understood (the map lacks the building, several fit), in words.
    pub problem: Option<String>,
    /// Until when, if the instruction says so.
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

/// What an instruction says of one level.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct AddressLevel {
    /// Which level.
    pub level: Level,
    /// The map's own name, else `floor<N>` or `flat<N>`.
    pub name: String,
}

/// Until when something is to be delivered. Lengths of time order before times of day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Deadline {
    /// From the beginning of the drive.
    Within {
        /// So many seconds.
        seconds: u32,
    },
    /// A time of day.
    Clock {
        /// Since midnight.
        minutes: u32,
    },
}

fn sure() -> f64 {
    1.0
}

impl PlannedDelivery {
    /// Building and unit.
    pub fn address(&self) -> Address {
        Address {
            building: self.building.clone(),
            unit: self.unit.clone(),
        }
    }
}

/// One leg of a delivery, as the paper's *location query* yields it: the level that the map knows is navigated to,
/// the levels below are explored for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// Whether the map knows the target.
    pub mode: StepMode,
    /// Name of the street, building, unit, or whatever level it is.
    pub target: String,
}

/// Whether a step's target is on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepMode {
    /// The map knows where it is: drive there.
    Navigate,
    /// The map does not know: look for it.
    Explore,
}

/// Says how long the robot drives between places: a router for the language planners, which order deliveries by it.
pub trait TravelTimes {
    /// Seconds from each of `places` to each, row by row (`from * n + to`); infinite where there is no way.
    fn matrix(&self, places: &[MapPoint]) -> Vec<f64>;
}
