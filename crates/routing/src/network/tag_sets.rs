//! The tags that routing may ask for, and names, each kept once.

use std::collections::HashMap;
use std::rc::Rc;

use openbench_osm::Tags;
use openbench_osm::visitor::{TagRef, TagsRef};

use crate::store::Column;

/// Keys that inform people and no profile, together with all their subkeys behind a colon.
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

/// The namespace of our own keys, which no map may use.
const OWN_NAMESPACE: &str = "openbench";

fn is_information(key: &str) -> bool {
    let stem = key.split_once(':').map_or(key, |(stem, _)| stem);
    stem == OWN_NAMESPACE || INFORMATION.contains(&stem) || MORE_INFORMATION.contains(&stem)
}

/// Separators after a key and after a value. Tags that contain one of them are ignored: only maps
/// made to be hostile have them.
const SEPARATORS: [char; 2] = ['\u{1e}', '\u{1f}'];

/// Texts by number, in one piece: a country has hundreds of thousands.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Texts {
    /// All texts, one after another.
    pub(crate) bytes: Column<u8>,
    /// The end of each text.
    pub(crate) ends: Column<u32>,
}

impl Texts {
    fn get(&self, number: u32) -> &str {
        let number = number as usize;
        let begin = number
            .checked_sub(1)
            .and_then(|before| self.ends.get(before))
            .copied()
            .unwrap_or_default();
        let range = begin as usize..self.ends.get(number).copied().unwrap_or_default() as usize;
        // Texts of a file were validated when it was opened.
        self.bytes
            .get(range)
            .and_then(|bytes| std::str::from_utf8(bytes).ok())
            .unwrap_or_default()
    }

    /// Whether all are UTF-8, one after the other.
    pub(crate) fn are_whole(&self) -> bool {
        let ends = self.ends.iter().map(|end| *end as usize);
        let begins = std::iter::once(0).chain(ends.clone());
        let texts = begins.zip(ends).all(|(begin, end)| {
            self.bytes
                .get(begin..end)
                .is_some_and(|bytes| std::str::from_utf8(bytes).is_ok())
        });
        texts && self.ends.last().map_or(0, |end| *end as usize) == self.bytes.len()
    }
}

impl<'a> FromIterator<&'a str> for Texts {
    fn from_iter<I: IntoIterator<Item = &'a str>>(texts: I) -> Self {
        let (mut bytes, mut ends) = (Vec::new(), Vec::new());
        for text in texts {
            bytes.extend_from_slice(text.as_bytes());
            ends.push(bytes.len() as u32);
        }
        Self {
            bytes: bytes.into(),
            ends: ends.into(),
        }
    }
}

/// Sets of tags by number. Number 0 is the empty set.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct TagSets(pub(crate) Texts);

impl TagSets {
    /// The number of sets.
    pub(crate) fn len(&self) -> usize {
        self.0.ends.len()
    }

    /// The tags of a set; none, if there is no such set.
    pub(crate) fn get(&self, number: u32) -> Tags {
        self.tags(number).map(|tag| (tag.key, tag.value)).collect()
    }

    /// All sets in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Tags> + '_ {
        (0..self.len() as u32).map(|number| self.get(number))
    }

    /// Whether a set has `key` with exactly this `value`.
    pub(crate) fn is(&self, number: u32, key: &str, value: &str) -> bool {
        self.tags(number).any(|tag| tag == TagRef { key, value })
    }

    fn tags(&self, number: u32) -> impl Iterator<Item = TagRef<'_>> {
        tags(self.0.get(number))
    }
}

/// The tags of an encoded set.
fn tags(set: &str) -> impl Iterator<Item = TagRef<'_>> {
    let pairs = set
        .split_terminator(SEPARATORS[1])
        .filter_map(|tag| tag.split_once(SEPARATORS[0]));
    pairs.map(|(key, value)| TagRef { key, value })
}

/// Texts while they are collected, each once.
#[derive(Debug, Default)]
struct Collected {
    numbers: HashMap<Rc<str>, u32>,
    texts: Vec<Rc<str>>,
}

impl Collected {
    fn number(&mut self, text: &str) -> u32 {
        if let Some(&number) = self.numbers.get(text) {
            return number;
        }
        let (text, number): (Rc<str>, _) = (text.into(), self.texts.len() as u32);
        self.numbers.insert(text.clone(), number);
        self.texts.push(text);
        number
    }

    fn into_texts(self) -> Texts {
        self.texts.iter().map(|text| &**text).collect()
    }
}

/// Sets of tags while they are collected.
#[derive(Debug)]
pub(super) struct Classes {
    sets: Collected,
    text: String,
}

impl Classes {
    pub(super) fn new() -> Self {
        let mut sets = Collected::default();
        // The empty set becomes number 0.
        sets.number("");
        Self {
            sets,
            text: String::new(),
        }
    }

