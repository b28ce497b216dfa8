//! Why there is no plan.

use openbench_models::ChatError;

/// How much of an instruction or a reply an error quotes, in characters.
const QUOTE: usize = 200;

/// Why an instruction has no plan. A delivery that is understood but cannot be made is no error: it carries its
/// [`problem`](openbench_core::PlannedDelivery::problem).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// No delivery could be made out.
    #[error("no delivery understood in `{instruction}`: {hint}")]
    NotUnderstood {
        /// The beginning of the instruction.
        instruction: String,
        /// What would help.
        hint: String,
    },
    /// The chat model did not answer.
    #[error("the chat model `{model}` is not available: {source}")]
    ModelUnavailable {
        /// The model's name.
        model: String,
        /// What the endpoint said.
        source: ChatError,
    },
    /// The chat model answered, also when asked again, what cannot be a plan for this instruction.
    #[error(
        "the chat model `{model}` failed at {stage}: {reason}; it said `{reply}`. Try again, another model, or the planner `grammar`"
    )]
    ModelNonsense {
        /// The model's name.
        model: String,
        /// `address resolution`, `verification` or `optimisation`.
        stage: String,
        /// What is wrong with the answer.
        reason: String,
        /// The beginning of the answer.
        reply: String,
    },
}

impl PlanError {
    pub(crate) fn not_understood(instruction: &str, hint: &str) -> Self {
        Self::NotUnderstood { instruction: quote(instruction), hint: hint.to_owned() }
    }
}

/// The beginning of a text.
pub(crate) fn quote(text: &str) -> String {
    let mut quoted: String = text.trim().chars().take(QUOTE).collect();
    if quoted.len() < text.trim().len() {
        quoted.push('…');
    }
    quoted
}
