#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | what it does |
//! |---|---|
//! | [`cdr`] | encodes and decodes the bytes of one message: OMG CDR, little-endian |
//! | [`messages`] | the message types and their ROS 2 definitions |
//! | `writer` | [`LogWriter`], [`LogFile`]: write topics of typed messages to a file |
//! | `reader` | [`LogReader`]: reads messages from a file, also from a truncated one |
//! | `error` | [`LogError`]: errors of reading and writing |

pub mod cdr;
mod error;
mod framing;
pub mod messages;
mod reader;
mod writer;

pub use cdr::CdrError;
pub use error::LogError;
pub use messages::Message;
pub use reader::{LogReader, LoggedMessage};
pub use writer::{LogFile, LogWriter};
