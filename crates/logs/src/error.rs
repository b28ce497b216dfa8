//! What can go wrong with a log.

use std::io;
use std::path::PathBuf;

use openbench_core::SimTime;

use crate::cdr::CdrError;

/// A log that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be opened, created or renamed.
    #[error("{}: {source}", path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Reading stopped halfway.
    #[error("the log cannot be read on at byte {offset}: {source}")]
    Read {
        /// Bytes read before.
        offset: u64,
        /// What the system said.
        source: io::Error,
    },
    /// The file is no MCAP file.
    #[error("this is no MCAP file: it does not begin with the MCAP magic bytes")]
    NotMcap,
    /// The file ends too early; what was before is good.
    #[error(
        "the log ends early at byte {offset}, in the middle of a {what}; the messages before it were read"
    )]
    Truncated {
        /// Where the record that is cut off begins.
        offset: u64,
        /// What is cut off.
        what: &'static str,
    },
    /// A record claims to be larger than any that is read.
    #[error(
        "the {what} at byte {offset} claims {bytes} bytes, more than the {limit} that are read; the log is damaged"
    )]
    TooLarge {
        /// Where the record begins.
        offset: u64,
        /// What claims so.
        what: &'static str,
        /// The claim.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// A record that contradicts itself or another.
    #[error("the log is damaged at byte {offset}: {source}")]
    Damaged {
        /// Where the record, or the chunk that holds it, begins.
        offset: u64,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A topic holds another type than was asked for.
    #[error("topic `{topic}` holds {found}, not {wanted}")]
    WrongType {
        /// The topic.
        topic: String,
        /// What it holds.
        found: String,
        /// What was asked for.
        wanted: &'static str,
    },
    /// A message whose bytes do not fit its type.
    #[error("the message on `{topic}` at {time} cannot be decoded: {source}")]
    Decode {
        /// The topic.
        topic: String,
        /// When it was logged.
        time: SimTime,
        /// What is wrong with it.
        source: CdrError,
    },
    /// Writing failed.
    #[error("the log cannot be written: {0}")]
    Write(#[from] mcap::McapError),
}
