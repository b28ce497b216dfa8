//! Means over the runs of a system.

use serde::{Deserialize, Serialize};

use super::comparison::{Compared, compared};
use super::measures::{MEASURES, Measure, Unit};
use super::paired::interval_of_mean;
use super::samples::{ClusteredBy, clustered_by, clusters, mean, samples, setups};
use super::system::System;
use crate::score::statistics::mean_interval;
use crate::worlds::Hashes;

/// Means over the runs of a system, with intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Means {
    /// Agent and suites, and what has to be known before any number.
    pub system: Compared,
    /// Seeds of the runs, in their order.
    pub seeds: Vec<u64>,
    /// What the intervals are clustered by.
    pub clustered_by: ClusteredBy,
    /// The measures, in the order of the paper's table.
    pub measures: Vec<Mean>,
}

/// The mean of a measure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mean {
    /// Its name in `results.json`.
    pub name: String,
    /// What it is counted in.
    pub unit: Unit,
    /// The mean of all values.
    pub mean: f64,
    /// Its 95 % interval; null with too few clusters.
    pub interval: Option<[f64; 2]>,
    /// The mean of each run; null where the run has no value.
    pub runs: Vec<Option<f64>>,
}

/// The means over the runs of a system; `seed` is that of the bootstrap.
pub fn means(system: &System, seed: u64) -> Means {
    let by = clustered_by(system);
    let measures = MEASURES.iter();
    Means {
        system: compared(system),
        seeds: system.runs.iter().map(|run| run.seed).collect(),
        clustered_by: by,
        measures: measures
            .filter_map(|measure| mean_of(system, measure, by, seed))
            .collect(),
    }
}

fn mean_of(system: &System, measure: &Measure, by: ClusteredBy, seed: u64) -> Option<Mean> {
    let all = samples(system, measure);
    let values = clusters(&all, by);
    let of_run = |(setup, seed): (Hashes, u64)| {
        let its_own = all
            .iter()
            .filter(|(place, _)| place.setup == setup && place.seed == seed);
        mean(its_own.map(|(_, value)| value))
    };
    Some(Mean {
        name: measure.name.to_owned(),
        unit: measure.unit,
        mean: mean(all.values())?,
        interval: match measure.unit {
            Unit::Share => mean_interval(&values, seed),
            Unit::Count | Unit::Seconds => interval_of_mean(&values, seed),
        },
        runs: setups(system).into_iter().map(of_run).collect(),
    })
}
