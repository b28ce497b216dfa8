//! How many people and cars there shall be.

use serde::{Deserialize, Serialize};

/// How many there shall be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrafficPlan {
    /// People on foot.
    pub pedestrians: usize,
    /// Cars that drive.
    pub cars: usize,
}

impl TrafficPlan {
    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
