//! What was drawn for the doors of a generated world, counted.

use openbench_osm::houses::Face;
use serde::{Deserialize, Serialize};

/// The doors that were drawn in a world, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DrawnDoors {
    /// Doors at entrances that the map has: they are not drawn.
    pub mapped: usize,
    /// Doors that were drawn.
    pub doors: usize,
    /// Buildings that got them.
    pub buildings: usize,
    /// Buildings without a mapped entrance in which no robot could stand before a door.
    pub without: usize,
    /// Of the doors that were drawn, those towards the street.
    pub front: usize,
    /// Those at the sides.
    pub flank: usize,
    /// Those at the back.
    pub back: usize,
    /// Buildings for which a house number was drawn.
    pub numbers: usize,
}

impl DrawnDoors {
    /// Counts a door that was drawn.
    pub(crate) fn count(&mut self, face: Face) {
        self.doors += 1;
        match face {
            Face::Front => self.front += 1,
            Face::Flank => self.flank += 1,
            Face::Back => self.back += 1,
        }
    }

    /// In words, for reports.
    pub fn describe(&self) -> String {
        format!(
            "drawn doors: {} in {} buildings, {} towards the street, {} at a side, {} at the \
             back; {} mapped; {} house numbers",
            self.doors,
            self.buildings,
            self.front,
            self.flank,
            self.back,
            self.mapped,
            self.numbers
        )
    }
}
