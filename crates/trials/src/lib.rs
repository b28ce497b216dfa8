//! Experiments on parts of a delivery robot, each with numbers to compare.
//!
//! | module | what is measured |
//! |---|---|
//! | [`motion`] | how well local planners drive, alone and among people |
//! | [`instructions`] | how many instructions a planner understands: SRTP |
//! | [`towns`] | an agent's deliveries in neighbourhoods that a seed draws |
//! | [`degraded`] | whether a localizer reports trouble with its sensors |
//! | [`tour`] | drives for the sake of their logs |
//! | [`speed`] | how fast simulator and routing are |

pub mod degraded;
pub mod instructions;
pub mod motion;
pub mod speed;
pub mod tour;
pub mod towns;
