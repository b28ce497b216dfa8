//! The kind of goal that a suite gives its agents.

use serde::{Deserialize, Serialize};

/// The goal in the briefings of a suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GoalKind {
    /// The instruction.
    #[default]
    Instruction,
    /// The place in front of the right door, in `map`: a task without language and without a search
    /// for plates. Each episode has one delivery, and any address declares it.
    Point,
}

impl GoalKind {
    /// Whether it is the instruction.
    pub fn is_instruction(&self) -> bool {
        *self == Self::Instruction
    }
}
