//! From what an instruction says to the map's own names, and to a problem in words where the map
//! lacks a place or has several.
//!
//! Wishes for one door become one stop. A building without a unit gives way to its units, if one of
//! them is asked for too.

use std::cell::OnceCell;
use std::ops::Range;

use openbench_core::{Address, AddressLevel, Deadline, Level};
use openbench_osm::hierarchy::{Above, above, all_above};
use openbench_osm::names::fold_unit;
use openbench_osm::{Location, OsmMap, locate};

use crate::gazetteer::{Alias, Gazetteer, label};
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::languages::{has_feature, words_of};
use crate::lexicon::tokens::{condensed, spelt, tokenize};
use crate::wish::{Named, Precedes, Wish, Wishes};

/// How many of the map's names a problem quotes.
const QUOTED: usize = 8;
/// The lowest number of a flat, if nothing else tells flats from entrances: 101 is on a floor.
const LEAST_FLAT: usize = 100;
/// The shortest word that tells one name from others, in letters.
const SHORTEST_WORD: usize = 3;
/// The most stops of a plan that all units of a building may add up to; with more, the building is
/// one stop.
const MOST_STOPS: usize = 200;
/// The fewest letters of a part of a name that stands for the name.
const SHORTEST_PART: usize = 4;

/// The problem of doors that may not be the sender's.
const DOUBTFUL: &str = "it comes after words that take back what the instruction says before, as \
                        a stranger would; say which is meant";

/// The problem of a door if the sender is not sure.
const UNSURE: &str = "the sender names several doors and is not sure which; say which is meant";

/// A door with the map's name for it, or with what is wrong.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stop {
    pub items: Vec<String>,
    pub address: Address,
    /// How certain it is that this building is meant, 0 to 1.
    pub confidence: f64,
    pub problem: Option<String>,
    /// The deadline; the soonest of several.
    pub due: Option<Deadline>,
    /// The levels above the building and below the unit that the instruction names.
    pub levels: Vec<AddressLevel>,
}

/// The stops in the order of the instruction, and which must come before which.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Stops {
    pub stops: Vec<Stop>,
    /// Orders among `stops`.
    pub before: Vec<Precedes>,
}

impl Stop {
    /// Whether the sender may not have asked for this door.
    pub(crate) fn is_doubtful(&self) -> bool {
        matches!(self.problem.as_deref(), Some(DOUBTFUL | UNSURE))
    }
}

/// Gives every wish its address on `map`.
pub(crate) fn resolve(wishes: Wishes, map: &OsmMap, gazetteer: &Gazetteer) -> Stops {
    let around = wishes.doors.iter().map(|wish| wish.around.as_str());
    let whole = around.chain([wishes.around_all.as_str()]).collect();
    let surroundings = Surroundings {
        map,
        whole,
        said: OnceCell::new(),
    };
    let all = &wishes.around_all;
    let mut stops = Vec::new();
    // The stops that each wish has become.
    let mut ranges = Vec::with_capacity(wishes.doors.len());
    for wish in wishes.doors {
        let first = stops.len();
        let single = single(wish, MOST_STOPS.saturating_sub(stops.len()), map, gazetteer);
        stops.extend(
            single
                .into_iter()
                .map(|wish| stop(wish, all, &surroundings, gazetteer)),
        );
        ranges.push(first..stops.len());
    }
    let before: Vec<Precedes> = wishes
        .before
        .iter()
        .flat_map(|order| orders_of_stops(*order, &ranges))
        .collect();
    merge(stops, &before)
}

/// The order of two wishes as orders of the stops that they have become.
fn orders_of_stops(order: Precedes, ranges: &[Range<usize>]) -> Vec<Precedes> {
    let (Some(before), Some(behind)) = (ranges.get(order.earlier), ranges.get(order.later)) else {
        return Vec::new();
    };
    let with = |earlier: usize| behind.clone().map(move |later| Precedes { earlier, later });
    before.clone().flat_map(with).collect()
}

