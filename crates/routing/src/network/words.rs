//! Which words of an element routing may ask for, each set of them kept once.

use std::collections::HashMap;

use openbench_osm::Tags;
use openbench_osm::stream::Words;

/// Keys that tell people something and no profile anything; with everything that follows a colon behind them.
const INFORMATION: [&str; 34] = [
    "addr",
    "alt_name",
    "attribution",
    "check_date",
    "created_by",
    "description",
    "destination",
    "fixme",
    "FIXME",
    "gnis",
    "history",
    "image",
    "import",
    "int_name",
    "int_ref",
    "is_in",
    "loc_name",
    "loc_ref",
    "mapillary",
    "name",
    "nat_ref",
    "note",
    "odbl",
    "official_name",
    "old_name",
    "old_ref",
    "operator",
    "ref",
    "short_name",
    "source",
    "start_date",
    "tiger",
    "url",
    "website",
];
const MORE_INFORMATION: [&str; 4] = ["wikidata", "wikipedia", "phone", "survey"];

/// Words of our own, which no map may bring.
const OWN: &str = "openbench";

fn informs(key: &str) -> bool {
    let stem = key.split_once(':').map_or(key, |(stem, _)| stem);
    stem == OWN || INFORMATION.contains(&stem) || MORE_INFORMATION.contains(&stem)
}

/// Sets of words by number. Number 0 is the empty set.
#[derive(Debug, Default)]
pub(super) struct Classes {
    numbers: HashMap<String, u32>,
    sets: Vec<Tags>,
    text: String,
}

impl Classes {
    pub(super) fn new() -> Self {
        Self { numbers: HashMap::from([(String::new(), 0)]), sets: vec![Tags::new()], text: String::new() }
    }

    /// The number of the set of those `words` that a profile may ask for, with `more` added.
    pub(super) fn number(&mut self, words: Words<'_>, more: Option<(&str, &str)>) -> u32 {
        let mut kept: Vec<_> = words.0.iter().copied().filter(|(key, _)| !informs(key)).chain(more).collect();
        kept.sort_by_key(|(key, _)| *key);
        self.text.clear();
        for (key, value) in &kept {
            self.text.extend([key, "\u{1e}", value, "\u{1f}"]);
        }
        if let Some(&number) = self.numbers.get(&self.text) {
            return number;
        }
        let number = self.sets.len() as u32;
        self.sets.push(kept.into_iter().collect());
        self.numbers.insert(self.text.clone(), number);
        number
    }

    /// The number of a set with one more word.
    pub(super) fn with(&mut self, class: u32, key: &str, value: &str) -> u32 {
        let set = self.sets[class as usize].clone();
        let words: Vec<(&str, &str)> = set.iter().collect();
        self.number(Words(&words), Some((key, value)))
    }

    pub(super) fn into_sets(self) -> Vec<Tags> {
        self.sets
    }
}

/// What a road is called.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct RoadName {
    /// `name`, empty if it has none.
    pub name: String,
    /// `ref`, the road's number, empty if it has none.
    pub reference: String,
}

/// Names by number. Number 0 is that of roads without a name.
#[derive(Debug)]
pub(super) struct Names {
    numbers: HashMap<RoadName, u32>,
    names: Vec<RoadName>,
}

impl Names {
    pub(super) fn new() -> Self {
        Self { numbers: HashMap::from([(RoadName::default(), 0)]), names: vec![RoadName::default()] }
    }

    pub(super) fn number(&mut self, words: Words<'_>) -> u32 {
        let word = |key: &str| words.get(key).unwrap_or_default().to_owned();
        let name = RoadName { name: word("name"), reference: word("ref") };
        if let Some(&number) = self.numbers.get(&name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.names.push(name.clone());
        self.numbers.insert(name, number);
        number
    }

    pub(super) fn into_names(self) -> Vec<RoadName> {
        self.names
    }
}
