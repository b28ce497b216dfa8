//! A connection with a policy.

use std::time::Duration;

use super::message::{Reply, Request};

/// Limit of the length of a message, bytes. A map of a town has a few megabytes.
pub const MAX_FRAME_BYTES: usize = 64 << 20;

/// A connection with one policy, which answers one message after the other.
pub trait Link: Send {
    /// Sends a message.
    ///
    /// # Errors
    /// [`LinkError`]; the link is of no use afterwards.
    fn send(&mut self, request: &Request) -> Result<(), LinkError>;

    /// Waits for the next message, no longer than `within`.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    fn receive(&mut self, within: Duration) -> Result<Reply, LinkError>;
}

/// Why a policy cannot be talked to.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinkError {
    /// The other side is gone.
    #[error("the policy ended {how}")]
    Ended {
        /// How, as far as is known.
        how: String,
    },
    /// The policy says that it cannot begin.
    #[error("{detail}")]
    CannotBegin {
        /// Why, in its words.
        detail: String,
    },
    /// No message came in time.
    #[error("the policy did not answer within {} s", .within.as_secs_f64())]
    Silent {
        /// How long it was waited for.
        within: Duration,
    },
    /// A message is longer than allowed.
    #[error("a message of {bytes} bytes is longer than {} MiB", MAX_FRAME_BYTES >> 20)]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// A message is none of the protocol.
    #[error("a message cannot be read: {detail}")]
    Unreadable {
        /// What is wrong.
        detail: String,
    },
    /// A message of the protocol that does not answer the last one.
    #[error("the policy said {said} where {expected} was expected")]
    OutOfTurn {
        /// What it said.
        said: &'static str,
        /// What it could have said.
        expected: &'static str,
    },
    /// The policy speaks another version of the protocol.
    #[error("{program} speaks version {theirs} of the protocol, and this program version {ours}")]
    Version {
        /// Who says so.
        program: String,
        /// Its version.
        theirs: u32,
        /// [`PROTOCOL`](super::message::PROTOCOL).
        ours: u32,
    },
}

impl LinkError {
    pub(super) fn ended(how: &str) -> Self {
        Self::Ended {
            how: how.to_owned(),
        }
    }
}

impl From<std::io::Error> for LinkError {
    fn from(error: std::io::Error) -> Self {
        Self::Ended {
            how: format!("({error})"),
        }
    }
}
