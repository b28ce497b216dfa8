//! How much streets differ from each other: amounts that are drawn, and what was drawn in a world.
//! The things themselves are built in `generate::scenery`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What makes the streets of a world differ: amounts from 0, nothing, to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenery {
    /// Share of the lots without a mapped surface that are no lawn.
    pub ground: f64,
    /// Share of the trees and parked cars that have other shapes.
    pub shapes: f64,
    /// Amount of things on pavements, at walls and before doors.
    pub clutter: f64,
    /// Amount of steps, ramps, raised kerbs and light wells.
    pub relief: f64,
}

impl Scenery {
    /// Lawns, and the things of the map alone.
    pub const PLAIN: Self = Self {
        ground: 0.0,
        shapes: 0.0,
        clutter: 0.0,
        relief: 0.0,
    };
    /// Streets that differ.
    pub const VARIED: Self = Self {
        ground: 0.7,
        shapes: 0.6,
        clutter: 0.5,
        relief: 0.4,
    };

    /// Whether nothing is drawn.
    pub fn is_plain(&self) -> bool {
        *self == Self::PLAIN
    }
}

impl Default for Scenery {
    fn default() -> Self {
        Self::PLAIN
    }
}

/// What was drawn in a world, counted.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct DrawnScenery {
    /// Lots that are no lawn, by what they are.
    pub ground: BTreeMap<String, usize>,
    /// Trees of other shapes.
    pub trees: usize,
    /// Parked cars of other shapes.
    pub cars: usize,
    /// Things on pavements, at walls and before doors, by kind.
    pub clutter: BTreeMap<String, usize>,
    /// Those of them that stand beside a door.
    pub beside_doors: usize,
    /// Plants before a plate.
    pub before_plates: usize,
    /// Doors with steps.
    pub steps: usize,
    /// Doors with a ramp.
    pub ramps: usize,
    /// Stretches of raised kerbs.
    pub kerbs: usize,
    /// Light wells: places where the ground is missing.
    pub wells: usize,
}

impl DrawnScenery {
    /// Counts a thing of a kind.
    pub(crate) fn count_clutter(&mut self, kind: &str) {
        *self.clutter.entry(kind.to_owned()).or_default() += 1;
    }

    /// Counts a lot of a kind.
    pub(crate) fn count_ground(&mut self, kind: &str) {
        *self.ground.entry(kind.to_owned()).or_default() += 1;
    }

    /// In words, for reports.
    pub fn describe(&self) -> String {
        let things: usize = self.clutter.values().sum();
        let lots: usize = self.ground.values().sum();
        format!(
            "scenery: {lots} lots that are no lawn, {} trees and {} cars of other shapes, {things} \
             things in the way ({} beside doors, {} before plates); {} doors with steps, {} with \
             ramps; {} raised kerbs, {} light wells",
            self.trees,
            self.cars,
            self.beside_doors,
            self.before_plates,
            self.steps,
            self.ramps,
            self.kerbs,
            self.wells
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_counted_by_kind() {
        let mut drawn = DrawnScenery::default();
        drawn.count_clutter("bench");
        drawn.count_clutter("bench");
        drawn.count_ground("gravel");
        assert_eq!(drawn.clutter["bench"], 2);
        let words = drawn.describe();
        assert!(
            words.contains("1 lots") && words.contains("2 things"),
            "{words}"
        );
    }
}
