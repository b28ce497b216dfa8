//! Policies behind servers whose protocols others have defined: the agent senses and drives, the
//! server decides.
//!
//! | module | contents |
//! |---|---|
//! | [`agent`] | [`Served`]: the agent |
//! | [`question`] | [`Server`], what it is asked and what it answers |
//! | [`openpi`], [`vla_eval`], [`navdp`] | the protocols |
//! | [`settings`] | how answers are read |
//! | [`driving`] | how answers become velocities |
//! | [`recorded`] | answers that are recorded or repeated |
//! | [`address`], [`websocket`], [`arrays`] | what the protocols have in common |
//! | [`picture`], [`depth`] | images in the size that a policy takes, depths out of scans |
//! | [`turns`] | whose turn it is with a server that serves one robot at a time |
//! | [`limits`], [`error`] | how much a server may say, and why it is of no use |
//!
//! Answers are data: nothing that a server sends is executed.

pub mod address;
pub mod agent;
pub mod arrays;
pub mod depth;
pub mod driving;
pub mod error;
pub mod limits;
pub mod navdp;
pub mod openpi;
pub mod picture;
pub mod question;
pub mod recorded;
pub mod settings;
#[cfg(test)]
mod testing;
pub mod turns;
pub mod vla_eval;
pub mod websocket;

pub use agent::Served;
pub use error::ServerError;
pub use navdp::NavDp;
pub use openpi::OpenPi;
pub use question::{Answer, Episode, Question, Server};
pub use recorded::Recorded;
pub use settings::{
    Actions, NAVDP, OPENPI, Protocol, SETTINGS, Setting, SettingError, Settings, VLA_EVAL,
};
pub use turns::Turns;
pub use vla_eval::VlaEval;
