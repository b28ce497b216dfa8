//! From what an instruction says to the map's own names, and in words what is wrong where the map lacks a place or has several.
//!
//! Wishes for one door become one stop; a building without a unit is dropped where one of its units is asked for too.

use std::cell::OnceCell;

use openbench_core::{Address, AddressLevel, Deadline};
use openbench_osm::hierarchy::{Above, above, all_above};
use openbench_osm::names::fold_unit;
use openbench_osm::{Location, OsmMap, locate};

use crate::gazetteer::{Gazetteer, label};
use crate::grammar::text::{condensed, spelt};
use crate::wish::{Named, Wish, Wishes};

/// How many of the map's names a problem quotes.
const QUOTED: usize = 8;

/// What is wrong with doors that may not be the sender's.
const DOUBTFUL: &str = "it comes after words that take back what the instruction says before, as a stranger would; say which is meant";

/// A door with its name, or with what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stop {
    pub items: Vec<String>,
    pub address: Address,
    /// How surely the building is the one that is meant, 0 to 1.
    pub confidence: f64,
    pub problem: Option<String>,
    /// Until when; the soonest of several.
    pub due: Option<Deadline>,
    /// The levels above the building and below the unit that are said.
    pub levels: Vec<AddressLevel>,
}

/// The stops in the order of the instruction, and which must come before which.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Stops {
    pub stops: Vec<Stop>,
    /// Pairs (earlier, later) of indices into `stops`.
    pub before: Vec<(usize, usize)>,
}

impl Stop {
    /// Whether these may be the words of somebody else than the sender.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.problem.as_deref() == Some(DOUBTFUL)
    }
}

/// Gives every wish its address on `map`.
pub(crate) fn resolve(wishes: Wishes, map: &OsmMap, gazetteer: &Gazetteer) -> Stops {
    let around = wishes.doors.iter().map(|wish| wish.around.as_str());
    let whole = around.chain([wishes.around_all.as_str()]).collect();
    let surroundings = Surroundings { map, whole, said: OnceCell::new() };
    let all = &wishes.around_all;
    let stops = wishes.doors.into_iter().map(|wish| stop(wish, all, &surroundings, gazetteer)).collect();
    merge(stops, &wishes.before)
}

/// `all` is what is said of all doors.
fn stop(wish: Wish, all: &str, surroundings: &Surroundings<'_>, gazetteer: &Gazetteer) -> Stop {
    let map = surroundings.map;
    let mut chosen = building(wish.building, map, gazetteer);
    for said in [&wish.around, all] {
        chosen = surroundings.narrow(chosen, said);
    }
    let Choice { name: building, mut problem, mut confidence, .. } = chosen;
    let mut levels = surroundings.above(&building, &(wish.around + all));
    levels.extend(wish.below);
    let unit = wish.unit.map(|unit| unit_name(&unit, &building, map));
    if wish.doubtful {
        problem = Some(DOUBTFUL.to_owned());
    } else if problem.is_none() {
        problem = doubt(&building, map, &mut confidence);
    }
    let items = if wish.item.is_empty() { Vec::new() } else { vec![wish.item] };
    Stop { items, address: Address { building, unit }, confidence, problem, due: wish.due, levels }
}

/// The streets, quarters and towns of the map that an instruction speaks of. They are looked for when they are asked for.
struct Surroundings<'a> {
    map: &'a OsmMap,
    /// All that is said around doors.
    whole: String,
    said: OnceCell<Vec<Above>>,
}

impl Surroundings<'_> {
    fn said(&self) -> &[Above] {
        let is_meant = |above: &Above| is_said(&above.level, &self.whole);
        self.said.get_or_init(|| all_above(self.map).into_iter().filter(is_meant).collect())
    }

    /// Of several that fit the one whose street, quarter or town is said, if it is the only one.
    fn narrow(&self, choice: Choice, said: &str) -> Choice {
        let map = self.map;
        let buildings: Vec<(&String, usize)> =
            choice.fitting.iter().flat_map(|name| all_of(name, map)).collect();
        if buildings.len() < 2 {
            return choice;
        }
        let here: Vec<&Above> = self.said().iter().filter(|above| is_said(&above.level, said)).collect();
        let count = |b: usize| here.iter().filter(|above| above.holds(map, b)).count();
        let counts: Vec<usize> = buildings.iter().map(|(_, b)| count(*b)).collect();
        let most = counts.iter().copied().max().unwrap_or_default();
        let mut there = buildings.iter().zip(&counts).filter(|(_, count)| **count == most);
        let (Some(((name, building), _)), None) = (there.next(), there.next()) else { return choice };
        let within: Vec<&str> = here
            .iter()
            .filter(|above| above.holds(map, *building))
            .map(|above| above.level.name.as_str())
            .collect();
        let longer = within.iter().map(|level| format!("{name}, {level}"));
        let longest = format!("{name}, {}", within.join(", "));
        let names = std::iter::once((*name).clone()).chain(longer).chain([longest]);
        match names.into_iter().find(|name| matches!(all_of(name, map)[..], [_])) {
            Some(name) => Choice { name, problem: None, confidence: 1.0, fitting: Vec::new() },
            None => choice,
        }
    }

    /// The levels above a building that are said; where the map lacks the building, those that are said around its door.
    fn above(&self, building: &str, around: &str) -> Vec<AddressLevel> {
        let own = match locate(self.map, &Address { building: building.to_owned(), unit: None }) {
            Location::Building(building) | Location::Unit { building, .. } => above(self.map, building),
            Location::Unknown => {
                let said = self.said().iter().filter(|above| is_said(&above.level, around));
                return said.map(|above| above.level.clone()).collect();
            }
            Location::Ambiguous(_) => return Vec::new(),
        };
        own.into_iter().filter(|level| is_said(level, around)).collect()
    }
}

