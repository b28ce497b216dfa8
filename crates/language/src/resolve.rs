//! From what an instruction says to the map's own names, and in words what is wrong where the map lacks a place or has several.
//!
//! Wishes for one door become one stop; a building without a unit is dropped where one of its units is asked for too.

use std::cell::OnceCell;

use openbench_core::{Address, AddressLevel, Deadline, Level};
use openbench_osm::hierarchy::{Above, above, all_above};
use openbench_osm::names::fold_unit;
use openbench_osm::{Location, OsmMap, locate};

use crate::gazetteer::{Alias, Gazetteer, label};
use crate::grammar::text::{condensed, spelt, tokenize};
use crate::wish::{Named, Wish, Wishes};

/// How many of the map's names a problem quotes.
const QUOTED: usize = 8;
/// Numbers from here on are of flats on a floor.
const LEAST_FLAT: usize = 100;
/// A word of a name that tells it from others has so many letters at least.
const SHORTEST_WORD: usize = 3;
/// Where all units would make more stops than these, their building is one stop.
const MOST_STOPS: usize = 200;

/// What is wrong with doors that may not be the sender's.
const DOUBTFUL: &str = "it comes after words that take back what the instruction says before, as a stranger would; say which is meant";

/// What is wrong where the sender is not sure.
const UNSURE: &str = "the sender names several doors and is not sure which; say which is meant";

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
        matches!(self.problem.as_deref(), Some(DOUBTFUL | UNSURE))
    }
}

/// Gives every wish its address on `map`.
pub(crate) fn resolve(wishes: Wishes, map: &OsmMap, gazetteer: &Gazetteer) -> Stops {
    let around = wishes.doors.iter().map(|wish| wish.around.as_str());
    let whole = around.chain([wishes.around_all.as_str()]).collect();
    let surroundings = Surroundings { map, whole, said: OnceCell::new() };
    let all = &wishes.around_all;
    let mut stops = Vec::new();
    // Which stops each wish has become.
    let mut ranges = Vec::with_capacity(wishes.doors.len());
    for wish in wishes.doors {
        let first = stops.len();
        let single = single(wish, MOST_STOPS.saturating_sub(stops.len()), map, gazetteer);
        stops.extend(single.into_iter().map(|wish| stop(wish, all, &surroundings, gazetteer)));
        ranges.push(first..stops.len());
    }
    let pairs = wishes.before.iter().flat_map(|(earlier, later)| {
        let (earlier, later) = (ranges.get(*earlier).cloned(), ranges.get(*later).cloned());
        earlier
            .into_iter()
            .flatten()
            .flat_map(move |a| later.clone().into_iter().flatten().map(move |b| (a, b)))
    });
    let before: Vec<(usize, usize)> = pairs.collect();
    merge(stops, &before)
}

/// A wish for all units of a building as one for each of them that the map has; as one for the building where it has none, or more than `most`.
fn single(wish: Wish, most: usize, map: &OsmMap, gazetteer: &Gazetteer) -> Vec<Wish> {
    let Some(Named::All { but, count, parity }) = &wish.unit else { return vec![wish] };
    let name = building(wish.building.clone(), map, gazetteer).name;
    let is_excepted =
        |unit: &String| but.iter().any(|label| fold_unit(&generic("unit", label)) == fold_unit(unit));
    let all = units_of(&name, map);
    let is_other = count.is_some_and(|count| count != all.len());
    let is_of_parity = |unit: &String| {
        let number = unit.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<usize>();
        parity.is_none_or(|parity| number.is_ok_and(|number| number % 2 == parity))
    };
    let units: Vec<String> =
        all.into_iter().filter(|unit| !is_excepted(unit) && is_of_parity(unit)).collect();
    if is_other || units.is_empty() || units.len() > most {
        return vec![Wish { unit: None, ..wish }];
    }
    let one = |unit: String| Wish { unit: Some(Named::Words(unit)), ..wish.clone() };
    units.into_iter().map(one).collect()
}

/// The units of a building, each once, in the order of their names.
fn units_of(building: &str, map: &OsmMap) -> Vec<String> {
    let Location::Building(building) = locate(map, &Address { building: building.to_owned(), unit: None })
    else {
        return Vec::new();
    };
    // Parts of one multipolygon are one building.
    let element = map.buildings[building].element;
    let is_here = |own: usize| map.buildings[own].element == element;
    let here = map.entrances.iter().filter(|entrance| entrance.building.is_some_and(is_here));
    let mut units: Vec<String> = here.filter_map(|entrance| entrance.units.first().cloned()).collect();
    units.sort_by_key(|unit| (unit.len(), unit.clone()));
    units.dedup_by_key(|unit| fold_unit(unit));
    units
}

