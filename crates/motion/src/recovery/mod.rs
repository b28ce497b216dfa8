//! Recovery where a local planner does not drive on.
//!
//! | module | contents |
//! |---|---|
//! | `ladder` | which step comes next, and when a goal is given up |
//! | `progress` | whether the robot makes progress |
//! | `under_way` | a maneuver being driven |
//! | `maneuver` | places and headings searched with the whole footprint |
//! | `leave` | leaving near contact with an obstacle |
//! | `evade` | evading people |

pub(crate) mod evade;
pub(crate) mod ladder;
pub(crate) mod leave;
mod maneuver;
pub(crate) mod progress;
pub(crate) mod under_way;

pub use ladder::{Recovery, Step};
pub use maneuver::{NoManeuver, maneuver};
