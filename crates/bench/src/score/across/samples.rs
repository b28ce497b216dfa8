//! The values of a system, by where and when they were measured.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::measures::{Episode, Measure};
use super::system::System;
use crate::score::metrics::values::by_episode;
use crate::score::statistics::MIN_EPISODES;
use crate::worlds::Hashes;

/// What is resampled as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClusteredBy {
    /// Worlds: intervals are for other worlds.
    World,
    /// Episodes, with all their seeds. There are too few worlds, so intervals are for other
    /// episodes in the same worlds.
    Episode,
}

/// Where a value was measured.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub setup: Hashes,
    pub seed: u64,
    pub episode: usize,
    /// The address; empty for a value of the whole episode.
    pub door: String,
    /// 1 for the first delivery to the door in the episode.
    pub visit: usize,
}

/// Values by place.
pub(super) type Samples = BTreeMap<Place, f64>;

/// The setups and seeds of a system's runs.
pub(super) fn setups(system: &System) -> Vec<(Hashes, u64)> {
    let runs = system.runs.iter();
    runs.map(|run| (run.provenance.hashes.clone(), run.seed))
        .collect()
}

/// The values of a measure in all runs of a system.
pub(super) fn samples(system: &System, measure: &Measure) -> Samples {
    let mut samples = Samples::new();
    for (run, (setup, seed)) in system.runs.iter().zip(setups(system)) {
        let is_planned = run.episodes.iter().any(|e| e.understood.is_some());
        for (number, deliveries) in by_episode(&run.deliveries) {
            let episode = Episode {
                deliveries: &deliveries,
                result: run.episodes.iter().find(|e| e.episode == number),
                is_planned,
            };
            let mut doors = BTreeMap::<String, usize>::new();
            for (door, value) in measure.values(episode) {
                let visits = doors.entry(door.clone()).or_default();
                *visits += 1;
                let place = Place {
                    setup: setup.clone(),
                    seed,
                    episode: number,
                    door,
                    visit: *visits,
                };
                samples.insert(place, value);
            }
        }
    }
    samples
}

/// By what the runs of a system are clustered: by world if there are enough of them.
pub(super) fn clustered_by(system: &System) -> ClusteredBy {
    let setups = setups(system);
    let worlds: BTreeSet<&String> = setups.iter().map(|(setup, _)| &setup.world).collect();
    if worlds.len() >= MIN_EPISODES {
        ClusteredBy::World
    } else {
        ClusteredBy::Episode
    }
}

/// The values of each cluster.
pub(super) fn clusters(samples: &Samples, by: ClusteredBy) -> Vec<Vec<f64>> {
    let mut clusters = BTreeMap::<(&Hashes, usize), Vec<f64>>::new();
    let mut worlds = BTreeMap::<&String, Vec<f64>>::new();
    for (place, value) in samples {
        match by {
            ClusteredBy::World => worlds.entry(&place.setup.world).or_default().push(*value),
            ClusteredBy::Episode => clusters
                .entry((&place.setup, place.episode))
                .or_default()
                .push(*value),
        }
    }
    worlds.into_values().chain(clusters.into_values()).collect()
}

/// The mean of all values; `None` without values.
pub(super) fn mean<'a>(values: impl Iterator<Item = &'a f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
