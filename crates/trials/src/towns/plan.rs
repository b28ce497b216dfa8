//! What a battery of towns is.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// What a battery is: the same plan gives the same windows and deliveries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TownsPlan {
    /// Version of OpenBench; another one may build other worlds.
    pub version: String,
    /// The maps; windows are drawn from each in turn.
    pub maps: Vec<PathBuf>,
    /// Half the side of a window, metres.
    pub radius: f64,
    /// What windows, worlds, deliveries and noise are drawn from.
    pub seed: u64,
    /// How far east of the window's middle the origin of its frame lies, metres.
    pub false_origin: f64,
    /// Name of the agent.
    pub agent: String,
    /// What was set with `--set`.
    pub settings: BTreeMap<String, String>,
}

impl TownsPlan {
    /// The seed of a window's world and deliveries.
    pub fn window_seed(&self, number: usize) -> u64 {
        // As TOML has integers: not above 2^63.
        (self
            .seed
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(number as u64))
            >> 1
    }
}
