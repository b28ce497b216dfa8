//! Recovery: what to do where a local planner does not go on.
//!
//! | module | its one job |
//! |---|---|
//! | [`ladder`] | [`Ladder`]: which step comes next, and when a goal is given up |
//! | [`progress`] | whether the robot gets on |
//! | [`under_way`] | a maneuver being driven |
//! | [`maneuver`] | places and headings searched with the whole footprint |
//! | [`leave`] | leaving near contact with an obstacle |
//! | [`evade`] | evading people |
//!
//! [`Ladder`]: ladder::Ladder

pub mod evade;
pub mod ladder;
pub mod leave;
pub mod maneuver;
pub mod progress;
pub mod under_way;
