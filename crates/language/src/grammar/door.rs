//! A door as an instruction names it.

use super::mentions::mention::Target;

/// A building, a unit of it, and where both are said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Door {
    /// `None`: the instruction names a unit only.
    pub building: Option<Target>,
    pub unit: Option<Target>,
    /// Whether the unit is said as a flat or a room.
    pub is_room: bool,
    /// The first lexeme.
    pub first: usize,
    /// The lexeme behind the last one.
    pub last: usize,
}
