//! Use of language and vision models.

use serde::{Deserialize, Serialize};

/// Requests to models, and the time that they took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ModelUse {
    /// Requests, failed ones included.
    pub calls: u32,
    /// Requests without an answer.
    pub failed: u32,
    /// Tokens of the requests, as counted by the servers.
    pub prompt_tokens: u64,
    /// Tokens of the answers.
    pub completion_tokens: u64,
    /// Time spent waiting, for failed requests too, milliseconds of wall time. A replay has the
    /// recorded times.
    pub latency_ms: u64,
}

impl ModelUse {
    /// The sum of both.
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

    /// What was used since `earlier`.
    #[must_use]
    pub fn since(self, earlier: Self) -> Self {
        Self {
            calls: self.calls.saturating_sub(earlier.calls),
            failed: self.failed.saturating_sub(earlier.failed),
            prompt_tokens: self.prompt_tokens.saturating_sub(earlier.prompt_tokens),
            completion_tokens: self
                .completion_tokens
                .saturating_sub(earlier.completion_tokens),
            latency_ms: self.latency_ms.saturating_sub(earlier.latency_ms),
        }
    }
}
