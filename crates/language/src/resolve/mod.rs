//! From what an instruction says to the map's own names, and to a problem in words where the map
//! lacks a place or has several.
//!
//! Wishes for one door become one stop. A building without a unit gives way to its units, if one of
//! them is asked for too.

mod building;
mod surroundings;
mod units;

use std::cell::OnceCell;
use std::ops::Range;

use openbench_core::{Address, AddressLevel, Deadline, Level};
use openbench_osm::OsmMap;

use self::building::{Choice, building, doubt};
use self::surroundings::{Surroundings, by_own_words};
use self::units::{is_behind_a_unit, single, unit_name};
use crate::gazetteer::Gazetteer;
use crate::wish::{Precedes, Wish, Wishes};

/// The most stops of a plan that all units of a building may add up to; with more, the building is
/// one stop.
const MOST_STOPS: usize = 200;

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
    // Once for all doors, so that the map's streets and quarters are searched once.
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
        // The limit holds for all wishes together: `all units` of many buildings must not add up.
        let single = single(wish, MOST_STOPS.saturating_sub(stops.len()), map, gazetteer);
        stops.extend(
            single
                .into_iter()
                .map(|wish| stop(wish, all, &surroundings, gazetteer)),
        );
        ranges.push(first..stops.len());
    }
    // Orders are between wishes, of which each may have become several stops or, after merging,
    // share one.
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

/// The stop of a wish; `all` is what is said of all doors.
fn stop(wish: Wish, all: &str, surroundings: &Surroundings<'_>, gazetteer: &Gazetteer) -> Stop {
    let map = surroundings.map;
    let mut chosen = building(wish.building, map, gazetteer);
    // What is said of the door itself comes before what is said of all.
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
    // A flat behind an entrance that is not said: the building is the address, the flat a level
    // below.
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

/// The address of a stop; for a whole building that of its first unit among all stops.
fn door_of(stop: &Stop, stops: &[Stop]) -> Address {
    let is_unit =
        |other: &&Stop| other.address.unit.is_some() && stop.address.same_building(&other.address);
    match stops.iter().find(is_unit) {
        Some(unit) if stop.address.unit.is_none() => unit.address.clone(),
        _ => stop.address.clone(),
    }
}

/// One stop for each door; a whole building gives way to its units.
fn merge(stops: Vec<Stop>, before: &[Precedes]) -> Stops {
    let mut merged: Vec<Stop> = Vec::new();
    let mut place = Vec::with_capacity(stops.len());
    // All of them before merging, since a whole building gives way to units that are named behind
    // it as well.
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
        // Two wishes for one door have no order.
        (order.earlier != order.later).then_some(order)
    };
    Stops {
        before: before.iter().filter_map(merge).collect(),
        stops: merged,
    }
}
