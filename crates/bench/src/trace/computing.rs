//! What computing cost in an episode.

use std::collections::BTreeMap;

use openbench_core::Work;
use serde::{Deserialize, Serialize};

/// What an agent computed in an episode, and how long that took in simulated time.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Computing {
    /// How often each kind of work was done.
    pub work: BTreeMap<Work, u32>,
    /// Requests to language and vision models.
    pub model_calls: u32,
    /// Time for all of it, nanoseconds.
    pub busy_ns: u64,
    /// The part of it that was measured by the clock, nanoseconds.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub by_clock_ns: u64,
    /// The longest time between an observation and the decision on it, nanoseconds.
    pub latest_ns: u64,
    /// Time in which the robot stood because no decision came, nanoseconds.
    pub held_up_ns: u64,
    /// Observations that were lost because the agent was too far behind.
    pub lost_observations: u32,
}

fn is_zero(nanoseconds: &u64) -> bool {
    *nanoseconds == 0
}
