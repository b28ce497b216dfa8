//! The content of a profile's file.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use openbench_osm::Tags;
use serde::Deserialize;

/// A number for some tags: `key.value = number`.
pub(super) type Numbers = BTreeMap<String, BTreeMap<String, f64>>;
/// Some values of some keys: `key = ["value", …]`; `*` is any value.
pub(super) type Lists = BTreeMap<String, Vec<String>>;

#[derive(Debug, Clone, PartialEq, Deserialize)]
// Here and below: a misspelt key is an error, and not a rule that is silently missing.
#[serde(deny_unknown_fields)]
pub(super) struct Rules {
    /// What the profile is for.
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
    /// Along their outlines, as OSRM does.
    Outline,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Access {
    /// Keys that say who may go there, the most specific one first.
    pub(super) keys: Vec<String>,
    /// Values that open a way even if it has no speed.
    pub(super) open: Vec<String>,
    /// Values that close it. Other values do not.
    pub(super) closed: Vec<String>,
    /// Values that open it only to routes that begin or end there.
    #[serde(default)]
    pub(super) at_ends: Vec<String>,
    /// The weight of entering such a way, seconds.
    #[serde(default)]
    pub(super) entry: f64,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ways {
    /// km/h. Of several tags the fastest counts.
    pub(super) speed: Numbers,
    /// km/h where an access value opens a way that has no speed.
    pub(super) speed_if_open: Option<f64>,
    /// Upper limits, km/h.
    #[serde(default)]
    pub(super) limit: Numbers,
    pub(super) maxspeed: Option<MaxSpeed>,
    /// A factor from time to weight. Several are multiplied.
    #[serde(default)]
    pub(super) cost: Numbers,
    #[serde(default)]
    pub(super) closed: Lists,
    /// Closed unless an access value opens it.
    #[serde(default)]
    pub(super) closed_unless_open: Lists,
    #[serde(default)]
    pub(super) oneway: OneWay,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaxSpeed {
    /// Keys of a speed limit, the most specific one first.
    pub(super) keys: Vec<String>,
    /// The share of the limit that is driven.
    pub(super) share: f64,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OneWay {
    /// Keys that say so, the most specific one first.
    #[serde(default)]
    pub(super) keys: Vec<String>,
    /// What is one-way if none of the keys is present.
    #[serde(default)]
    pub(super) implied: Lists,
}

#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Nodes {
    /// What can be passed although `closed` lists it.
    #[serde(default)]
    pub(super) open: Lists,
    /// What cannot be passed, unless an access value opens it.
    #[serde(default)]
    pub(super) closed: Lists,
    /// Seconds. Of several tags the longest counts.
    #[serde(default)]
    pub(super) delay: Numbers,
    /// Weight that takes no time, seconds. Of several tags the greatest counts.
    #[serde(default)]
    pub(super) cost: Numbers,
}

/// The costs of turns. A profile with these obeys turn restrictions.
///
/// The penalty is OSRM's: `sharpest / (1 + exp(-((13 / bias) * angle / 180 - 6.5 * bias)))` seconds
/// for a turn towards the driving side, with `angle` in degrees. For a turn across the road `bias`
/// is inverted.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turns {
    /// Keys by which a restriction or its exceptions name this vehicle.
    pub restrictions: Vec<String>,
    /// The penalty of the sharpest turn, seconds.
    pub sharpest: f64,
    /// Above 1, turns across the road cost more.
    pub bias: f64,
    /// The penalty of a U-turn, seconds.
    pub u_turn: f64,
    /// Whether traffic drives on the right.
    pub right_hand: bool,
    /// Whether routes go straight on at places in between, without U-turns.
    #[serde(default)]
    pub continue_straight: bool,
}

impl Rules {
    /// Checks that all numbers are in the range in which they make sense.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        let (ways, nodes) = (&self.ways, &self.nodes);
        // Positive, because times are lengths divided by speeds.
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

/// The numbers that apply to an element's tags.
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
