//! Where things are, and which ground is free for more.
//!
//! | file | contents |
//! |---|---|
//! | `extent` | the rectangle that a world covers |
//! | `features` | tagged nodes and rows of trees |
//! | `lanes` | roads by place |
//! | `clearance` | what must stay free, by place |
//! | `keep_free` | what the map, doors and the start keep free |
//! | `occupied` | ground that generators have taken |
//! | `reach` | which ground is connected |
//! | `start` | the robot's start |

pub(super) mod clearance;
pub(super) mod extent;
pub(super) mod features;
pub(super) mod keep_free;
pub(super) mod lanes;
pub(super) mod occupied;
pub(super) mod reach;
pub(super) mod start;
