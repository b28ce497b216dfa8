//! Why there is no plan.
//!
//! No text repeats its source: `openbench_core::with_causes` prints both.

use std::sync::Arc;

use openbench_core::with_causes;
use openbench_models::ChatError;

/// How much of an instruction or a reply an error quotes, in characters.
const QUOTE: usize = 200;

/// Why an instruction has no plan.
///
/// A delivery that is understood but cannot be made is no error: it carries its
/// [`problem`](openbench_core::PlannedDelivery::problem).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The instruction names no place to deliver to.
    #[error("no delivery understood in `{instruction}`: {hint}")]
    NotUnderstood {
        /// The beginning of the instruction.
        instruction: String,
        /// What would help.
        hint: String,
    },
    /// The chat model did not answer.
    #[error("the chat model `{model}` is not available")]
    ModelUnavailable {
        /// The model's name.
        model: String,
        /// What the endpoint said.
        source: ChatError,
    },
    /// The chat model answered, also when asked again, what cannot be a plan for this instruction.
    #[error(
        "the chat model `{model}` failed at {stage} with the answer `{reply}` (another model or \
         the planner `grammar` may understand the instruction)"
    )]
    InvalidAnswer {
        /// The model's name.
        model: String,
        /// `address resolution`, `verification` or `optimisation`.
        stage: String,
        /// What is wrong with the answer.
        source: AnswerError,
        /// The beginning of the answer.
        reply: String,
    },
}

impl PlanError {
    pub(crate) fn not_understood(instruction: &str, hint: &str) -> Self {
        Self::NotUnderstood {
            instruction: quote(instruction),
            hint: hint.to_owned(),
        }
    }
}

/// Why an answer of a chat model cannot be used. The model gets the text when it is asked again.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum AnswerError {
    /// It is longer than any answer should be.
    #[error("the answer is too long")]
    TooLong,
    /// It holds no object or array that is complete.
    #[error("the answer holds no complete JSON")]
    NoJson,
    /// The JSON in it has another form than asked for.
    #[error("{0}")]
    Form(&'static str),
    /// It has too many deliveries.
    #[error("it has more than {most} deliveries")]
    TooManyDeliveries {
        /// So many are allowed.
        most: usize,
    },
    /// One of its deliveries lacks a field or has one of another type.
    #[error("a delivery cannot be read")]
    Delivery {
        /// What is wrong with it.
        source: Arc<serde_json::Error>,
    },
    /// It invents a building.
    #[error("the instruction names no building `{name}`")]
    NoSuchBuilding {
        /// The building's name.
        name: String,
    },
    /// It invents a unit.
    #[error("the instruction names no unit `{name}`")]
    NoSuchUnit {
        /// The unit's name.
        name: String,
    },
    /// It puts together a door that the instruction does not name, and quotes nothing.
    #[error(
        "the instruction does not seem to name `{door}`; leave it out, or, if the sender wants it, \
         add to that entry \"words\": the sender's own words, the whole clause that names it and \
         no other door"
    )]
    NotNamed {
        /// The door's address.
        door: String,
    },
    /// It drops a door that the instruction names, and quotes nothing.
    #[error(
        "the instruction also seems to name `{door}`; add it, or, if the sender rejects it, put it \
         under \"rejected\" with the sender's own words that do so"
    )]
    Dropped {
        /// The door's address.
        door: String,
    },
    /// Its order is no permutation of the stops.
    #[error("the order must hold each of 1 to {count} once")]
    NoPermutation {
        /// How many stops there are.
        count: usize,
    },
    /// Its order is not the one that was asked for.
    #[error("it breaks the order that the instruction asks for")]
    WrongOrder,
}

impl PartialEq for AnswerError {
    /// Errors are equal if they and their causes say the same: those of JSON cannot be compared
    /// otherwise.
    fn eq(&self, other: &Self) -> bool {
        with_causes(self) == with_causes(other)
    }
}

/// The beginning of a text.
pub(crate) fn quote(text: &str) -> String {
    let text = text.trim();
    let mut quoted: String = text.chars().take(QUOTE).collect();
    if quoted.len() < text.len() {
        quoted.push('…');
    }
    quoted
}
