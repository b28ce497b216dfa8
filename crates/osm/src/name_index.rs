//! Looks buildings up by their names.

use std::collections::BTreeMap;

use crate::names::{fold, fold_number, full_names, numbers};
use crate::tags::Tags;

/// An index from folded names to buildings, given by their indices.
#[derive(Debug, Clone, Default)]
pub(crate) struct NameIndex {
    /// Names in full.
    full: Tier,
    /// Names in full by the addresses of doors.
    by_doors: Tier,
    /// Bare numbers, of buildings and of doors.
    numbers: Tier,
}

/// Names of one kind, and the buildings that have each of them.
type Tier = BTreeMap<String, Vec<usize>>;

impl NameIndex {
    /// An index of buildings by their tags, and of the doors that lead into them: each with the
    /// index of its building.
    pub(crate) fn new<'a>(
        buildings: impl Iterator<Item = &'a Tags>,
        doors: impl Iterator<Item = (usize, &'a Tags)>,
    ) -> Self {
        let mut index = Self::default();
        for (building, tags) in buildings.enumerate() {
            add(&mut index.full, full_names(tags), building);
            add(&mut index.numbers, numbers(tags), building);
        }
        for (building, tags) in doors {
            // Other tags of a door, such as its `name`, name the unit and not the building.
            let address: Tags = tags
                .iter()
                .filter(|(key, _)| key.starts_with("addr:"))
                .collect();
            add(&mut index.by_doors, full_names(&address), building);
            add(&mut index.numbers, numbers(&address), building);
        }
        for tier in [&mut index.full, &mut index.by_doors, &mut index.numbers] {
            for buildings in tier.values_mut() {
                buildings.sort_unstable();
                buildings.dedup();
            }
        }
        index
    }

    /// The buildings with this name, in order. The best kind of name that any building has counts:
    /// first full names, then addresses of doors, then bare numbers.
    pub(crate) fn buildings(&self, name: &str) -> &[usize] {
        let folded = fold(name);
        let full = self
            .full
            .get(&folded)
            .or_else(|| self.by_doors.get(&folded));
        let number = || {
            self.numbers
                .get(&folded)
                // `Building 3` finds the bare number 3, but only after a building that bears those
                // words.
                .or_else(|| self.numbers.get(&fold_number(name)))
        };
        full.or_else(number).map_or(&[], Vec::as_slice)
    }
}

fn add(tier: &mut Tier, names: Vec<String>, building: usize) {
    for name in names {
        tier.entry(name).or_default().push(building);
    }
}