    /// The number of the set of those tags that a profile may ask for, together with `more`.
    pub(super) fn number(&mut self, tags: TagsRef<'_>, more: Option<TagRef<'_>>) -> u32 {
        let relevant = tags
            .0
            .iter()
            .copied()
            .filter(|tag| !is_information(tag.key));
        let mut kept: Vec<TagRef<'_>> = relevant.chain(more).collect();
        kept.retain(|tag| !tag.key.contains(SEPARATORS) && !tag.value.contains(SEPARATORS));
        // Sets that differ in the order of tags alone are one set. The sort is stable: of a key
        // that appears twice, the later value stays behind, and counts in `Tags`.
        kept.sort_by_key(|tag| tag.key);
        self.text.clear();
        for tag in &kept {
            self.text.push_str(tag.key);
            self.text.push(SEPARATORS[0]);
            self.text.push_str(tag.value);
            self.text.push(SEPARATORS[1]);
        }
        self.sets.number(&self.text)
    }

    /// The number of a set with one more tag.
    pub(super) fn with(&mut self, class: u32, more: TagRef<'_>) -> u32 {
        let set = self.sets.texts[class as usize].clone();
        let tags: Vec<TagRef<'_>> = tags(&set).collect();
        self.number(TagsRef(&tags), Some(more))
    }

    pub(super) fn into_sets(self) -> TagSets {
        TagSets(self.sets.into_texts())
    }
}

/// The name of a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RoadName<'a> {
    /// `name`, empty if it has none.
    pub name: &'a str,
    /// `ref`, the road's number, empty if it has none.
    pub reference: &'a str,
}

/// Names of roads by number. Number 0 is no name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RoadNames(pub(crate) Texts);

impl RoadNames {
    /// The number of names.
    pub fn len(&self) -> usize {
        self.0.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.ends.is_empty()
    }

    /// A name; no name, if there is no such number.
    pub fn get(&self, number: u32) -> RoadName<'_> {
        let (name, reference) = self
            .0
            .get(number)
            .split_once(SEPARATORS[0])
            .unwrap_or_default();
        RoadName { name, reference }
    }
}

/// Names while they are collected.
#[derive(Debug)]
pub(super) struct Names {
    names: Collected,
    text: String,
}

impl Names {
    pub(super) fn new() -> Self {
        let mut names = Collected::default();
        // No name and no reference, which `number` encodes like this, become number 0.
        names.number(&SEPARATORS[0].to_string());
        Self {
            names,
            text: String::new(),
        }
    }

    /// The number of the name and the reference of a road with these tags.
    pub(super) fn number(&mut self, tags: TagsRef<'_>) -> u32 {
        self.text.clear();
        self.text.push_str(readable(tags, "name"));
        self.text.push(SEPARATORS[0]);
        self.text.push_str(readable(tags, "ref"));
        self.names.number(&self.text)
    }

    pub(super) fn into_names(self) -> RoadNames {
        RoadNames(self.names.into_texts())
    }
}

/// The value of a key, empty if there is none or it contains a separator.
fn readable<'a>(tags: TagsRef<'a>, key: &str) -> &'a str {
    tags.get(key)
        .filter(|value| !value.contains(SEPARATORS))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_kept_once_and_found_again() {
        let mut classes = Classes::new();
        let tags = [
            TagRef::new("surface", "sett"),
            TagRef::new("highway", "path"),
            TagRef::new("name", "Elm Path"),
            TagRef::new("odd", "a\u{1f}b"),
        ];
        let one = classes.number(TagsRef(&tags), None);
        let same = classes.number(TagsRef(&tags[..2]), None);
        let other = classes.number(
            TagsRef(&tags[..1]),
            Some(TagRef::new("openbench:crossing", "yes")),
        );
        assert_eq!(
            [one, same, other, classes.number(TagsRef(&[]), None)],
            [1, 1, 2, 0]
        );
        let sets = classes.into_sets();
        assert_eq!(sets.len(), 3);
        assert_eq!(sets.get(0), Tags::new());
        assert_eq!(
            sets.get(1),
            Tags::from_iter([("highway", "path"), ("surface", "sett")])
        );
        assert!(sets.is(2, "surface", "sett") && sets.is(2, "openbench:crossing", "yes"));
        assert!(!sets.is(1, "surface", "asphalt") && sets.get(99) == Tags::new());
        assert!(sets.0.are_whole());
    }

    #[test]
    fn roads_without_a_name_have_number_zero() {
        let mut names = Names::new();
        let number = |names: &mut Names, tags: &[TagRef<'_>]| names.number(TagsRef(tags));
        assert_eq!(number(&mut names, &[]), 0);
        assert_eq!(number(&mut names, &[TagRef::new("ref", "N 14")]), 1);
        assert_eq!(number(&mut names, &[TagRef::new("name", "Elm Path")]), 2);
        let names = names.into_names();
        assert_eq!((names.len(), names.get(0)), (3, RoadName::default()));
        assert_eq!(
            names.get(1),
            RoadName {
                name: "",
                reference: "N 14"
            }
        );
        assert_eq!(
            names.get(2),
            RoadName {
                name: "Elm Path",
                reference: ""
            }
        );
    }
}