/// A wish for all units of a building as one wish for each unit that the map has. If the map has
/// none, another number than the instruction says, or more than `most`, it is one for the building.
fn single(wish: Wish, most: usize, map: &OsmMap, gazetteer: &Gazetteer) -> Vec<Wish> {
    let Some(Named::All { but, count, parity }) = &wish.unit else {
        return vec![wish];
    };
    let name = building(wish.building.clone(), map, gazetteer).name;
    let is_excepted = |unit: &String| {
        but.iter()
            .any(|label| fold_unit(&generic("unit", label)) == fold_unit(unit))
    };
    let all = units_of(&name, map);
    let is_other = count.is_some_and(|count| count != all.len());
    let is_of_parity = |unit: &String| parity.is_none_or(|parity| has_parity(unit, parity));
    let units: Vec<String> = all
        .into_iter()
        .filter(|unit| !is_excepted(unit) && is_of_parity(unit))
        .collect();
    if is_other || units.is_empty() || units.len() > most {
        return vec![Wish { unit: None, ..wish }];
    }
    let one = |unit: String| Wish {
        unit: Some(Named::Words(unit)),
        ..wish.clone()
    };
    units.into_iter().map(one).collect()
}

/// Whether the number of a unit has a remainder divided by two.
fn has_parity(unit: &str, parity: usize) -> bool {
    let digits = unit.trim_start_matches(|c: char| !c.is_ascii_digit());
    digits
        .parse::<usize>()
        .is_ok_and(|number| number % 2 == parity)
}

/// The units of a building, each once, in the order of their names.
fn units_of(building: &str, map: &OsmMap) -> Vec<String> {
    let Location::Building(building) = locate(
        map,
        &Address {
            building: building.to_owned(),
            unit: None,
        },
    ) else {
        return Vec::new();
    };
    // Parts of one multipolygon are one building.
    let element = map.buildings[building].element;
    let is_here = |own: usize| map.buildings[own].element == element;
    let here = map
        .entrances
        .iter()
        .filter(|entrance| entrance.building.is_some_and(is_here));
    let mut units: Vec<String> = here
        .filter_map(|entrance| entrance.units.first().cloned())
        .collect();
    units.sort_by_key(|unit| (unit.len(), unit.clone()));
    units.dedup_by_key(|unit| fold_unit(unit));
    units
}

/// The stop of a wish; `all` is what is said of all doors.
fn stop(wish: Wish, all: &str, surroundings: &Surroundings<'_>, gazetteer: &Gazetteer) -> Stop {
    let map = surroundings.map;
    let mut chosen = building(wish.building, map, gazetteer);
    for said in [&wish.around, all] {
        chosen = by_own_words(surroundings.narrow(chosen, said), said, map, gazetteer);
    }
    let Choice {
        name: building,
        mut problem,
        mut confidence,
        ..
    } = chosen;
    let mut levels = surroundings.above(&building, &(wish.around + all));
    levels.extend(wish.below);
    let mut unit = wish.unit.map(|unit| unit_name(&unit, &building, map));
    if let Some(room) = unit.take_if(|unit| wish.is_room && is_behind_a_unit(&building, unit, map))
    {
        let name = room
            .strip_prefix("unit")
            .map_or(room.clone(), |label| format!("flat{label}"));
        levels.push(AddressLevel {
            level: Level::Flat,
            name,
        });
    }
    if wish.doubtful {
        problem = Some(DOUBTFUL.to_owned());
    } else if wish.unsure {
        problem = Some(UNSURE.to_owned());
    } else if problem.is_none() {
        problem = doubt(&building, map, &mut confidence);
    }
    let items = if wish.item.is_empty() {
        Vec::new()
    } else {
        vec![wish.item]
    };
    Stop {
        items,
        address: Address { building, unit },
        confidence,
        problem,
        due: wish.due,
        levels,
    }
}

/// Whether a flat is behind an entrance: the map does not know it as a door of its building, and
/// knows other doors, or the number is one that flats have.
fn is_behind_a_unit(building: &str, flat: &str, map: &OsmMap) -> bool {
    if matches!(
        locate(map, &Address::new(building, flat)),
        Location::Unit { .. }
    ) {
        return false;
    }
    let number: usize = flat.trim_start_matches("unit").parse().unwrap_or_default();
    number >= LEAST_FLAT || !units_of(building, map).is_empty()
}

/// The streets, quarters and towns of the map that an instruction names, searched on first use.
struct Surroundings<'a> {
    map: &'a OsmMap,
    /// All that is said around doors, [`spelt`].
    whole: String,
    said: OnceCell<Vec<Above>>,
}