/// `all` is what is said of all doors.
fn stop(wish: Wish, all: &str, surroundings: &Surroundings<'_>, gazetteer: &Gazetteer) -> Stop {
    let map = surroundings.map;
    let mut chosen = building(wish.building, map, gazetteer);
    for said in [&wish.around, all] {
        chosen = by_own_words(surroundings.narrow(chosen, said), said, map, gazetteer);
    }
    let Choice { name: building, mut problem, mut confidence, .. } = chosen;
    let mut levels = surroundings.above(&building, &(wish.around + all));
    levels.extend(wish.below);
    let mut unit = wish.unit.map(|unit| unit_name(&unit, &building, map));
    if let Some(room) = unit.take_if(|unit| wish.is_room && is_behind_a_unit(&building, unit, map)) {
        let name = room.strip_prefix("unit").map_or(room.clone(), |label| format!("flat{label}"));
        levels.push(AddressLevel { level: Level::Flat, name });
    }
    if wish.doubtful {
        problem = Some(DOUBTFUL.to_owned());
    } else if wish.unsure {
        problem = Some(UNSURE.to_owned());
    } else if problem.is_none() {
        problem = doubt(&building, map, &mut confidence);
    }
    let items = if wish.item.is_empty() { Vec::new() } else { vec![wish.item] };
    Stop { items, address: Address { building, unit }, confidence, problem, due: wish.due, levels }
}

/// Whether a flat is none of the doors that the map knows of its building: where it knows none, one with a number such as flats have.
fn is_behind_a_unit(building: &str, flat: &str, map: &OsmMap) -> bool {
    if matches!(locate(map, &Address::new(building, flat)), Location::Unit { .. }) {
        return false;
    }
    let number: usize = flat.trim_start_matches("unit").parse().unwrap_or_default();
    number >= LEAST_FLAT || !units_of(building, map).is_empty()
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
        let buildings = buildings_called(&choice.fitting, map);
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
            Some(name) => Choice::sure(name),
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

/// Of several that fit the one of whose names alone a word is said: `the medical centre, the one in the north`.
fn by_own_words(choice: Choice, said: &str, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
    if choice.fitting.len() < 2 {
        return choice;
    }
    let is_of_one = |alias: &&Alias| choice.places.contains(&alias.place);
    let aliases: Vec<&Alias> = gazetteer.aliases.iter().filter(is_of_one).collect();
    let only = |word: Vec<char>| {
        let mut bearers = aliases.iter().filter(|alias| bears(alias, &word)).map(|alias| alias.place);
        let first = bearers.next()?;
        bearers.all(|place| place == first).then_some(first)
    };
    let tokens = tokenize(said);
    let mut told = tokens.iter().filter_map(|token| only(token.text.chars().collect()));
    match told.next() {
        Some(place) if told.all(|other| other == place) => {
            Choice::sure(map_name(&gazetteer.places[place].name, map))
        }
        _ => choice,
    }
}

/// Whether a name begins or ends with a word, or holds a point of the compass.
fn bears(alias: &Alias, word: &[char]) -> bool {
    let is_compass = matches!(word, ['东' | '南' | '西' | '北']);
    let is_end = alias.letters.starts_with(word) || alias.letters.ends_with(word);
    is_compass && alias.letters.contains(&word[0]) || word.len() >= SHORTEST_WORD && is_end
}

/// The buildings of a name.
fn all_of<'a>(name: &'a String, map: &OsmMap) -> Vec<(&'a String, usize)> {
    match locate(map, &Address { building: name.clone(), unit: None }) {
        Location::Ambiguous(all) => all.into_iter().map(|building| (name, building)).collect(),
        Location::Building(building) | Location::Unit { building, .. } => vec![(name, building)],
        Location::Unknown => Vec::new(),
    }
}

/// The buildings of several names, each once; with the name that it has alone, if there is one.
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
    /// The places that bear them: indices into [`Gazetteer::places`].
    places: Vec<usize>,
}

impl Choice {
    /// The only one that can be meant.
    fn sure(name: String) -> Self {
        Self { name, problem: None, confidence: 1.0, fitting: Vec::new(), places: Vec::new() }
    }

    fn none(name: String, problem: String) -> Self {
        Self { name, problem: Some(problem), confidence: 0.0, fitting: Vec::new(), places: Vec::new() }
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
        Some(Named::All { .. }) => nameless(gazetteer),
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
        [only] => Choice::sure(only.name.clone()),
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
    Some(Choice {
        name: first,
        problem: several.then_some(problem),
        confidence,
        fitting: names,
        places: places.to_vec(),
    })
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
        Named::Places { .. } | Named::All { .. } => String::new(),
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
