//! The names on a map as instructions may say them: every name of every building, and the label in
//! generic ones (`Building 3`, `3号楼` and a bare `3` all carry the label `3`).
//!
//! Parts of one multipolygon are one building. Buildings without any name cannot be asked for and
//! are left out.

use std::collections::BTreeMap;

use openbench_core::Address;
use openbench_osm::names::{fold, street_or_place};
use openbench_osm::{Building, Location, OsmMap, Tags, locate};

use crate::lexicon::class::Class;
use crate::lexicon::lexeme::{Lex, Lexeme};
use crate::lexicon::lexer::lexemes;
use crate::lexicon::tokens::{Token, condensed, letters, tokenize};
use crate::lexicon::words::Words;

/// Keys of names, besides `name` and `name:<language>`.
const NAME_KEYS: [&str; 6] = [
    "addr:housename",
    "alt_name",
    "short_name",
    "official_name",
    "loc_name",
    "int_name",
];

/// How many letters of a name are compared.
const LONGEST_ALIAS: usize = 200;

/// The most tokens of a name that consists of a word for a building and a label.
const LONGEST_GENERIC: usize = 6;

/// A building that has a name.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    /// A name that no other building on the map has, if there is one, else the map's name.
    pub name: String,
}

/// A name that is searched in instructions letter by letter.
#[derive(Debug, Clone)]
pub(crate) struct Alias {
    /// Folded, without spaces and marks.
    pub letters: Vec<char>,
    /// Index into [`Gazetteer::places`].
    pub place: usize,
}

impl Alias {
    /// Whether all of some words stand in it.
    fn has_all(&self, words: &[String]) -> bool {
        let letters: String = self.letters.iter().collect();
        words.iter().all(|word| letters.contains(word.as_str()))
    }

    /// Whether a word stands in it.
    pub(crate) fn holds(&self, word: &str) -> bool {
        let word: Vec<char> = word.chars().collect();
        !word.is_empty() && self.letters.windows(word.len()).any(|part| part == word)
    }
}

/// Places whose names are like some words.
pub(crate) struct Likeness {
    /// Indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
    /// The percentage of the letters of the shortest of the names that the words are.
    pub percent: u8,
}

/// All names on a map.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gazetteer {
    /// In the map's order.
    pub places: Vec<Place>,
    /// Names that are more than a label.
    pub aliases: Vec<Alias>,
    labels: BTreeMap<String, Vec<usize>>,
    exact: BTreeMap<String, Vec<usize>>,
}

impl Gazetteer {
    /// The names on `map`.
    pub(crate) fn new(map: &OsmMap, words: &Words) -> Self {
        let mut gazetteer = Self::default();
        let mut last = None;
        for building in &map.buildings {
            // Parts of one multipolygon follow each other in the map.
            if last.replace(building.element) == Some(building.element) {
                continue;
            }
            if let Some(name) = &building.name {
                gazetteer.add(name, building, map, words);
            }
        }
        gazetteer
    }

    fn add(&mut self, name: &str, building: &Building, map: &OsmMap, words: &Words) {
        let place = self.places.len();
        self.places.push(Place {
            name: distinct_name(name, building, map),
        });
        for number in numbers(&building.tags) {
            push_once(self.labels.entry(label(&number)).or_default(), place);
        }
        for alias in aliases(name, &building.tags) {
            let tokens = tokenize(&alias);
            let letters: Vec<char> = letters(&tokens).chars().take(LONGEST_ALIAS).collect();
            if letters.is_empty() {
                continue;
            }
            push_once(self.exact.entry(fold(&alias)).or_default(), place);
            match label_in(&alias, &tokens, words) {
                Some(label) => push_once(self.labels.entry(label).or_default(), place),
                None => self.aliases.push(Alias { letters, place }),
            }
        }
    }

    /// The places with exactly this name, whatever its case and spacing.
    pub(crate) fn named(&self, name: &str) -> &[usize] {
        self.exact.get(&fold(name)).map_or(&[], Vec::as_slice)
    }

    /// The places with this label, folded.
    pub(crate) fn labelled(&self, label: &str) -> &[usize] {
        self.labels.get(label).map_or(&[], Vec::as_slice)
    }

    /// The places one of whose names contains all of `words`, folded.
    pub(crate) fn with_parts(&self, words: &[String]) -> Likeness {
        let fitting: Vec<&Alias> = self
            .aliases
            .iter()
            .filter(|alias| alias.has_all(words))
            .collect();
        let said: usize = words.iter().map(|word| word.chars().count()).sum();
        // The share of the shortest name is the largest: a part is most likely meant for the name
        // that it makes up most of.
        let shortest = fitting
            .iter()
            .map(|alias| alias.letters.len())
            .min()
            .unwrap_or_default();
        let percent = (100 * said).checked_div(shortest);
        let mut places: Vec<usize> = fitting.iter().map(|alias| alias.place).collect();
        places.sort_unstable();
        places.dedup();
        Likeness {
            places,
            percent: percent.map_or(0, |percent| percent.min(100) as u8),
        }
    }
}

