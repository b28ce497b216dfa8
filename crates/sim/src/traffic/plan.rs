//! How many people and cars are wanted.

use serde::{Deserialize, Serialize};

/// How many people and cars are wanted in a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrafficPlan {
    /// People on foot.
    pub pedestrians: usize,
    /// Cars that drive.
    pub cars: usize,
}

impl TrafficPlan {
    /// Whether there is neither a person nor a car.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
