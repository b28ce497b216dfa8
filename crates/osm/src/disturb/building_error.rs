//! What is wrong with one building.

use openbench_core::MapPoint;
use serde::{Deserialize, Serialize};

/// What is wrong with a building of the map.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BuildingError {
    /// Its shift, metres east and north, before the whole map is shifted.
    pub shift: MapPoint,
    /// Whether the map has it.
    pub state: MapState,
    /// Whether only the smallest rectangle around it is drawn.
    pub is_simplified: bool,
}

/// Whether a map has a building.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapState {
    /// Under its right name.
    #[default]
    Right,
    /// With a wrong number.
    WrongNumber,
    /// Without a name.
    Unnamed,
    /// Not at all.
    Missing,
}

impl MapState {
    /// Whether the map has the building under its right name.
    pub fn is_right(&self) -> bool {
        *self == Self::Right
    }
}
