//! What a profile's file may hold.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use openbench_osm::Tags;
use serde::Deserialize;

/// A number for each of some tags: `key.value = number`.
pub(super) type Numbers = BTreeMap<String, BTreeMap<String, f64>>;
/// Some values of some keys: `key = ["value", …]`; `*` is any value.
pub(super) type Lists = BTreeMap<String, Vec<String>>;

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rules {
    /// In words.
    pub(super) description: String,
    pub(super) places: Places,
    pub(super) access: Access,
    pub(super) ways: Ways,
    #[serde(default)]
    pub(super) nodes: Nodes,
    pub(super) turns: Option<Turns>,
}

/// How pedestrian areas are passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Places {
    /// Straight across.
    Cross,
    /// Along their outlines, as OSRM does it.
    Outline,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Access {
    /// Keys that say who may go, the most specific one first.
    pub(super) keys: Vec<String>,
    /// Words that open a way even if it has no speed.
    pub(super) open: Vec<String>,
    /// Words that close it. Other words are no bar.
    pub(super) closed: Vec<String>,
    /// Words that open it to those only who begin or end there.
    #[serde(default)]
    pub(super) at_ends: Vec<String>,
    /// Seconds that entering such a way counts as.
    #[serde(default)]
    pub(super) entry: f64,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ways {
    /// km/h; of several the fastest counts.
    pub(super) speed: Numbers,
    /// km/h where an access word opens a way that has no speed.
    pub(super) speed_if_open: Option<f64>,
    /// km/h that are not exceeded.
    #[serde(default)]
    pub(super) limit: Numbers,
    pub(super) maxspeed: Option<MaxSpeed>,
    /// How much longer a second here counts; of several each.
    #[serde(default)]
    pub(super) cost: Numbers,
    #[serde(default)]
    pub(super) closed: Lists,
    /// Closed unless an access word says otherwise.
    #[serde(default)]
    pub(super) closed_unless_open: Lists,
    #[serde(default)]
    pub(super) oneway: OneWay,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaxSpeed {
    /// Keys that hold a limit, the most specific one first.
    pub(super) keys: Vec<String>,
    /// How much of it is driven.
    pub(super) share: f64,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OneWay {
    /// Keys that say so, the most specific one first.
    #[serde(default)]
    pub(super) keys: Vec<String>,
    /// What is one-way if none of them says anything.
    #[serde(default)]
    pub(super) implied: Lists,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Nodes {
    /// What is passed although `closed` names it.
    #[serde(default)]
    pub(super) open: Lists,
    /// What stops one, unless an access word says otherwise.
    #[serde(default)]
    pub(super) closed: Lists,
    /// Seconds; of several the longest.
    #[serde(default)]
    pub(super) delay: Numbers,
    /// Seconds that are not spent but counted; of several the most.
    #[serde(default)]
    pub(super) cost: Numbers,
}

/// What turning costs. A profile that has this keeps to turn restrictions.
///
/// The penalty is OSRM's: `sharpest / (1 + exp(-((13 / bias) * angle / 180 - 6.5 * bias)))` seconds for a turn to the side one drives on,
/// `angle` in degrees, and with `bias` the other way round for a turn across the road.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turns {
    /// Keys that a restriction or its exceptions may name this vehicle by.
    pub restrictions: Vec<String>,
    /// Seconds.
    pub sharpest: f64,
    /// Above 1: turning across the road is dearer.
    pub bias: f64,
    /// Seconds for turning round.
    pub u_turn: f64,
    /// Whether one drives on the right.
    pub right_hand: bool,
    /// Whether one goes on at places on the way without turning round.
    #[serde(default)]
    pub continue_straight: bool,
}

impl Rules {
    /// Checks that all numbers are in the range in which they make sense.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        let (ways, nodes) = (&self.ways, &self.nodes);
        check_all("ways.speed", &ways.speed, 0.01..=1000.0)?;
        check_all("ways.limit", &ways.limit, 0.01..=1000.0)?;
        check_all("ways.cost", &ways.cost, 0.01..=100.0)?;
        check_all("nodes.delay", &nodes.delay, 0.0..=36_000.0)?;
        check_all("nodes.cost", &nodes.cost, 0.0..=36_000.0)?;
        check("access.entry", self.access.entry, 0.0..=36_000.0)?;
        check(
            "ways.speed_if_open",
            ways.speed_if_open.unwrap_or(1.0),
            0.01..=1000.0,
        )?;
        let share = ways
            .maxspeed
            .as_ref()
            .map_or(1.0, |maxspeed| maxspeed.share);
        check("ways.maxspeed.share", share, 0.1..=2.0)?;
        if let Some(turns) = &self.turns {
            check("turns.sharpest", turns.sharpest, 0.0..=3600.0)?;
            check("turns.bias", turns.bias, 0.1..=10.0)?;
            check("turns.u_turn", turns.u_turn, 0.0..=3600.0)?;
        }
        Ok(())
    }
}

/// A number of a profile that is out of range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} = {number} is not between {} and {}", range.start(), range.end())]
pub struct OutOfRange {
    /// Its key.
    pub key: String,
    /// The number.
    pub number: f64,
    /// The range in which it makes sense.
    pub range: RangeInclusive<f64>,
}

fn check_all(place: &str, numbers: &Numbers, range: RangeInclusive<f64>) -> Result<(), OutOfRange> {
    for (key, values) in numbers {
        for (value, number) in values {
            check(&format!("{place} {key}.{value}"), *number, range.clone())?;
        }
    }
    Ok(())
}

fn check(key: &str, number: f64, range: RangeInclusive<f64>) -> Result<(), OutOfRange> {
    if range.contains(&number) {
        return Ok(());
    }
    Err(OutOfRange {
        key: key.to_owned(),
        number,
        range,
    })
}

/// Those of the numbers that an element's tags ask for.
pub(super) fn matching<'a>(numbers: &'a Numbers, tags: &'a Tags) -> impl Iterator<Item = f64> + 'a {
    tags.iter()
        .filter_map(|(key, value)| numbers.get(key)?.get(value).copied())
}

/// Whether one of an element's tags is in the lists.
pub(super) fn listed(lists: &Lists, tags: &Tags) -> bool {
    tags.iter().any(|(key, value)| {
        lists
            .get(key)
            .is_some_and(|values| values.iter().any(|v| v == value || v == "*"))
    })
}
