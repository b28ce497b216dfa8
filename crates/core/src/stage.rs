//! What an agent is doing about its deliveries.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What an agent is doing about a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// It finds out where it is.
    Locating,
    /// It is on the way to the building.
    Travelling,
    /// It looks for the door.
    Searching,
    /// It is on the way to the door.
    Approaching,
}

impl Stage {
    /// All of them, in the order of a delivery.
    pub const ALL: [Self; 4] = [
        Self::Locating,
        Self::Travelling,
        Self::Searching,
        Self::Approaching,
    ];
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Locating => "finding out where it is",
            Self::Travelling => "on the way to the building",
            Self::Searching => "looking for the door",
            Self::Approaching => "on the way to the door",
        })
    }
}
