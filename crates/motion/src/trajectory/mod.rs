//! Trajectories: where the robot is to be, and when.
//!
//! Planners and recovery maneuvers make a [`Band`]. Code that drives one, or looks for conflicts
//! along one, needs not know which planner it comes from.
//!
//! | module | its one job |
//! |---|---|
//! | [`band`] | [`Band`]: poses at times, read and carried along from cycle to cycle |
//! | `draft` | a first band along a polyline |
//! | `resize` | [`Resolution`]: how finely a band is divided |

pub mod band;
mod draft;
mod resize;

pub use band::{Band, Knot};
pub use resize::Resolution;
