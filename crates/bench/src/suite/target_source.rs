//! Where the doors that an instruction requests are known from.

use serde::{Deserialize, Serialize};

/// The source of the doors that the judge expects.
///
/// Only the last one depends on a planner. A run with it cannot show that a planner misunderstands
/// an instruction, so results name the source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetSource {
    /// Drawn from the doors of the world; the instruction was written afterwards.
    World,
    /// Written beside the instruction, in a suite or in a JSONL file of deliveries.
    #[default]
    Annotation,
    /// The world's doors at the true positions in a file.
    Positions,
    /// Read from the instruction by a planner, since the user asked for it.
    Planner,
}

impl TargetSource {
    /// The source in words, for people.
    pub fn description(self) -> &'static str {
        match self {
            Self::World => "drawn from the world's doors",
            Self::Annotation => "written beside the instructions",
            Self::Positions => "the world's doors at given positions",
            Self::Planner => "read from the instructions by a planner",
        }
    }

    /// Whether it is independent of every planner.
    pub fn is_independent(self) -> bool {
        self != Self::Planner
    }
}
