//! Those who move: who they are, what ground is theirs, and how to drive near them.
//!
//! | module | its one job |
//! |---|---|
//! | [`tracker`] | [`Tracker`]: who moves, from what appears where the ground was free |
//! | [`track`] | one body, followed by a Kalman filter of constant velocity |
//! | [`cluster`] | points that hang together |
//! | [`yielding`] | [`Ways`]: ground that somebody is about to walk over |
//! | [`caution`] | [`Caution`]: slow enough where somebody may surprise |
//!
//! [`Ways`]: yielding::Ways
//! [`Caution`]: caution::Caution

pub mod caution;
mod cluster;
mod track;
pub mod tracker;
pub mod yielding;

pub use tracker::{Newcomers, Tracker};
