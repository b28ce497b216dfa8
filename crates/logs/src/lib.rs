//! MCAP logs with ROS 2 messages: what the recorder writes and odometry reads.
//!
//! Files follow the [MCAP specification](https://mcap.dev/spec) with its `ros2` profile: messages are CDR, schemas are
//! `ros2msg`. Foxglove, Rerun and `ros2 bag` open them.
//!
//! | module | what it does |
//! |---|---|
//! | [`cdr`] | the bytes of one message: OMG CDR, little-endian |
//! | [`messages`] | the messages that are written and read, and their definitions |
//! | [`writer`] | [`LogWriter`], [`LogFile`]: topics of typed messages into a file |
//! | [`reader`] | [`LogReader`]: and out of it again, whatever state the file is in |
//! | [`error`] | [`LogError`]: what can go wrong |
//!
//! Written bytes depend on the messages alone: no wall clock, no version of a library. Reading is bounded in memory
//! whatever lengths a file claims. Not done: services, actions, parameters, attachments, and the wide strings of IDL.

pub mod cdr;
pub mod error;
mod framing;
pub mod messages;
pub mod reader;
pub mod writer;

pub use cdr::CdrError;
pub use error::LogError;
pub use messages::Message;
pub use reader::{LogReader, LoggedMessage};
pub use writer::{LogFile, LogWriter};
