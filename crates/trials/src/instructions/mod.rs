//! Annotated delivery instructions, to measure the SRTP of planners.
//!
//! | module | content |
//! |---|---|
//! | [`mod@generated`] | instructions generated from templates |
//! | [`score`] | SRTP of a planner |
//!
//! The files in `data/instructions` are built in: instructions written by hand, generated from
//! templates, and in free speech, in three splits. The development split may be read and grows. The
//! test split was written before the grammar was adapted to it, the unseen split independently of
//! the grammar; `SHA256SUMS` freezes both.

pub mod generated;
pub mod score;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use openbench_core::{Address, Georeference, LonLat};
use openbench_osm::{OsmData, OsmMap};
use serde::{Deserialize, Serialize};

use openbench_bench::score::metrics::ExpectedPlan;

const ESTATE: &str = include_str!("../../data/instructions/estate.osm");
const TOWN: &str = include_str!("../../data/instructions/town.osm");
/// Written by hand, generated, free speech.
const DEVELOPMENT: [&str; 3] = [
    include_str!("../../data/instructions/hand-development.jsonl"),
    include_str!("../../data/instructions/made-development.jsonl"),
    include_str!("../../data/instructions/free-development.jsonl"),
];
const TEST: [&str; 2] = [
    include_str!("../../data/instructions/hand-test.jsonl"),
    include_str!("../../data/instructions/made-test.jsonl"),
];
const UNSEEN: &str = include_str!("../../data/instructions/unseen.jsonl");
/// Maximum size of a file of instructions.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// A split of the built-in instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// For development; may be read.
    Development,
    /// For evaluation; must not be used for development.
    Test,
    /// For evaluation; written from a description of the maps only, independently of the grammar
    /// and of the other instructions.
    Unseen,
}

/// Difficulty of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Difficulty {
    /// Plain addresses in digits.
    Easy,
    /// Lists, numbers as words, required orders, names from the map.
    Medium,
    /// Corrections, numbers that are not addresses, typing errors, ambiguous places.
    Hard,
}

/// An annotated instruction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Unique name.
    #[serde(default)]
    pub id: String,
    /// Language, BCP 47.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub lang: String,
    /// Difficulty, if annotated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difficulty: Option<Difficulty>,
    /// The map that it refers to; without one, no buildings are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapName>,
    /// The instruction.
    pub instruction: String,
    /// The requested doors, each once, by their names on the map; `building<N>` and `unit<N>` where
    /// it has no names.
    pub deliveries: Vec<Address>,
    /// Pairs of indices into `deliveries`: the first must be visited before the second.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<(usize, usize)>,
    /// Whether several places fit, so that the correct plan is one delivery with a question.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ambiguous: bool,
}

impl Case {
    /// The correct plan.
    pub fn expected(&self) -> ExpectedPlan {
        ExpectedPlan {
            doors: self.deliveries.clone(),
            before: self.before.clone(),
        }
    }
}

/// A built-in map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MapName {
    /// Twelve numbered buildings of four units.
    Estate,
    /// Buildings with names in six languages, and with house numbers.
    Town,
}

impl MapName {
    /// Parses the map.
    ///
    /// # Panics
    /// Never: a test parses both.
    pub fn open(self) -> OsmMap {
        let text = match self {
            Self::Estate => ESTATE,
            Self::Town => TOWN,
        };
        let data = OsmData::from_xml(text.as_bytes()).expect("the built-in maps are valid");
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(11.0, 48.0)))
    }
}

/// Instructions that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstructionsError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file, or a line of it, is not JSON in the expected form.
    #[error(
        "{name}:{line} is no instruction; write one JSON object per line, with `instruction` and \
         `deliveries` at least"
    )]
    Json {
        /// Name of the file.
        name: String,
        /// Line number, from 1.
        line: usize,
        /// The error of the parser.
        source: serde_json::Error,
    },
    /// The file is too large.
    #[error("{} is larger than {MAX_FILE_BYTES} bytes; divide it", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// The annotation of an instruction is inconsistent.
    #[error("{place}: {what}")]
    Bad {
        /// File and instruction.
        place: String,
        /// What is wrong, and what to do.
        what: String,
    },
}

/// The built-in instructions of a split.
///
/// ```
/// use openbench_trials::instructions::{Split, built_in};
///
/// let cases = built_in(Split::Development);
/// let german = cases.iter().find(|case| case.lang == "de").unwrap();
/// assert!(!german.instruction.is_empty() && !german.deliveries.is_empty());
/// ```
///
/// # Panics
/// Never: a test reads all splits.
pub fn built_in(split: Split) -> Vec<Case> {
    let files: &[&str] = match split {
        Split::Development => &DEVELOPMENT,
        Split::Test => &TEST,
        Split::Unseen => &[UNSEEN],
    };
    let read = |text: &&str| read_lines(text, "the built-in instructions").expect("they are valid");
    files.iter().flat_map(read).collect()
}

