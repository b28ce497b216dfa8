//! Instructions generated from templates (`data/instructions/templates`); the same seed gives the
//! same instructions.
//!
//! Each template of each language is filled several times, with different doors of the estate, one
//! form of address, and numbers as digits or as words.
//!
//! | placeholder | in | replaced by |
//! |---|---|---|
//! | `{1}` | template | address of the first door |
//! | `{b1}`, `{u1}` | template | number of its building, of its unit |
//! | `{b}`, `{u}` | form of address | number of the building, of the unit |
//! | `{o}` | form of address | ordinal of the unit |
//!
//! The doors are in different buildings, except in templates with `one_building`; with `one_unit`
//! all have the same unit. A template says which doors are delivered to (`deliver`, by default all)
//! and in which order (`before`). Doors that it mentions otherwise must not be delivered to.

use openbench_core::Address;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Deserialize;

use super::{Case, Difficulty, MapName, Split};

/// The languages (BCP 47) and their templates.
const LANGUAGES: [(&str, &str); 6] = [
    (
        "en",
        include_str!("../../data/instructions/templates/en.toml"),
    ),
    (
        "zh",
        include_str!("../../data/instructions/templates/zh.toml"),
    ),
    (
        "es",
        include_str!("../../data/instructions/templates/es.toml"),
    ),
    (
        "de",
        include_str!("../../data/instructions/templates/de.toml"),
    ),
    (
        "fr",
        include_str!("../../data/instructions/templates/fr.toml"),
    ),
    (
        "ja",
        include_str!("../../data/instructions/templates/ja.toml"),
    ),
];
/// Number of buildings of the estate.
const BUILDINGS: usize = 12;
/// Number of units of each building.
const UNITS: usize = 4;
/// Number of instructions from each template.
const REPETITIONS: usize = 3;
/// Share of instructions with numbers as words, except easy ones.
const NUMBER_WORDS_SHARE: f64 = 0.3;
/// Maximum number of doors in a template.
const MAX_DOORS: usize = 4;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Language {
    numbers: Vec<String>,
    #[serde(default)]
    ordinals: Vec<String>,
    /// Contractions of prepositions with articles: separate and contracted form.
    #[serde(default)]
    contractions: Vec<(String, String)>,
    development: Templates,
    test: Templates,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Templates {
    addresses: Vec<String>,
    templates: Vec<Template>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Template {
    difficulty: Difficulty,
    text: String,
    #[serde(default)]
    deliver: Vec<usize>,
    #[serde(default)]
    before: Vec<(usize, usize)>,
    #[serde(default)]
    one_building: bool,
    #[serde(default)]
    one_unit: bool,
}

/// A door of the estate: numbers of building and unit, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Door {
    building: usize,
    unit: usize,
}

impl Door {
    fn address(self) -> Address {
        let Self { building, unit } = self;
        Address::new(format!("building{building}"), format!("unit{unit}"))
    }
}

/// Generates the instructions of a split from a seed; the unseen split has none from templates.
///
/// # Panics
/// Never: a test parses the built-in templates.
pub fn generated(split: Split, seed: u64) -> Vec<Case> {
    let mut cases = Vec::new();
    for (stream, (lang, text)) in (0..).zip(LANGUAGES) {
        let language: Language = toml::from_str(text).expect("the built-in templates are valid");
        let (templates, name) = match split {
            Split::Development => (&language.development, "development"),
            Split::Test => (&language.test, "test"),
            Split::Unseen => break,
        };
        // A stream for each language and split, so that a new template changes no other language. A
        // language takes the bits from 32, the split bit 40: they do not overlap.
        let mut rng = Pcg64Mcg::seed_from_u64(
            seed ^ (stream << 32) ^ (u64::from(split == Split::Test) << 40),
        );
        let every = templates
            .templates
            .iter()
            .flat_map(|template| std::iter::repeat_n(template, REPETITIONS));
        for (number, template) in (1..).zip(every) {
            let id = format!("{lang}-made-{name}-{number:02}");
            let mut case = language.fill(template, templates, &mut rng);
            (case.id, case.lang) = (id, lang.to_owned());
            cases.push(case);
        }
    }
    cases
}

impl Language {
    /// A case from a template, without id and language.
    fn fill(&self, template: &Template, templates: &Templates, rng: &mut Pcg64Mcg) -> Case {
        // Templates number their doors from 1 without gaps, so the largest number is the count.
        let count = (1..=MAX_DOORS)
            .rev()
            .find(|k| names(&template.text, *k))
            .unwrap_or(0);
        let doors = doors(template, count, rng);
        let form = &templates.addresses[rng.random_range(0..templates.addresses.len())];
        let as_words =
            template.difficulty != Difficulty::Easy && rng.random_bool(NUMBER_WORDS_SHARE);
        let mut instruction = template.text.clone();
        for (k, door) in (1..).zip(&doors) {
            let building = self.number(door.building, as_words);
            let unit = self.number(door.unit, as_words);
            let ordinal = self.ordinals.get(door.unit - 1).map_or("", String::as_str);
            let address = form
                .replace("{b}", &building)
                .replace("{u}", &unit)
                .replace("{o}", ordinal);
            instruction = instruction
                .replace(&format!("{{{k}}}"), &address)
                .replace(&format!("{{b{k}}}"), &building)
                .replace(&format!("{{u{k}}}"), &unit);
        }
        // After the addresses: the article that contracts, as in `de le` to `du`, begins an
        // address.
        for (apart, together) in &self.contractions {
            instruction = instruction.replace(apart, together);
        }
        let all: Vec<usize> = (1..=count).collect();
        let deliver = if template.deliver.is_empty() {
            &all
        } else {
            &template.deliver
        };
        // `before` has the numbers of doors, the case has indices into its deliveries.
        let place = |door: usize| deliver.iter().position(|d| *d == door);
        let before = template
            .before
            .iter()
            .filter_map(|(a, b)| Some((place(*a)?, place(*b)?)));
        Case {
            id: String::new(),
            lang: String::new(),
            difficulty: Some(template.difficulty),
            map: Some(MapName::Estate),
            instruction: sentence(&instruction),
            deliveries: deliver
                .iter()
                .map(|door| doors[door - 1].address())
                .collect(),
            before: before.collect(),
            ambiguous: false,
        }
    }

    fn number(&self, number: usize, as_word: bool) -> String {
        let word = self.numbers.get(number - 1).filter(|_| as_word);
        word.cloned().unwrap_or_else(|| number.to_string())
    }
}

/// Whether a template mentions door `k`.
fn names(text: &str, k: usize) -> bool {
    ["", "b", "u"]
        .iter()
        .any(|kind| text.contains(&format!("{{{kind}{k}}}")))
}

/// Draws different doors.
fn doors(template: &Template, count: usize, rng: &mut Pcg64Mcg) -> Vec<Door> {
    let mut doors: Vec<Door> = Vec::new();
    // There are always enough: a template has at most four doors, and none asks for one building
    // and one unit at once.
    while doors.len() < count {
        // Both numbers are drawn even where the first door determines one, since the files of the
        // data set were generated so.
        let mut door = Door {
            building: rng.random_range(1..=BUILDINGS),
            unit: rng.random_range(1..=UNITS),
        };
        let first = doors.first().copied().unwrap_or(door);
        if template.one_building {
            door.building = first.building;
        }
        if template.one_unit {
            door.unit = first.unit;
        }
        let is_new = doors.iter().all(|other| {
            *other != door && (template.one_building || other.building != door.building)
        });
        if is_new {
            doors.push(door);
        }
    }
    doors
}

/// The text with its first letter in upper case.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_are_generated_from_seed_1() {
        for (split, file) in [
            (Split::Development, super::super::DEVELOPMENT[1]),
            (Split::Test, super::super::TEST[1]),
        ] {
            let lines: Vec<String> = generated(split, 1)
                .iter()
                .map(|case| serde_json::to_string(case).unwrap())
                .collect();
            let changed = lines
                .iter()
                .zip(file.lines())
                .find(|(new, kept)| new != kept);
            assert!(
                changed.is_none() && lines.len() == file.lines().count(),
                "{changed:?}"
            );
        }
    }

    #[test]
    fn all_placeholders_are_replaced() {
        for case in [Split::Development, Split::Test]
            .into_iter()
            .flat_map(|split| generated(split, 7))
        {
            assert!(
                !case.instruction.contains(['{', '}']),
                "{}",
                case.instruction
            );
            assert!((1..=3).contains(&case.deliveries.len()), "{case:?}");
        }
        assert_ne!(generated(Split::Test, 1), generated(Split::Test, 2));
    }
}
