//! The parameters of the towns experiment.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The parameters of the experiment. The same plan gives the same windows and deliveries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TownsPlan {
    /// Version of OpenBench; another version may build other worlds.
    pub version: String,
    /// The OSM files; windows are drawn from each in turn.
    pub maps: Vec<PathBuf>,
    /// Half the side of a window, metres.
    pub radius: f64,
    /// Seed of windows, worlds, deliveries and noise.
    pub seed: u64,
    /// Distance by which the origin of the `map` frame is east of the window's centre, metres.
    pub false_origin: f64,
    /// Name of the agent.
    pub agent: String,
    /// The agent's settings (`--set KEY=VALUE`).
    pub settings: BTreeMap<String, String>,
}

impl TownsPlan {
    /// The seed of a window's world and deliveries.
    pub fn window_seed(&self, number: usize) -> u64 {
        // 2^64 divided by the golden ratio: the windows of nearby seeds share no seed. Without the
        // last bit, since TOML integers have 63.
        (self
            .seed
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(number as u64))
            >> 1
    }
}
