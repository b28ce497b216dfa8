//! Buildings without units that share those of another one.

use crate::grammar::mentions::mention::Mention;
use crate::grammar::reading::Reading;
use crate::grammar::rule::{Example, Rule};
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;

/// The most words that part a building from `same unit`.
const SAME_BESIDE: usize = 4;

/// Mentions, and for each the building that it belongs to.
pub(crate) struct Pairing<'a> {
    pub reading: &'a Reading<'a>,
    pub mentions: &'a [Mention],
    pub owners: &'a [Option<usize>],
}

impl Pairing<'_> {
    fn is_building(&self, i: usize) -> bool {
        self.mentions[i].is_building()
    }

    /// The units that belong to a building.
    fn units(&self, building: usize) -> Vec<usize> {
        let is_own = |i: &usize| !self.is_building(*i) && self.owners[*i] == Some(building);
        (0..self.mentions.len()).filter(is_own).collect()
    }

    /// How many lexemes part a mention from a place.
    fn distance(&self, mention: usize, at: usize) -> usize {
        let range = &self.mentions[mention].at;
        if range.start > at {
            range.start - at
        } else {
            at.saturating_sub(range.end)
        }
    }
}

/// A building, and the units that it shares with another one.
pub(crate) struct Share {
    pub building: usize,
    pub units: Vec<usize>,
}

/// A rule of [`SHARINGS`]: finds shares beside those that are found already.
pub(crate) type Sharing = Rule<fn(&Pairing<'_>, &[Share]) -> Vec<Share>>;

/// Which buildings share the units of others. Of several shares of a building the first counts.
pub(crate) const SHARINGS: &[Sharing] = &[
    Sharing {
        name: "a building shares the units of the one that it is listed with",
        examples: &[Example(
            "1号楼和12号楼的3单元各一袋。",
            "building1/unit3 building12/unit3",
        )],
        apply: listed,
    },
    Sharing {
        name: "a unit is said of all buildings before it",
        examples: &[Example(
            "two bags, one to building 3, one to building 5, always unit 2",
            "building3/unit2 building5/unit2",
        )],
        apply: said_of_all,
    },
    Sharing {
        name: "the same unit of another building",
        examples: &[Example(
            "unit 2 in building 7 and the same unit in building 8",
            "building7/unit2 building8/unit2",
        )],
        apply: of_the_same_number,
    },
];

/// All shares that the rules find.
pub(super) fn shares(rules: &[Sharing], pairing: &Pairing<'_>) -> Vec<Share> {
    let mut shares = Vec::new();
    for rule in rules {
        let found = (rule.apply)(pairing, &shares);
        shares.extend(found);
    }
    shares
}

/// `1号楼和12号楼的3单元`, `Haus 1 und Haus 12, jeweils Eingang 3`
fn listed(pairing: &Pairing<'_>, _: &[Share]) -> Vec<Share> {
    let mut shares: Vec<Share> = Vec::new();
    for building in (1..pairing.mentions.len()).rev() {
        if !is_listed(pairing, building) || !pairing.units(building - 1).is_empty() {
            continue;
        }
        let shared = shares.iter().find(|share| share.building == building);
        let units = shared.map_or_else(|| pairing.units(building), |share| share.units.clone());
        if are_dealt_out(pairing, building, &units) {
            shares.push(Share {
                building: building - 1,
                units,
            });
        }
    }
    shares
}

/// Whether nothing but commas and `and` part a building from one before it.
fn is_listed(pairing: &Pairing<'_>, building: usize) -> bool {
    let mentions = pairing.mentions;
    let mut gap = mentions[building - 1].at.end..mentions[building].at.start;
    let is_list = |at: usize| {
        matches!(
            pairing.reading.lex(at),
            Some(Lex::Comma | Lex::Word(Class::And, _))
        )
    };
    let are_buildings = pairing.is_building(building) && pairing.is_building(building - 1);
    are_buildings && !gap.is_empty() && gap.all(is_list)
}

/// Whether units, all behind their building, are those of all buildings listed with it.
fn are_dealt_out(pairing: &Pairing<'_>, building: usize, units: &[usize]) -> bool {
    let reading = pairing.reading;
    let at = &pairing.mentions[building].at;
    let Some(first) = units.first() else {
        return false;
    };
    let are_behind = units
        .iter()
        .all(|unit| pairing.mentions[*unit].at.start >= at.end);
    let is_number_first = at.clone().any(|at| {
        use Class::{Building, WeakBuilding};
        matches!(
            reading.lex(at),
            Some(Lex::Word(Building | WeakBuilding, true))
        )
    });
    let unit = &pairing.mentions[*first].at;
    let beside = at.end.min(unit.start)..reading.lexemes.len().min(unit.end + 2);
    let deals = |at: usize| matches!(reading.class(at), Some(Class::Each | Class::Respectively));
    are_behind && (is_number_first || beside.into_iter().any(deals))
}

/// `one bag to building 3, one to building 5, always unit 2`
fn said_of_all(pairing: &Pairing<'_>, found: &[Share]) -> Vec<Share> {
    let is_said_of_all = |unit: &usize| !pairing.is_building(*unit) && is_shared(pairing, *unit);
    let Some(unit) = (0..pairing.mentions.len()).find(is_said_of_all) else {
        return Vec::new();
    };
    let is_bare = |b: &usize| {
        let has_share = found.iter().any(|share| share.building == *b);
        pairing.is_building(*b) && !has_share && pairing.units(*b).is_empty()
    };
    let share = |building| Share {
        building,
        units: vec![unit],
    };
    (0..unit).filter(is_bare).map(share).collect()
}

/// Whether `always` or the like stands before a unit.
fn is_shared(pairing: &Pairing<'_>, unit: usize) -> bool {
    let reading = pairing.reading;
    let is_passed = |at: &usize| matches!(reading.class(*at), Some(Class::Link | Class::Article));
    let before = (0..pairing.mentions[unit].at.start)
        .rev()
        .find(|at| !is_passed(at));
    before.is_some_and(|at| reading.class(at) == Some(Class::Shared))
}

/// `unit 2 in building 7 and the same unit in building 8`
fn of_the_same_number(pairing: &Pairing<'_>, _: &[Share]) -> Vec<Share> {
    let buildings = || (0..pairing.mentions.len()).filter(|i| pairing.is_building(*i));
    let has_units = |b: &usize| !pairing.units(*b).is_empty();
    let is_same = |at: &usize| pairing.reading.class(*at) == Some(Class::SameUnit);
    let mut shares = Vec::new();
    for at in (0..pairing.reading.lexemes.len()).filter(is_same) {
        let distance = |b: &usize| pairing.distance(*b, at);
        let bare = buildings().filter(|b| !has_units(b)).min_by_key(distance);
        let Some(bare) = bare.filter(|b| distance(b) <= SAME_BESIDE) else {
            continue;
        };
        let other = buildings()
            .filter(has_units)
            .min_by_key(|b| b.abs_diff(bare));
        shares.extend(other.map(|other| Share {
            building: bare,
            units: pairing.units(other),
        }));
    }
    shares
}
