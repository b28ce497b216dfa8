//! Where the doors are of buildings for which the map has none; drawn in
//! `openbench_scene::generate`.

use serde::{Deserialize, Serialize};

use super::level::Condition;

/// Where the doors are of buildings without a mapped entrance: in the middle of the wall towards
/// the street, or where the seed of the run draws them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DoorPlaces {
    /// Whether they are drawn.
    pub drawn: bool,
}

impl Condition for DoorPlaces {
    const KEY: &'static str = "doors";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("mapped", Self { drawn: false }),
        ("drawn", Self { drawn: true }),
    ];

    fn check(&self) -> Result<(), String> {
        Ok(())
    }
}
