//! The building that an instruction names, by the map's name, or what is wrong with it.

use openbench_core::Address;
use openbench_osm::{Location, OsmMap, locate};

use crate::gazetteer::Gazetteer;
use crate::lexicon::class::Class;
use crate::lexicon::languages::words_of;
use crate::lexicon::tokens::condensed;
use crate::wish::Named;

/// How many of the map's names a problem quotes.
const QUOTED: usize = 8;

/// The fewest letters of a part of a name that stands for the name.
const SHORTEST_PART: usize = 4;

/// A building, by the map's name if it has one.
pub(super) struct Choice {
    pub name: String,
    pub problem: Option<String>,
    pub confidence: f64,
    /// All names on the map that fit.
    pub fitting: Vec<String>,
    /// The places that have them: indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
}

impl Choice {
    /// The only building that can be meant.
    pub(super) fn sure(name: String) -> Self {
        Self {
            name,
            problem: None,
            confidence: 1.0,
            fitting: Vec::new(),
            places: Vec::new(),
        }
    }

    /// A building that the map lacks.
    fn none(name: String, problem: String) -> Self {
        Self {
            name,
            problem: Some(problem),
            confidence: 0.0,
            fitting: Vec::new(),
            places: Vec::new(),
        }
    }

    /// The same for a name that was not said in full, or misspelt; `percent` of its letters are
    /// right.
    fn of_likeness(self, percent: u8) -> Self {
        Self {
            confidence: self.confidence * f64::from(percent) / 100.0,
            ..self
        }
    }
}

/// The problem of a name that the map has more than once; the confidence is divided among the
/// buildings.
pub(super) fn doubt(building: &str, map: &OsmMap, confidence: &mut f64) -> Option<String> {
    let address = Address {
        building: building.to_owned(),
        unit: None,
    };
    match locate(map, &address) {
        Location::Ambiguous(all) => {
            *confidence /= all.len() as f64;
            Some(format!(
                "the map has {} buildings called `{building}`; say which one is meant, for \
                 instance by its street and number",
                all.len()
            ))
        }
        _ => None,
    }
}

/// The building that an instruction names.
pub(super) fn building(named: Option<Named>, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
    match named {
        None | Some(Named::All { .. }) => nameless(gazetteer),
        Some(Named::Places { places, percent }) => {
            match choose(&places, "that name", map, gazetteer) {
                Some(choice) => choice.of_likeness(percent),
                None => Choice::none(String::new(), "no building is named".to_owned()),
            }
        }
        Some(Named::Label { label, said }) => labelled(&label, &said, map, gazetteer),
        Some(Named::Words(words)) => described(words, map, gazetteer),
    }
}

/// The building with a label.
fn labelled(label: &str, said: &str, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
    let choose = |places: &[usize]| choose(places, said, map, gazetteer);
    // `building B8`
    let bare = || choose(gazetteer.labelled(without_letter(label)?));
    // The words as they stand come first: `Tower 3` may be a name of its own beside a `building 3`.
    choose(gazetteer.named(said))
        .or_else(|| choose(gazetteer.labelled(label)))
        .or_else(bare)
        .unwrap_or_else(|| lacking(generic("building", label), said, gazetteer))
}

/// The building of a name, or of a part of one.
fn described(words: String, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
    if let Some(exact) = choose(gazetteer.named(&words), &words, map, gazetteer) {
        return exact;
    }
    let parts = words
        .split_whitespace()
        .map(condensed)
        .filter(|part| !part.is_empty());
    let parts: Vec<String> = parts.collect();
    // Short parts stand inside many names by chance.
    let letters: usize = parts.iter().map(|part| part.chars().count()).sum();
    if letters >= SHORTEST_PART {
        let found = gazetteer.with_parts(&parts);
        if let Some(choice) = choose(&found.places, &words, map, gazetteer) {
            return choice.of_likeness(found.percent);
        }
    }
    lacking(words.clone(), &words, gazetteer)
}

/// A label without the letter that stands for buildings.
fn without_letter(label: &str) -> Option<&str> {
    words_of(Class::BuildingLetter).find_map(|letter| label.strip_prefix(letter))
}

/// The building if the instruction names none: the only one of the map.
fn nameless(gazetteer: &Gazetteer) -> Choice {
    match gazetteer.places.as_slice() {
        [only] => Choice::sure(only.name.clone()),
        _ => Choice::none(
            String::new(),
            "the instruction names a unit but no building; say which building".to_owned(),
        ),
    }
}

/// The only one of `places`, or the first with a problem if there are several; `None` if there is
/// none.
fn choose(places: &[usize], said: &str, map: &OsmMap, gazetteer: &Gazetteer) -> Option<Choice> {
    let mut names: Vec<String> = places
        .iter()
        .map(|i| map_name(&gazetteer.places[*i].name, map))
        .collect();
    let first = names.first()?.clone();
    names.sort();
    names.dedup();
    let several = names.len() > 1;
    let problem = format!(
        "{} buildings on the map fit `{said}`: {}; say which one is meant",
        names.len(),
        quote(names.iter().map(String::as_str))
    );
    // All that fit are equally likely.
    let confidence = 1.0 / names.len() as f64;
    Some(Choice {
        name: first,
        problem: several.then_some(problem),
        confidence,
        fitting: names,
        places: places.to_vec(),
    })
}

/// The name by which the map finds a building: of several in one tag the first that it knows.
pub(super) fn map_name(name: &str, map: &OsmMap) -> String {
    let known = |name: &&str| {
        locate(
            map,
            &Address {
                building: (*name).to_owned(),
                unit: None,
            },
        ) != Location::Unknown
    };
    std::iter::once(name)
        // OSM puts several values into one tag with semicolons.
        .chain(name.split(';').map(str::trim))
        .find(known)
        .unwrap_or(name)
        .to_owned()
}

/// A building that the map lacks, with the names that it has.
fn lacking(name: String, said: &str, gazetteer: &Gazetteer) -> Choice {
    let known = quote(gazetteer.places.iter().map(|place| place.name.as_str()));
    let known = if known.is_empty() {
        "it names no building at all".to_owned()
    } else {
        format!("it has {known}")
    };
    Choice::none(name, format!("the map has no building `{said}`; {known}"))
}

/// The first of some names, and how many more there are.
fn quote<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let mut text = names
        .iter()
        .take(QUOTED)
        .copied()
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > QUOTED {
        text.push_str(&format!(" and {} more", names.len() - QUOTED));
    }
    text
}

/// `building3`, `buildingA`, `unit12A`.
pub(super) fn generic(level: &str, label: &str) -> String {
    format!("{level}{}", label.to_uppercase())
}
