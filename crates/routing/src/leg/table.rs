//! What the lightest legs between many places take.

use super::ends::{Hold, Memory};
use super::find::along_one_edge;
use super::travel::{Leg, Measures};
use crate::metric::Metric;
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;
use crate::search::{Found, TableMemory, ValuedEnd};

impl Leg {
    /// What the lightest leg from each of some places to each of others takes, one source after
    /// another; `None` where there is none. Each place is given by its positions. Lengths are 0
    /// unless `lengths` are wanted.
    pub fn table(
        roads: &Roads,
        metric: &Metric,
        from: &[&[Position]],
        to: &[&[Position]],
        lengths: bool,
        memory: &mut Memory,
        tables: &mut TableMemory,
    ) -> Vec<Option<Measures>> {
        let mut sources = Vec::with_capacity(from.len());
        for place in from {
            // One end at a time: the table joins all sources with all targets itself.
            memory.hold(roads, metric, place, &[]);
            sources.push(valued(&memory.sources));
        }
        let mut targets = Vec::with_capacity(to.len());
        for place in to {
            memory.hold(roads, metric, &[], place);
            targets.push(valued(&memory.targets));
        }
        // Where all weights are durations, durations need no sums of their own.
        let weights_suffice = !lengths && metric.weight_is_duration();
        let values = (!weights_suffice).then(|| metric.values(roads));
        let graph = metric.searched(roads);
        let found = tables.table(&mut memory.workspace, graph, values, &sources, &targets);
        let pairs = from.iter().flat_map(|a| to.iter().map(move |b| (a, b)));
        let cells = found.into_iter().zip(pairs);
        cells
            .map(|(found, (a, b))| {
                // As in `Leg::find`: the search does not see legs within one edge.
                let around = measures(found, weights_suffice);
                let straight = along_one_edge(metric, a, b);
                match (straight, around) {
                    (Some(leg), None) => Some(leg.measures(roads, metric, 0)),
                    (Some(leg), Some(around)) if leg.weight <= around.weight => {
                        Some(leg.measures(roads, metric, 0))
                    }
                    (_, around) => around,
                }
            })
            .collect()
    }
}

fn valued(holds: &[Hold]) -> Vec<ValuedEnd> {
    holds
        .iter()
        .map(|hold| ValuedEnd {
            end: hold.end,
            value: hold.value,
        })
        .collect()
}

/// What a cell of the search's table means; `None` if there is no way.
fn measures(found: Found, weights_suffice: bool) -> Option<Measures> {
    (found.weight < FAR).then(|| Measures {
        length: f64::from(found.value.length) / 100.0,
        duration: if weights_suffice {
            found.weight
        } else {
            found.value.duration
        },
        weight: found.weight,
    })
}
