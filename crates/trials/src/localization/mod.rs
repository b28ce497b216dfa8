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

use openbench_osm::draws::mix;

pub mod cases;
pub mod drift;
pub mod drives;
pub mod examples;
pub mod labels;
pub mod peers;
pub mod report;
pub mod trial;

/// The seed of what has this number under another seed. Seeds and numbers that differ by little
/// give unrelated ones.
pub fn mixed_seed(seed: u64, number: u64) -> u64 {
    mix(mix(seed) ^ number)
}
