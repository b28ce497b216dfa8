//! People and other moving bodies: tracking them, and driving near them.
//!
//! | module | contents |
//! |---|---|
//! | `tracker` | [`Tracker`]: moving bodies, from what appears where the ground was free |
//! | `track` | one body, followed by a Kalman filter of constant velocity |
//! | `cluster` | connected sets of points |
//! | `right_of_way` | `RightOfWay`: ground that somebody is about to walk over |
//! | `caution` | `Caution`: slow enough to stop where people may not do as predicted |

pub(crate) mod caution;
mod cluster;
pub(crate) mod right_of_way;
mod track;
mod tracker;

pub use tracker::{NewPoints, Tracker};