impl Surroundings<'_> {
    fn said(&self) -> &[Above] {
        let is_meant = |above: &Above| is_said(&above.level, &self.whole);
        self.said
            .get_or_init(|| all_above(self.map).into_iter().filter(is_meant).collect())
    }

    /// Of several buildings that fit, the one whose street, quarter or town is said, if it is the
    /// only one.
    fn narrow(&self, choice: Choice, said: &str) -> Choice {
        let map = self.map;
        let buildings = buildings_called(&choice.fitting, map);
        if buildings.len() < 2 {
            return choice;
        }
        let here: Vec<&Above> = self
            .said()
            .iter()
            .filter(|above| is_said(&above.level, said))
            .collect();
        let count = |b: usize| here.iter().filter(|above| above.holds(map, b)).count();
        let counts: Vec<usize> = buildings.iter().map(|(_, b)| count(*b)).collect();
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
    fn above(&self, building: &str, around: &str) -> Vec<AddressLevel> {
        let own = match locate(
            self.map,
            &Address {
                building: building.to_owned(),
                unit: None,
            },
        ) {
            Location::Building(building) | Location::Unit { building, .. } => {
                above(self.map, building)
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
fn by_own_words(choice: Choice, said: &str, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
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
    is_name && said.contains(&spelt(&level.name))
}

/// The problem of a name that the map has more than once; the confidence is divided among the
/// buildings.
fn doubt(building: &str, map: &OsmMap, confidence: &mut f64) -> Option<String> {
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

/// A building, by the map's name if it has one.
struct Choice {
    name: String,
    problem: Option<String>,
    confidence: f64,
    /// All names on the map that fit.
    fitting: Vec<String>,
    /// The places that have them: indices into [`Gazetteer::places`].
    places: Vec<usize>,
}

impl Choice {
    /// The only building that can be meant.
    fn sure(name: String) -> Self {
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

/// The building that an instruction names.
fn building(named: Option<Named>, map: &OsmMap, gazetteer: &Gazetteer) -> Choice {
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
fn map_name(name: &str, map: &OsmMap) -> String {
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
fn generic(level: &str, label: &str) -> String {
    format!("{level}{}", label.to_uppercase())
}

/// The map's name of a unit, else `unit<N>`.
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
    let Location::Unit { entrance, .. } = locate(map, &address) else {
        return name;
    };
    let own = map.entrances[entrance]
        .units
        .iter()
        .find(|own| fold_unit(own) == fold_unit(&name));
    own.cloned().unwrap_or(name)
}

/// The address of a stop; for a whole building that of its first unit among all stops.
fn door_of(stop: &Stop, stops: &[Stop]) -> Address {
    let is_unit = |other: &&Stop| {
        other.address.unit.is_some() && same_building(&stop.address, &other.address)
    };
    match stops.iter().find(is_unit) {
        Some(unit) if stop.address.unit.is_none() => unit.address.clone(),
        _ => stop.address.clone(),
    }
}

/// One stop for each door; a whole building gives way to its units.
fn merge(stops: Vec<Stop>, before: &[Precedes]) -> Stops {
    let mut merged: Vec<Stop> = Vec::new();
    let mut place = Vec::with_capacity(stops.len());
    let addresses: Vec<Address> = stops.iter().map(|stop| door_of(stop, &stops)).collect();
    for (stop, address) in stops.into_iter().zip(addresses) {
        let known = merged.iter().position(|m| m.address.same_door(&address));
        let at = known.unwrap_or_else(|| {
            let (problem, levels) = (stop.problem.clone(), stop.levels.clone());
            let confidence = stop.confidence;
            merged.push(Stop {
                items: Vec::new(),
                address,
                confidence,
                problem,
                due: None,
                levels,
            });
            merged.len() - 1
        });
        let new_items: Vec<String> = stop
            .items
            .into_iter()
            .filter(|item| !merged[at].items.contains(item))
            .collect();
        merged[at].items.extend(new_items);
        merged[at].confidence = merged[at].confidence.max(stop.confidence);
        merged[at].due = merged[at].due.into_iter().chain(stop.due).min();
        place.push(at);
    }
    let merge = |order: &Precedes| {
        let order = Precedes {
            earlier: *place.get(order.earlier)?,
            later: *place.get(order.later)?,
        };
        (order.earlier != order.later).then_some(order)
    };
    Stops {
        before: before.iter().filter_map(merge).collect(),
        stops: merged,
    }
}

fn same_building(a: &Address, b: &Address) -> bool {
    let whole = |a: &Address| Address {
        building: a.building.clone(),
        unit: None,
    };
    whole(a).same_door(&whole(b))
}
