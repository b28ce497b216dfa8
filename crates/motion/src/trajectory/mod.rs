//! Trajectories: where the robot is to be, and when.
//!
//! Planners and recovery maneuvers make a [`Trajectory`]. Code that drives one, or looks for
//! conflicts along one, need not know which planner it comes from.
//!
//! | module | contents |
//! |---|---|
//! | `timed_poses` | [`Trajectory`]: poses at times, read and carried along from cycle to cycle |
//! | `draft` | a first band along a polyline |
//! | `resize` | [`Resolution`]: how finely a band is divided |

mod draft;
mod resize;
mod timed_poses;

pub use resize::Resolution;
pub(crate) use timed_poses::COMMAND_S;
pub use timed_poses::{TimedPose, Trajectory};
