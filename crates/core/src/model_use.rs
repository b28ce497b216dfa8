//! What is asked of language and vision models.

use serde::{Deserialize, Serialize};

/// How much was asked of models, and how long that took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ModelUse {
    /// Requests, those without an answer included.
    pub calls: u32,
    /// Requests without an answer.
    pub failed: u32,
    /// Tokens of the requests, as the servers count them.
    pub prompt_tokens: u64,
    /// Tokens of the answers.
    pub completion_tokens: u64,
    /// Time waited for answers and for those that did not come, milliseconds of the clock on the wall. A replay has the times that were recorded.
    pub latency_ms: u64,
}

impl ModelUse {
    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            calls: self.calls.saturating_add(other.calls),
            failed: self.failed.saturating_add(other.failed),
            prompt_tokens: self.prompt_tokens.saturating_add(other.prompt_tokens),
            completion_tokens: self
                .completion_tokens
                .saturating_add(other.completion_tokens),
            latency_ms: self.latency_ms.saturating_add(other.latency_ms),
        }
    }
}
