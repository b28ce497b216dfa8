//! People and other moving bodies: tracking them, and driving near them.
//!
//! | module | its one job |
//! |---|---|
//! | [`tracker`] | [`Tracker`]: moving bodies, from what appears where the ground was free |
//! | `track` | one body, followed by a Kalman filter of constant velocity |
//! | `cluster` | connected sets of points |
//! | `yielding` | `Ways`: ground that somebody is about to walk over |
//! | `caution` | `Caution`: slow enough to stop where people may not do as predicted |

pub(crate) mod caution;
mod cluster;
mod track;
pub mod tracker;
pub(crate) mod yielding;

pub use tracker::{Newcomers, Tracker};
