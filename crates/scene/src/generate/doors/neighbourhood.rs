//! What the plates of a door depend on beyond the door: the language of the streets, and whether
//! the building has other doors.

use std::collections::BTreeMap;

use openbench_core::address::fold_name;
use openbench_osm::{OsmMap, Road};

use super::doorway::Doorway;
use crate::plates::Language;

/// The neighbourhood of all doors.
#[derive(Debug)]
pub(crate) struct Neighbourhood {
    /// Language of most streets; `None` if their names do not tell.
    named: Option<Language>,
    /// Whether it lies in China, where names on maps may be English ones.
    is_in_china: bool,
    /// Number of doors by the folded name of their building.
    doors: BTreeMap<String, usize>,
}

impl Neighbourhood {
    pub fn of(map: &OsmMap, doorways: &[Doorway]) -> Self {
        let name = |road: &'_ Road| road.tags.get("name").map(str::to_owned);
        let names: Vec<String> = map.roads.iter().filter_map(name).collect();
        let mut doors = BTreeMap::new();
        for doorway in doorways {
            *doors
                .entry(fold_name(&doorway.address.building))
                .or_default() += 1;
        }
        Self {
            named: Language::of_streets(names.iter().map(String::as_str)),
            is_in_china: is_in_china(map),
            doors,
        }
    }

    /// The language of signs.
    pub fn language(&self) -> Language {
        self.named.unwrap_or(Language::English)
    }

    /// The languages of which that of a building's plates is drawn.
    pub fn languages(&self) -> &'static [Language] {
        match self.language() {
            Language::English if self.is_in_china => {
                &[Language::English, Language::English, Language::Chinese]
            }
            Language::English => &[Language::English],
            Language::German => &[Language::German],
            Language::French => &[Language::French],
            Language::Italian => &[Language::Italian],
            Language::Spanish => &[Language::Spanish],
            Language::Portuguese => &[Language::Portuguese],
            Language::Chinese => &[Language::Chinese],
        }
    }

    /// Whether no other door has the building's name.
    pub fn is_only(&self, door: &Doorway) -> bool {
        self.doors.get(&fold_name(&door.address.building)) == Some(&1)
    }
}

/// Whether a map lies in a rectangle around most of China's cities.
fn is_in_china(map: &OsmMap) -> bool {
    let first = map.buildings.first().and_then(|b| b.polygon.outer.first());
    first.is_some_and(|point| {
        let at = map.projection.to_lonlat(*point);
        (102.0..123.0).contains(&at.lon) && (22.0..42.0).contains(&at.lat)
    })
}
