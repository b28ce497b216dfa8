//! Where a robot finds itself on a public map with errors.
//!
//! | module | content |
//! |---|---|
//! | [`drives`] | what a robot sees on its way, recorded once |
//! | [`cases`] | maps with errors, and what is known about the start |
//! | [`drift`] | odometry made worse |
//! | [`examples`] | candidates with the truth, to fit their probabilities |
//! | [`labels`] | which LiDAR returns are of facades, in truth |
//! | [`peers`] | other ways to find out where the robot is |
//! | [`report`] | what trials found, in numbers |
//! | [`trial`] | what a locator finds on a drive |

pub mod cases;
pub mod drift;
pub mod drives;
pub mod examples;
pub mod labels;
pub mod peers;
pub mod report;
pub mod trial;