/// The buildings of a name.
fn all_of<'a>(name: &'a String, map: &OsmMap) -> Vec<(&'a String, usize)> {
    match locate(map, &Address { building: name.clone(), unit: None }) {
        Location::Ambiguous(all) => all.into_iter().map(|building| (name, building)).collect(),
        Location::Building(building) | Location::Unit { building, .. } => vec![(name, building)],
        Location::Unknown => Vec::new(),
    }
}

/// Whether the name of a level stands in what is said. A number alone is none: it is that of a building, a telephone, a weight.
fn is_said(level: &AddressLevel, said: &str) -> bool {
    let is_name = level.name.chars().filter(|c| c.is_alphabetic()).nth(1).is_some();
    is_name && said.contains(&spelt(&level.name))
}

/// What speaks against a name that was chosen: the map has it twice.
fn doubt(building: &str, map: &OsmMap, confidence: &mut f64) -> Option<String> {
    let address = Address { building: building.to_owned(), unit: None };
    match locate(map, &address) {
        Location::Ambiguous(all) => {
            *confidence /= all.len() as f64;
            Some(format!(
                "the map has {} buildings called `{building}`; say which one is meant, for instance by its street and number",
                all.len()
            ))
        }
        _ => None,
    }
}

/// A building that is meant, by the map's name where it has one.
struct Choice {
    name: String,
    problem: Option<String>,
    confidence: f64,
    /// All names on the map that fit.
    fitting: Vec<String>,
}

impl Choice {
    fn none(name: String, problem: String) -> Self {
        Self { name, problem: Some(problem), confidence: 0.0, fitting: Vec::new() }
    }

    /// For a name that was not said in full, or misspelt.
    fn of_likeness(self, percent: u8) -> Self {
        Self { confidence: self.confidence * f64::from(percent) / 100.0, ..self }
    }
}

fn building(named: Option<Named>, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
    match named {
        None => nameless(gazetteer),
        Some(Named::Places { places, percent }) => choose(&places, "that name", map, gazetteer)
            .map(|choice| choice.of_likeness(percent))
            .unwrap_or_else(|| Choice::none(String::new(), "no building is named".to_owned())),
        Some(Named::Label { label, said }) => {
            let exact = choose(gazetteer.named(&said), &said, map, gazetteer);
            let labelled = || choose(gazetteer.labelled(&label), &said, map, gazetteer);
            // `building B8`
            let bare = || choose(gazetteer.labelled(label.strip_prefix('b')?), &said, map, gazetteer);
            exact
                .or_else(labelled)
                .or_else(bare)
                .unwrap_or_else(|| lacking(generic("building", &label), &said, gazetteer))
        }
        Some(Named::Words(words)) => {
            let said: Vec<String> =
                words.split_whitespace().map(condensed).filter(|w| !w.is_empty()).collect();
            let exact = choose(gazetteer.named(&words), &words, map, gazetteer);
            let partly = || {
                let long = said.iter().map(|w| w.chars().count()).sum::<usize>() >= 4;
                let (places, percent) = long.then(|| gazetteer.with_parts(&said))?;
                Some(choose(&places, &words, map, gazetteer)?.of_likeness(percent))
            };
            exact.or_else(partly).unwrap_or_else(|| lacking(words.clone(), &words, gazetteer))
        }
    }
}

/// The instruction names no building: the only one is meant.
fn nameless(gazetteer: &Gazetteer) -> Choice {
    match gazetteer.places.as_slice() {
        [only] => Choice { name: only.name.clone(), problem: None, confidence: 1.0, fitting: Vec::new() },
        _ => Choice::none(
            String::new(),
            "the instruction names a unit but no building; say which building".to_owned(),
        ),
    }
}

