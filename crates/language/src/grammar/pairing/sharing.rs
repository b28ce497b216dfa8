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
        (0..self.mentions.len())
            .filter(|i| !self.is_building(*i) && self.owners[*i] == Some(building))
            .collect()
    }

    fn has_units(&self, building: usize) -> bool {
        !self.units(building).is_empty()
    }

    fn buildings(&self) -> impl Iterator<Item = usize> {
        (0..self.mentions.len()).filter(|i| self.is_building(*i))
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
    // Backwards, so that a whole list shares: the last building gives its units to the one before
    // it, and that passes its share on.
    for building in (1..pairing.mentions.len()).rev() {
        if !is_listed(pairing, building) || pairing.has_units(building - 1) {
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
    let are_buildings = pairing.is_building(building) && pairing.is_building(building - 1);
    are_buildings
        && !gap.is_empty()
        && gap.all(|at| {
            matches!(
                pairing.reading.lex(at),
                Some(Lex::Comma | Lex::Word(Class::And, _))
            )
        })
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
    // Languages that put the number first list buildings and give their unit once.
    let is_number_first = at.clone().any(|at| {
        use Class::{Building, WeakBuilding};
        matches!(
            reading.lex(at),
            Some(Lex::Word(Building | WeakBuilding, true))
        )
    });
    let unit = &pairing.mentions[*first].at;
    // `unit 3 each` and `unit 3 of each` have the word one or two lexemes behind the unit.
    let mut beside = at.end.min(unit.start)..reading.lexemes.len().min(unit.end + 2);
    let are_dealt =
        beside.any(|at| matches!(reading.class(at), Some(Class::Each | Class::Respectively)));
    are_behind && (is_number_first || are_dealt)
}

/// `one bag to building 3, one to building 5, always unit 2`
fn said_of_all(pairing: &Pairing<'_>, found: &[Share]) -> Vec<Share> {
    let shared = (0..pairing.mentions.len())
        .find(|unit| !pairing.is_building(*unit) && is_shared(pairing, *unit));
    let Some(unit) = shared else {
        return Vec::new();
    };
    pairing
        .buildings()
        .filter(|building| *building < unit && !pairing.has_units(*building))
        .filter(|building| found.iter().all(|share| share.building != *building))
        .map(|building| Share {
            building,
            units: vec![unit],
        })
        .collect()
}

/// Whether `always` or the like stands before a unit.
fn is_shared(pairing: &Pairing<'_>, unit: usize) -> bool {
    let reading = pairing.reading;
    let before = (0..pairing.mentions[unit].at.start)
        .rev()
        .find(|at| !matches!(reading.class(*at), Some(Class::Link | Class::Article)));
    before.is_some_and(|at| reading.class(at) == Some(Class::Shared))
}

/// `unit 2 in building 7 and the same unit in building 8`
fn of_the_same_number(pairing: &Pairing<'_>, _: &[Share]) -> Vec<Share> {
    let mut shares = Vec::new();
    for at in 0..pairing.reading.lexemes.len() {
        if pairing.reading.class(at) != Some(Class::SameUnit) {
            continue;
        }
        let bare = pairing
            .buildings()
            .filter(|building| !pairing.has_units(*building))
            // The building without units that is nearest to the words.
            .min_by_key(|building| pairing.distance(*building, at));
        let Some(bare) = bare.filter(|bare| pairing.distance(*bare, at) <= SAME_BESIDE) else {
            continue;
        };
        let other = pairing
            .buildings()
            .filter(|building| pairing.has_units(*building))
            // The building with units that is mentioned nearest to it.
            .min_by_key(|building| building.abs_diff(bare));
        shares.extend(other.map(|other| Share {
            building: bare,
            units: pairing.units(other),
        }));
    }
    shares
}
