#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | experiment |
//! |---|---|
//! | [`motion`] | local planners in short scenes and among people |
//! | [`instructions`] | SRTP of planners over annotated instructions |
//! | [`towns`] | deliveries of an agent in random neighbourhoods |
//! | [`fairness`] | plates as in streets that a reader reads |
//! | [`degraded`] | health reported by a localizer with degraded sensors |
//! | [`localization`] | localization on public maps with errors |
//! | [`tour`] | drives that produce sensor logs |
//! | [`speed`] | speed of the simulator and of routing |

pub mod degraded;
pub mod fairness;
pub mod instructions;
pub mod localization;
pub mod motion;
pub mod speed;
pub mod tour;
pub mod towns;