/// Reads the instructions of a file: a JSON list of cases, or one JSON object per line.
///
/// # Errors
/// [`InstructionsError`], with the line.
pub fn read(path: &Path) -> Result<Vec<Case>, InstructionsError> {
    let failed = |source| InstructionsError::Read {
        path: path.into(),
        source,
    };
    if std::fs::metadata(path).map_err(failed)?.len() > MAX_FILE_BYTES {
        return Err(InstructionsError::TooLarge { path: path.into() });
    }
    let text = openbench_core::input::read_text(path).map_err(failed)?;
    let name = path.display().to_string();
    // A line of a file of lines begins with a brace.
    if !text.trim_start().starts_with('[') {
        return read_lines(&text, &name);
    }
    let cases: Vec<Case> =
        serde_json::from_str(&text).map_err(|source| InstructionsError::Json {
            name: name.clone(),
            line: source.line(),
            source,
        })?;
    numbered(cases, |number| format!("{name}, instruction {number}"))
}

fn read_lines(text: &str, name: &str) -> Result<Vec<Case>, InstructionsError> {
    let lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty());
    let cases = lines.map(|(number, line)| {
        serde_json::from_str(line).map_err(|source| InstructionsError::Json {
            name: name.to_owned(),
            line: number,
            source,
        })
    });
    numbered(cases.collect::<Result<_, _>>()?, |number| {
        format!("{name}, instruction {number}")
    })
}

/// Names cases without an id by their number, and rejects inconsistent annotations.
fn numbered(
    mut cases: Vec<Case>,
    place: impl Fn(usize) -> String,
) -> Result<Vec<Case>, InstructionsError> {
    let mut seen = BTreeSet::new();
    for (number, case) in (1..).zip(&mut cases) {
        let bad = |what: String| InstructionsError::Bad {
            place: place(number),
            what,
        };
        if case.id.is_empty() {
            case.id = number.to_string();
        }
        // Wrong plans are listed by the id of their case.
        if !seen.insert(case.id.clone()) {
            return Err(bad(format!("the id `{}` is not unique", case.id)));
        }
        let count = case.deliveries.len();
        if let Some((a, b)) = case
            .before
            .iter()
            .find(|(a, b)| *a >= count || *b >= count || a == b)
        {
            return Err(bad(format!(
                "`before` has the pair {a}, {b}, but must have two different indices below the \
                 number of deliveries, {count}"
            )));
        }
        // An ambiguous instruction has no correct door, and any other has one.
        if case.deliveries.is_empty() != case.ambiguous {
            return Err(bad(
                "give either deliveries, or `ambiguous`: true and no deliveries".to_owned(),
            ));
        }
    }
    Ok(cases)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_osm::{Location, locate};
    use sha2::{Digest, Sha256};

    #[test]
    fn the_doors_of_the_built_in_instructions_are_on_the_map() {
        for (split, by_hand, all) in [
            (Split::Development, 60, 200),
            (Split::Test, 90, 300),
            (Split::Unseen, 0, 200),
        ] {
            let cases = built_in(split);
            assert!(cases.len() >= all, "{}", cases.len());
            assert!(cases.iter().filter(|c| !c.id.contains("made")).count() >= by_hand);
            for case in &cases {
                let map = case.map.expect("a built-in case has a map").open();
                for door in &case.deliveries {
                    let found = locate(&map, door);
                    assert!(
                        matches!(
                            (&found, &door.unit),
                            (Location::Unit { .. }, Some(_)) | (Location::Building(_), None)
                        ),
                        "{}: {door} {found:?}",
                        case.id
                    );
                }
            }
        }
    }

    #[test]
    fn the_evaluation_splits_are_frozen() {
        let sums = include_str!("../../data/instructions/SHA256SUMS");
        let frozen = [
            ("hand-test.jsonl", TEST[0]),
            ("made-test.jsonl", TEST[1]),
            ("unseen.jsonl", UNSEEN),
        ];
        for (name, text) in frozen {
            let sum: String = Sha256::digest(text.as_bytes())
                .iter()
                .map(|b| format!("{b:02x}"))
                .collect();
            assert!(
                sums.contains(&format!("{sum}  {name}\n")),
                "{name} has changed: {sum}"
            );
        }
    }

    #[test]
    fn instructions_are_unique() {
        let mut known = BTreeSet::new();
        let all = [Split::Development, Split::Test, Split::Unseen]
            .into_iter()
            .flat_map(built_in);
        let twice: Vec<Case> = all
            .filter(|case| !known.insert(case.instruction.clone()))
            .collect();
        assert!(twice.is_empty(), "{twice:?}");
    }

    #[test]
    fn errors_in_a_file_are_reported_with_their_place() {
        let problem = |text: &str| read_lines(text, "a.jsonl").unwrap_err().to_string();
        let door = r#"{"building": "building1", "unit": "unit1"}"#;
        assert!(problem("{}").contains("a.jsonl:1"));
        assert!(
            problem(r#"{"instruction": "x", "deliveries": []}"#)
                .contains("instruction 1: give either deliveries")
        );
        let twice = format!(r#"{{"id": "a", "instruction": "x", "deliveries": [{door}]}}"#);
        assert!(problem(&format!("{twice}\n\n{twice}\n")).contains("instruction 2: the id `a`"));
        let order =
            format!(r#"{{"instruction": "x", "deliveries": [{door}], "before": [[0, 1]]}}"#);
        assert!(problem(&order).contains("`before` has the pair 0, 1"));
    }
}
