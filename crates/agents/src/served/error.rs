//! Why a policy server is of no use.

use std::time::Duration;

use openbench_core::FailureCause;

use super::limits::{MAX_ANSWER_BYTES, MAX_ROWS};

/// Why a policy server is of no use.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// The address is none of a server of this kind.
    #[error("{address}: {problem}; write it as {example}")]
    Address {
        /// What was written, without a password.
        address: String,
        /// What is wrong with it.
        problem: &'static str,
        /// What could have been written.
        example: &'static str,
    },
    /// Nobody listens there, or not with the protocol.
    #[error("no policy server can be reached at {address}: {detail}")]
    Unreachable {
        /// Host and port.
        address: String,
        /// Why.
        detail: String,
    },
    /// The connection ended.
    #[error("the policy server closed the connection: {detail}")]
    Closed {
        /// What is known of the reason.
        detail: String,
    },
    /// No answer came in time.
    #[error("the policy server did not answer within {} s", .within.as_secs_f64())]
    Silent {
        /// How long it was waited for.
        within: Duration,
    },
    /// An answer is longer than allowed.
    #[error(
        "the policy server's answer is longer than {} MiB or {MAX_ROWS} rows",
        MAX_ANSWER_BYTES >> 20
    )]
    TooLong,
    /// An answer is none of the protocol.
    #[error("the policy server's answer cannot be read: {detail}")]
    Unreadable {
        /// What is wrong.
        detail: String,
    },
    /// An answer has numbers that are not finite.
    #[error("the policy server's answer contains NaN or infinity in row {row}")]
    NotFinite {
        /// The row, from 0.
        row: usize,
    },
    /// The server says that it failed.
    #[error("the policy server reports an error: {detail}")]
    Reported {
        /// What it says, shortened.
        detail: String,
    },
    /// The server does not take goals of this kind.
    #[error("{server} takes {takes} only; run a suite with `goal = \"point\"`")]
    Goal {
        /// Which kind of server.
        server: &'static str,
        /// What it takes.
        takes: &'static str,
    },
    /// The recorded answers cannot be used, or answers cannot be recorded.
    #[error("{detail}")]
    Recording {
        /// What is wrong.
        detail: String,
    },
    /// An error that was recorded, in its words.
    #[error("{detail}")]
    Repeated {
        /// What it meant for the deliveries.
        cause: FailureCause,
        /// The words.
        detail: String,
    },
}

impl ServerError {
    /// A question before an episode.
    pub(super) fn not_begun() -> Self {
        Self::Closed {
            detail: "no episode has begun".to_owned(),
        }
    }

    /// What it means for the deliveries.
    pub fn cause(&self) -> FailureCause {
        match self {
            Self::Goal { .. } => FailureCause::Briefing,
            Self::Repeated { cause, .. } => *cause,
            _ => FailureCause::PolicyUnavailable,
        }
    }

    /// An answer that is none of the protocol.
    pub(super) fn unreadable(detail: impl Into<String>) -> Self {
        Self::Unreadable {
            detail: detail.into(),
        }
    }
}
