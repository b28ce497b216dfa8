//! Errors of reading and writing logs.
//!
//! No text repeats its source: `openbench_core::with_causes` prints both.

use std::io;
use std::path::PathBuf;

use openbench_core::SimTime;

use crate::cdr::CdrError;

/// Why a log cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be opened, created or renamed.
    #[error("cannot open, create or rename {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Reading the file failed.
    #[error("cannot read the log at byte {offset}")]
    Read {
        /// Bytes read before the error.
        offset: u64,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is not an MCAP file.
    #[error("not an MCAP file: it does not begin with the MCAP magic bytes")]
    NotMcap,
    /// The file is truncated. The messages before the end were read.
    #[error(
        "the log is truncated inside the {what} that begins at byte {offset}; \
         the messages before it were read"
    )]
    Truncated {
        /// Where the truncated record begins, bytes.
        offset: u64,
        /// What is truncated: `record`, `chunk` or `file`.
        what: &'static str,
    },
    /// The length field of a record exceeds the limit for records.
    #[error(
        "the {what} at byte {offset} declares a length of {bytes} bytes, more than the limit of \
         {limit}; the log is damaged"
    )]
    TooLarge {
        /// Where the record begins, bytes.
        offset: u64,
        /// `record` or `chunk`.
        what: &'static str,
        /// The declared length, bytes.
        bytes: u64,
        /// The limit, bytes.
        limit: u64,
    },
    /// A record is inconsistent in itself or with another one.
    #[error("the log is damaged at byte {offset}")]
    Damaged {
        /// Where the record, or the chunk that contains it, begins, bytes.
        offset: u64,
        /// What is wrong with it.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A topic has another message type than the one requested.
    #[error("topic `{topic}` has type {found}, not {wanted}")]
    WrongType {
        /// The topic.
        topic: String,
        /// Its type in the log, in full.
        found: String,
        /// The type requested.
        wanted: &'static str,
    },
    /// The bytes of a message do not match its type.
    #[error("the message on `{topic}` at {time} cannot be decoded")]
    Decode {
        /// The topic.
        topic: String,
        /// The log time of the message.
        time: SimTime,
        /// The decoding error.
        source: CdrError,
    },
    /// Writing failed.
    #[error("cannot write the log")]
    Write(#[from] mcap::McapError),
}
