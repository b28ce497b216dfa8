//! Which of several buildings is meant, by what is said around it: its street, quarter or town, or
//! a word of its name.

use std::cell::OnceCell;

use openbench_core::{Address, AddressLevel};
use openbench_osm::hierarchy::{EnclosingPlace, enclosing_levels, enclosing_places};
use openbench_osm::{Location, OsmMap, locate};

use super::building::{Choice, map_name};
use crate::gazetteer::{Alias, Gazetteer};
use crate::lexicon::feature::Feature;
use crate::lexicon::languages::has_feature;
use crate::lexicon::tokens::{spelt, tokenize};

/// The shortest word that tells one name from others, in letters.
const SHORTEST_WORD: usize = 3;

/// The streets, quarters and towns of the map that an instruction names, searched on first use.
pub(super) struct Surroundings<'a> {
    pub map: &'a OsmMap,
    /// All that is said around doors, [`spelt`].
    pub whole: String,
    pub said: OnceCell<Vec<EnclosingPlace>>,
}

impl Surroundings<'_> {
    fn said(&self) -> &[EnclosingPlace] {
        self.said.get_or_init(|| {
            enclosing_places(self.map)
                .into_iter()
                .filter(|place| is_said(&place.level, &self.whole))
                .collect()
        })
    }

    /// Of several buildings that fit, the one whose street, quarter or town is said, if it is the
    /// only one.
    pub(super) fn narrow(&self, choice: Choice, said: &str) -> Choice {
        let map = self.map;
        let buildings = buildings_called(&choice.fitting, map);
        if buildings.len() < 2 {
            return choice;
        }
        let here: Vec<&EnclosingPlace> = self
            .said()
            .iter()
            .filter(|above| is_said(&above.level, said))
            .collect();
        let count = |b: usize| here.iter().filter(|above| above.holds(map, b)).count();
        let counts: Vec<usize> = buildings.iter().map(|(_, b)| count(*b)).collect();
        // The building that most of the said levels hold, and only if no other one has as many.
        // Nothing said gives all of them zero, and so none.
        let most = counts.iter().copied().max().unwrap_or_default();
        let mut there = buildings
            .iter()
            .zip(&counts)
            .filter(|(_, count)| **count == most);
        let (Some(((name, building), _)), None) = (there.next(), there.next()) else {
            return choice;
        };
        let within: Vec<&str> = here
            .iter()
            .filter(|above| above.holds(map, *building))
            .map(|above| above.level.name.as_str())
            .collect();
        // The shortest address that the map finds exactly once: the name, with one level, with all.
        let longer = within.iter().map(|level| format!("{name}, {level}"));
        let longest = format!("{name}, {}", within.join(", "));
        let names = std::iter::once((*name).clone())
            .chain(longer)
            .chain([longest]);
        match names
            .into_iter()
            .find(|name| matches!(all_of(name, map)[..], [_]))
        {
            Some(name) => Choice::sure(name),
            None => choice,
        }
    }

    /// The levels above a building that are said. If the map lacks the building, those that are
    /// said around its door.
    pub(super) fn above(&self, building: &str, around: &str) -> Vec<AddressLevel> {
        let own = match locate(
            self.map,
            &Address {
                building: building.to_owned(),
                unit: None,
            },
        ) {
            Location::Building(building) | Location::Unit { building, .. } => {
                enclosing_levels(self.map, building)
            }
            Location::Unknown => {
                let said = self
                    .said()
                    .iter()
                    .filter(|above| is_said(&above.level, around));
                return said.map(|above| above.level.clone()).collect();
            }
            Location::Ambiguous(_) => return Vec::new(),
        };
        own.into_iter()
            .filter(|level| is_said(level, around))
            .collect()
    }
}

/// Of several buildings that fit, the one that a word of its name tells from the others: `the
/// medical centre, the one in the north`.
pub(super) fn by_own_words(
    choice: Choice,
    said: &str,
    map: &OsmMap,
    gazetteer: &Gazetteer,
) -> Choice {
    if choice.fitting.len() < 2 {
        return choice;
    }
    let is_of_one = |alias: &&Alias| choice.places.contains(&alias.place);
    let aliases: Vec<&Alias> = gazetteer.aliases.iter().filter(is_of_one).collect();
    let only = |word: &str| {
        let mut bearers = aliases
            .iter()
            .filter(|alias| bears(alias, word))
            .map(|alias| alias.place);
        let first = bearers.next()?;
        bearers.all(|place| place == first).then_some(first)
    };
    let tokens = tokenize(said);
    let mut told = tokens.iter().filter_map(|token| only(&token.text));
    match told.next() {
        // Words that point to different places decide nothing.
        Some(place) if told.all(|other| other == place) => {
            Choice::sure(map_name(&gazetteer.places[place].name, map))
        }
        _ => choice,
    }
}

/// Whether a name begins or ends with a word, or holds a point of the compass.
fn bears(alias: &Alias, word: &str) -> bool {
    let letters: Vec<char> = word.chars().collect();
    let is_end = alias.letters.starts_with(&letters) || alias.letters.ends_with(&letters);
    has_feature(word, Feature::Compass) && alias.holds(word)
        || letters.len() >= SHORTEST_WORD && is_end
}

/// The buildings of a name.
fn all_of<'a>(name: &'a String, map: &OsmMap) -> Vec<(&'a String, usize)> {
    match locate(
        map,
        &Address {
            building: name.clone(),
            unit: None,
        },
    ) {
        Location::Ambiguous(all) => all.into_iter().map(|building| (name, building)).collect(),
        Location::Building(building) | Location::Unit { building, .. } => vec![(name, building)],
        Location::Unknown => Vec::new(),
    }
}

/// The buildings of several names, each once; with the name that no other building has, if there is
/// one.
fn buildings_called<'a>(names: &'a [String], map: &OsmMap) -> Vec<(&'a String, usize)> {
    let mut all: Vec<(&String, usize)> = Vec::new();
    for found in names.iter().map(|name| all_of(name, map)) {
        let is_own = found.len() == 1;
        for (name, building) in found {
            match all.iter_mut().find(|(_, known)| *known == building) {
                Some(known) if is_own => known.0 = name,
                Some(_) => {}
                None => all.push((name, building)),
            }
        }
    }
    all
}

/// Whether the name of a level stands in what is said. A number alone does not count: it may be
/// that of a building, a telephone or a weight.
fn is_said(level: &AddressLevel, said: &str) -> bool {
    let is_name = level
        .name
        .chars()
        .filter(|c| c.is_alphabetic())
        .nth(1)
        .is_some();
    // `spelt` puts marks around words, so a name is found as whole words only.
    is_name && said.contains(&spelt(&level.name))
}