/// The name of a building; if others have it too, its address or another name of its own.
fn distinct_name(name: &str, building: &Building, map: &OsmMap) -> String {
    let look_up = |name: &str| {
        locate(
            map,
            &Address {
                building: name.to_owned(),
                unit: None,
            },
        )
    };
    // Only a name that leads back to this building helps.
    let is_its_own = |other: &String| match look_up(other) {
        Location::Building(found) => map.buildings[found].element == building.element,
        _ => false,
    };
    if !matches!(look_up(name), Location::Ambiguous(_)) {
        return name.to_owned();
    }
    let others = street_and_number(&building.tags)
        .into_iter()
        // The address first: it says where the building is.
        .chain(aliases(name, &building.tags));
    others
        .into_iter()
        .find(is_its_own)
        .unwrap_or_else(|| name.to_owned())
}

fn push_once(list: &mut Vec<usize>, place: usize) {
    // Places are added one after the other, so an equal one can only be the last.
    if list.last() != Some(&place) {
        list.push(place);
    }
}

/// A label for comparison: folded, without leading zeros.
pub(crate) fn label(text: &str) -> String {
    let folded = condensed(text);
    let short = folded.trim_start_matches('0');
    if short.is_empty() {
        folded
    } else {
        short.to_owned()
    }
}

fn numbers(tags: &Tags) -> Vec<String> {
    let values = [tags.get("ref"), tags.get("addr:housenumber")]
        .into_iter()
        .flatten();
    values
        .flat_map(|v| v.split([';', ',']))
        .map(|n| n.trim().to_owned())
        .filter(|n| !n.is_empty())
        .collect()
}

fn aliases(name: &str, tags: &Tags) -> Vec<String> {
    let mut names = vec![name.to_owned()];
    let is_name = |key: &str| {
        NAME_KEYS.contains(&key)
            || key == "name"
            || key.strip_prefix("name:").is_some_and(is_language)
    };
    for (_, value) in tags.iter().filter(|(key, _)| is_name(key)) {
        names.extend(value.split(';').map(|n| n.trim().to_owned()));
    }
    names.extend(street_and_number(tags));
    names.sort();
    names.dedup();
    names
}

/// Street and number of a building as different countries write them: number last, number first.
fn street_and_number(tags: &Tags) -> Vec<String> {
    match (street_or_place(tags), tags.get("addr:housenumber")) {
        (Some(street), Some(number)) => {
            vec![format!("{street} {number}"), format!("{number} {street}")]
        }
        _ => Vec::new(),
    }
}

fn is_language(suffix: &str) -> bool {
    // `name:de` and `name:zh-Hant`, but not `name:etymology` or `name:left`.
    let code = suffix.split(['-', '_']).next().unwrap_or_default();
    matches!(code.len(), 2 | 3) && code.bytes().all(|b| b.is_ascii_lowercase())
}

/// The label of a name that consists of a word for a building and a label, or of a label alone.
pub(crate) fn generic_label(name: &str, words: &Words) -> Option<String> {
    label_in(name, &tokenize(name), words)
}

fn label_in(name: &str, tokens: &[Token], words: &Words) -> Option<String> {
    // Most names contain no label; testing for that is much cheaper than reading them.
    if tokens.len() > LONGEST_GENERIC || !tokens.iter().any(|token| words.may_label(token)) {
        return None;
    }
    let lexemes = lexemes(tokens, &[], words.vocabulary(tokens));
    let core: Vec<&Lexeme> = lexemes.iter().filter(|lexeme| !is_light(lexeme)).collect();
    match core.as_slice() {
        [one] => label_of(one, name, tokens),
        [level, number] if is_building(level) => label_of(number, name, tokens),
        [number, level] if is_building(level) => label_of(number, name, tokens),
        _ => None,
    }
}

/// Whether a lexeme says nothing of a name.
fn is_light(lexeme: &Lexeme) -> bool {
    matches!(
        lexeme.lex,
        Lex::Dash | Lex::Mark | Lex::Word(Class::Sign | Class::Article, _)
    )
}

fn is_building(lexeme: &Lexeme) -> bool {
    use Class::{Building, BuildingLetter, WeakBuilding};
    matches!(
        lexeme.lex,
        Lex::Word(Building | WeakBuilding | BuildingLetter, _)
    )
}

/// The label that a lexeme is: a number or a single capital.
fn label_of(lexeme: &Lexeme, name: &str, tokens: &[Token]) -> Option<String> {
    let token = &tokens[lexeme.tokens.start];
    let letter =
        lexeme.tokens.len() == 1 && token.capital && name[token.span.clone()].chars().count() == 1;
    match &lexeme.lex {
        Lex::Number { label, .. } => Some(label.clone()),
        _ => letter.then(|| token.text.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generic_names_carry_their_label() {
        let words = Words::new();
        let label = |name: &str| generic_label(name, &words);
        for name in [
            "building3",
            "Building 03",
            "Block 3",
            "3号楼",
            "三号楼",
            "Bldg. 3",
            "3",
            "B3",
            "House No. 3",
            "Gebäude drei",
        ] {
            assert_eq!(label(name).as_deref(), Some("3"), "{name}");
        }
        assert_eq!(label("Tower B").as_deref(), Some("b"));
        assert_eq!(label("12A").as_deref(), Some("12a"));
        for name in [
            "Paldal Hall",
            "Casino de Monte-Carlo",
            "Building",
            "Block 3 West",
        ] {
            assert_eq!(label(name), None, "{name}");
        }
    }
}
