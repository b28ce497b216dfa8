//! People and other moving bodies: who they are, which ground they will need, and how to drive near
//! them.
//!
//! | module | its one job |
//! |---|---|
//! | [`tracker`] | [`Tracker`]: moving bodies, from what appears where the ground was free |
//! | `track` | one body, followed by a Kalman filter of constant velocity |
//! | `cluster` | connected sets of points |
//! | [`yielding`] | [`Ways`]: ground that somebody is about to walk over |
//! | [`caution`] | [`Caution`]: slow enough to stop where people may not do as predicted |
//!
//! [`Ways`]: yielding::Ways
//! [`Caution`]: caution::Caution

pub mod caution;
mod cluster;
mod track;
pub mod tracker;
pub mod yielding;

pub use tracker::{Newcomers, Tracker};