/// The only one of `places`, or the first with a problem if there are several; `None` if there is none.
fn choose(places: &[usize], said: &str, map: &OsmMap, gazetteer: &Gazetteer) -> Option<Choice> {
    let mut names: Vec<String> = places.iter().map(|i| map_name(&gazetteer.places[*i].name, map)).collect();
    let first = names.first()?.clone();
    names.sort();
    names.dedup();
    let several = names.len() > 1;
    let problem = format!(
        "{} buildings on the map fit `{said}`: {}; say which one is meant",
        names.len(),
        quote(names.iter().map(String::as_str))
    );
    let confidence = 1.0 / names.len() as f64;
    Some(Choice { name: first, problem: several.then_some(problem), confidence, fitting: names })
}

/// What the map calls a building so that it can be looked up: the first of several names in one tag.
fn map_name(name: &str, map: &OsmMap) -> String {
    let known =
        |name: &&str| locate(map, &Address { building: (*name).to_owned(), unit: None }) != Location::Unknown;
    std::iter::once(name).chain(name.split(';').map(str::trim)).find(known).unwrap_or(name).to_owned()
}

fn lacking(name: String, said: &str, gazetteer: &Gazetteer) -> Choice {
    let known = quote(gazetteer.places.iter().map(|place| place.name.as_str()));
    let known =
        if known.is_empty() { "it names no building at all".to_owned() } else { format!("it has {known}") };
    Choice::none(name, format!("the map has no building `{said}`; {known}"))
}

fn quote<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let mut text = names.iter().take(QUOTED).copied().collect::<Vec<_>>().join(", ");
    if names.len() > QUOTED {
        text.push_str(&format!(" and {} more", names.len() - QUOTED));
    }
    text
}

/// `building3`, `buildingA`, `unit12A`.
fn generic(level: &str, label: &str) -> String {
    format!("{level}{}", label.to_uppercase())
}

/// What the map calls the unit, else `unit<N>`.
fn unit_name(unit: &Named, building: &str, map: &OsmMap) -> String {
    let name = match unit {
        Named::Label { label, .. } => generic("unit", label),
        Named::Words(words) => match label(words) {
            short if !short.is_empty() && short.chars().all(|c| c.is_ascii_digit()) => {
                generic("unit", &short)
            }
            _ => words.clone(),
        },
        Named::Places { .. } => String::new(),
    };
    let address = Address::new(building, name.clone());
    let Location::Unit { entrance, .. } = locate(map, &address) else { return name };
    let own = map.entrances[entrance].units.iter().find(|own| fold_unit(own) == fold_unit(&name));
    own.cloned().unwrap_or(name)
}

/// One stop a door; a whole building gives way to its units.
fn merge(stops: Vec<Stop>, before: &[(usize, usize)]) -> Stops {
    let mut merged: Vec<Stop> = Vec::new();
    let mut place = Vec::with_capacity(stops.len());
    let units_of = |stop: &Stop| {
        let same =
            |other: &&Stop| other.address.unit.is_some() && same_building(&stop.address, &other.address);
        stops.iter().find(same).map(|other| other.address.clone())
    };
    let addresses: Vec<Address> = stops
        .iter()
        .map(|stop| match (&stop.address.unit, units_of(stop)) {
            (None, Some(unit)) => unit,
            _ => stop.address.clone(),
        })
        .collect();
    for (stop, address) in stops.into_iter().zip(addresses) {
        let known = merged.iter().position(|m| m.address.same_door(&address));
        let at = known.unwrap_or_else(|| {
            let (problem, levels) = (stop.problem.clone(), stop.levels.clone());
            let confidence = stop.confidence;
            merged.push(Stop { items: Vec::new(), address, confidence, problem, due: None, levels });
            merged.len() - 1
        });
        let new_items: Vec<String> =
            stop.items.into_iter().filter(|item| !merged[at].items.contains(item)).collect();
        merged[at].items.extend(new_items);
        merged[at].confidence = merged[at].confidence.max(stop.confidence);
        merged[at].due = merged[at].due.into_iter().chain(stop.due).min();
        place.push(at);
    }
    let pairs = before.iter().filter_map(|(a, b)| Some((*place.get(*a)?, *place.get(*b)?)));
    Stops { before: pairs.filter(|(a, b)| a != b).collect(), stops: merged }
}

fn same_building(a: &Address, b: &Address) -> bool {
    let whole = |a: &Address| Address { building: a.building.clone(), unit: None };
    whole(a).same_door(&whole(b))
}
