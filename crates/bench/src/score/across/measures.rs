//! What is compared.

use serde::{Deserialize, Serialize};

use crate::score::metrics::sequence_mean;
use crate::score::metrics::values::{
    Value, clean_success, correct_unit, paper_ratio, paper_success, strict_ratio, strict_success,
};
use crate::score::results::{DeliveryResult, EpisodeResult};

/// What a measure is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// A rate or ratio, 0 to 1.
    Share,
    /// A number of events.
    Count,
    /// Seconds.
    Seconds,
}

/// A measure, with the name that it has in `results.json`; those of all deliveries, which are sums
/// there, have names of their own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure {
    /// Its name.
    pub name: &'static str,
    /// What it is counted in.
    pub unit: Unit,
    of: Of,
}

/// Of what a measure is the mean.
#[derive(Debug, Clone, Copy)]
enum Of {
    /// Deliveries after which the robot starts anew.
    Singles(Value),
    /// Deliveries in sequences.
    Members(Value),
    /// Deliveries to buildings that the public map lacks or misnames.
    Unmapped(Value),
    /// Sequences, with their weighted means.
    Sequences(Value),
    /// All deliveries.
    Deliveries(Value),
    /// Plans.
    Plans,
}

/// All measures.
pub(super) const MEASURES: [Measure; 22] = [
    share("srtp", Of::Plans),
    share("sr_10m", Of::Singles(paper_success)),
    share("spl_straight", Of::Singles(paper_ratio)),
    share("lsr_10m", Of::Sequences(paper_success)),
    share("lspl_straight", Of::Sequences(paper_ratio)),
    share(SUCCESS, Of::Singles(strict_success)),
    share("spl", Of::Singles(strict_ratio)),
    share("lsr", Of::Sequences(strict_success)),
    share("lspl", Of::Sequences(strict_ratio)),
    share("sr_clean", Of::Singles(clean_success)),
    share("correct_unit", Of::Singles(correct_unit)),
    share("member_sr_10m", Of::Members(paper_success)),
    share("member_spl_straight", Of::Members(paper_ratio)),
    share("member_sr_2m", Of::Members(strict_success)),
    share("member_spl", Of::Members(strict_ratio)),
    share("member_sr_clean", Of::Members(clean_success)),
    share("member_correct_unit", Of::Members(correct_unit)),
    share("unmapped_sr_2m", Of::Unmapped(strict_success)),
    share("unmapped_spl", Of::Unmapped(strict_ratio)),
    Measure {
        name: "delivery_collisions",
        unit: Unit::Count,
        of: Of::Deliveries(collisions),
    },
    Measure {
        name: "delivery_contact_s",
        unit: Unit::Seconds,
        of: Of::Deliveries(contact),
    },
    Measure {
        name: "delivery_seconds",
        unit: Unit::Seconds,
        of: Of::Deliveries(time),
    },
];

/// The measure whose differences are tested.
pub(super) const SUCCESS: &str = "sr_2m";

const fn share(name: &'static str, of: Of) -> Measure {
    Measure {
        name,
        unit: Unit::Share,
        of,
    }
}

fn collisions(delivery: &DeliveryResult) -> f64 {
    delivery.collisions as f64
}

fn contact(delivery: &DeliveryResult) -> f64 {
    delivery.contact_s
}

fn time(delivery: &DeliveryResult) -> f64 {
    delivery.sim_seconds
}

/// An episode of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Episode<'a> {
    /// Its deliveries, in the order of their tasks.
    pub deliveries: &'a [&'a DeliveryResult],
    /// Its own results.
    pub result: Option<&'a EpisodeResult>,
    /// Whether the agent makes plans: then an episode without one is not understood.
    pub is_planned: bool,
}

impl Measure {
    /// The values of an episode: by door, or one for the whole episode, whose door is empty.
    pub(super) fn values(&self, episode: Episode<'_>) -> Vec<(String, f64)> {
        let is_single = episode.deliveries.len() == 1;
        match self.of {
            Of::Singles(value) if is_single => by_door_of(episode, value, true),
            Of::Members(value) if !is_single => by_door_of(episode, value, true),
            Of::Unmapped(value) => by_door_of(episode, value, false),
            Of::Deliveries(value) => by_door(episode, value),
            Of::Sequences(value) if !is_single => {
                let values: Vec<f64> = episode.deliveries.iter().map(|d| value(d)).collect();
                whole(sequence_mean(&values))
            }
            Of::Plans if episode.is_planned => whole(episode.result.map(planned)),
            _ => Vec::new(),
        }
    }
}

/// 1 for a plan that the requested planner made alone, and that is right; 0 otherwise.
fn planned(episode: &EpisodeResult) -> f64 {
    let is_right = episode.understood == Some(true);
    f64::from(is_right && episode.fallbacks.is_empty())
}

fn whole(value: Option<f64>) -> Vec<(String, f64)> {
    value
        .map(|value| (String::new(), value))
        .into_iter()
        .collect()
}

/// Deliveries to buildings that the public map has right, or only those to others. The metrics of a
/// run are of the former.
fn by_door_of(episode: Episode<'_>, value: Value, on_map: bool) -> Vec<(String, f64)> {
    let deliveries = episode.deliveries.iter().copied();
    let deliveries: Vec<&DeliveryResult> = deliveries
        .filter(|d| d.on_map.is_right() == on_map)
        .collect();
    let deliveries = &deliveries[..];
    by_door(
        Episode {
            deliveries,
            ..episode
        },
        value,
    )
}

fn by_door(episode: Episode<'_>, value: Value) -> Vec<(String, f64)> {
    let deliveries = episode.deliveries.iter();
    deliveries
        .map(|delivery| (delivery.address().to_string(), value(delivery)))
        .collect()
}
