//! Instructions with right answers: how well planners understand people (SRTP).
//!
//! | module | its one concept |
//! |---|---|
//! | [`mod@made`] | instructions from templates, from a seed |
//! | [`score`] | a planner through all of them |
//!
//! What lies in `data/instructions` is built in: instructions written by hand, made ones, and such as people speak, in three splits. The development split is there to be looked at, and grows; the test split was written before the grammar was changed for it, the unseen one
//! independently of the grammar, and `SHA256SUMS` holds both fixed.

pub mod made;
pub mod score;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use openbench_core::{Address, Georeference, LonLat};
use openbench_osm::{OsmData, OsmMap};
use serde::{Deserialize, Serialize};

use openbench_bench::score::metrics::ExpectedPlan;

const ESTATE: &str = include_str!("../../data/instructions/estate.osm");
const TOWN: &str = include_str!("../../data/instructions/town.osm");
/// By hand, made, and as people speak.
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
/// Files of instructions that are larger are refused, bytes.
const LARGEST: u64 = 64 << 20;

/// Which of the built-in instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// To look at while a planner is written.
    Development,
    /// To measure a planner that was written without it.
    Test,
    /// The same, and written from a description of the maps alone, independent of the grammar and of other instructions.
    Unseen,
}

/// How hard an instruction is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Difficulty {
    /// Plain addresses in digits.
    Easy,
    /// Lists, numbers as words, orders, names from the map.
    Medium,
    /// Corrections, what must not be taken for an address, slips of the pen, more than one place that fits.
    Hard,
}

/// An instruction and its right answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// A name of its own.
    #[serde(default)]
    pub id: String,
    /// Its language, as in BCP 47.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub lang: String,
    /// How hard it is, if somebody says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difficulty: Option<Difficulty>,
    /// The map that it speaks of; none knows no buildings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapName>,
    /// The instruction.
    pub instruction: String,
    /// The doors, each once, by the map's names; `building<N>` and `unit<N>` where it has none.
    pub deliveries: Vec<Address>,
    /// Pairs of positions in `deliveries`: the first must be driven to before the second.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<(usize, usize)>,
    /// Whether several places fit, so that the right answer is one delivery that asks back.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ambiguous: bool,
}

impl Case {
    /// What a plan must hold.
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
    /// The map.
    ///
    /// # Panics
    /// Never: a test reads both.
    pub fn open(self) -> OsmMap {
        let text = match self {
            Self::Estate => ESTATE,
            Self::Town => TOWN,
        };
        let data = OsmData::from_xml(text.as_bytes()).expect("a built-in map can be read");
        OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(11.0, 48.0)))
    }
}

/// Instructions cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum InstructionsError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// The file is too large.
    #[error("{} is larger than {LARGEST} bytes; split it", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// Something in it is no instruction.
    #[error("{place}: {what}")]
    Bad {
        /// File and line.
        place: String,
        /// What is wrong, and what would be right.
        what: String,
    },
}

/// The built-in instructions of a split.
///
/// # Panics
/// Never: a test reads all splits.
pub fn built_in(split: Split) -> Vec<Case> {
    let files: &[&str] = match split {
        Split::Development => &DEVELOPMENT,
        Split::Test => &TEST,
        Split::Unseen => &[UNSEEN],
    };
    let read =
        |text: &&str| read_lines(text, "the built-in instructions").expect("they can be read");
    files.iter().flat_map(read).collect()
}

/// The instructions of a file: a JSON list of cases, or one a line.
///
/// # Errors
/// [`InstructionsError`], with the line.
pub fn read(path: &Path) -> Result<Vec<Case>, InstructionsError> {
    let failed = |source| InstructionsError::Read {
        path: path.into(),
        source,
    };
    if std::fs::metadata(path).map_err(failed)?.len() > LARGEST {
        return Err(InstructionsError::TooLarge { path: path.into() });
    }
    let text = std::fs::read_to_string(path).map_err(failed)?;
    let name = path.display().to_string();
    if !text.trim_start().starts_with('[') {
        return read_lines(&text, &name);
    }
    let cases: Vec<Case> = serde_json::from_str(&text).map_err(|e| InstructionsError::Bad {
        place: format!("{name}:{}", e.line()),
        what: e.to_string(),
    })?;
    numbered(cases, |number| format!("{name}, instruction {number}"))
}

fn read_lines(text: &str, name: &str) -> Result<Vec<Case>, InstructionsError> {
    let lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty());
    let cases = lines.map(|(number, line)| {
        serde_json::from_str(line).map_err(|e| InstructionsError::Bad {
            place: format!("{name}:{number}"),
            what: format!(
                "{e}; write one JSON object a line, with `instruction` and `deliveries` at least"
            ),
        })
    });
    numbered(cases.collect::<Result<_, _>>()?, |number| {
        format!("{name}, instruction {number}")
    })
}

/// Gives a number to whatever has no name, and refuses what cannot be a right answer.
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
        if !seen.insert(case.id.clone()) {
            return Err(bad(format!("the id `{}` is there twice", case.id)));
        }
        let count = case.deliveries.len();
        if let Some((a, b)) = case
            .before
            .iter()
            .find(|(a, b)| *a >= count || *b >= count || a == b)
        {
            return Err(bad(format!(
                "`before` names {a} and {b}, but there are {count} deliveries, from 0"
            )));
        }
        if case.deliveries.is_empty() != case.ambiguous {
            return Err(bad(
                "give the deliveries, or `ambiguous`: true and none".to_owned()
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
    fn the_built_in_instructions_can_be_read_and_their_doors_are_on_the_map() {
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
    fn the_splits_to_measure_with_are_those_that_were_frozen() {
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
    fn no_instruction_is_there_twice() {
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
    fn what_is_wrong_with_a_file_is_told_with_its_place() {
        let told = |text: &str| read_lines(text, "a.jsonl").unwrap_err().to_string();
        let door = r#"{"building": "building1", "unit": "unit1"}"#;
        assert!(told("{}").contains("a.jsonl:1"));
        assert!(
            told(r#"{"instruction": "x", "deliveries": []}"#)
                .contains("instruction 1: give the deliveries")
        );
        let twice = format!(r#"{{"id": "a", "instruction": "x", "deliveries": [{door}]}}"#);
        assert!(told(&format!("{twice}\n\n{twice}\n")).contains("instruction 2: the id `a`"));
        let order =
            format!(r#"{{"instruction": "x", "deliveries": [{door}], "before": [[0, 1]]}}"#);
        assert!(told(&order).contains("`before` names 0 and 1"));
    }
}
