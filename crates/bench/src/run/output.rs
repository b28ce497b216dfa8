//! The output of a run, from the traces of its episodes.

use openbench_core::ModelUse;
use openbench_osm::{OsmData, merge_entrances};

use super::request::RunRequest;
use crate::score::deliveries;
use crate::score::metrics::localization::localization;
use crate::score::metrics::{ErrorCounts, RunTotals, summarize};
use crate::score::results::{MemoryUse, Results};
use crate::trace::EpisodeTrace;
use crate::worlds::Prepared;

/// The output of a run.
#[derive(Debug)]
pub struct RunOutput {
    /// The results.
    pub results: Results,
    /// The public map with every door that was found in this run or known before it.
    pub memory: OsmData,
    /// Errors of all poses that the agent reported.
    pub pose_errors: ErrorCounts,
}

/// What a machine needed for a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct MachineTimes {
    /// Wall-clock time, seconds.
    pub wall_seconds: f64,
    /// CPU time of the process, seconds.
    pub cpu_seconds: f64,
}

impl RunOutput {
    /// The output of a run whose episodes have these traces.
    pub(super) fn new(
        request: &RunRequest<'_>,
        traces: &[EpisodeTrace],
        times: MachineTimes,
    ) -> Self {
        Self {
            results: results(request, traces, times),
            memory: merged_memory(request, traces),
            pose_errors: ErrorCounts::of(traces.iter().flat_map(|trace| &trace.pose_errors)),
        }
    }
}

fn results(request: &RunRequest<'_>, traces: &[EpisodeTrace], times: MachineTimes) -> Results {
    let prepared = request.prepared;
    let pairs = prepared.episodes.iter().zip(traces).enumerate();
    let deliveries: Vec<_> = pairs
        .flat_map(|(i, (episode, trace))| deliveries::score_episode(prepared, i, episode, trace))
        .collect();
    let totals = RunTotals {
        sim_seconds: traces.iter().map(|t| t.sim_seconds).sum(),
        wall_seconds: times.wall_seconds,
        cpu_seconds: times.cpu_seconds,
        instructions: deliveries::understood(prepared, traces),
        localization: localization(traces.iter().map(|t| &t.pose_errors[..])),
        seed: request.seed,
    };
    Results {
        suite: prepared.suite.name.clone(),
        agent: request.agent.to_owned(),
        seed: request.seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        settings: request.settings.clone(),
        targets: prepared.target_source(),
        traffic: prepared.suite.traffic,
        sensors: prepared.suite.sensors,
        memory: request.memory.map(|memory| memory_use(prepared, memory)),
        metrics: summarize(&deliveries, &totals),
        episodes: deliveries::score_episodes(prepared, traces),
        deliveries,
        models: Some(model_use(traces)).filter(|used| used.calls > 0),
        doors: deliveries::score_written_doors(prepared, traces),
        attribution: prepared.world.attribution.clone(),
    }
}

/// What a memory adds to the public map.
fn memory_use(prepared: &Prepared, memory: &OsmData) -> MemoryUse {
    let mut merged = prepared.world.map.clone();
    MemoryUse {
        doors: merge_entrances(&mut merged, memory),
    }
}

fn model_use(traces: &[EpisodeTrace]) -> ModelUse {
    traces
        .iter()
        .fold(ModelUse::default(), |sum, trace| sum.plus(trace.models))
}

/// The public map with the doors known before and those found in each episode, in the order of the
/// episodes.
fn merged_memory(request: &RunRequest<'_>, traces: &[EpisodeTrace]) -> OsmData {
    let mut merged = request.prepared.world.map.clone();
    // In this order, since `merge_entrances` moves a known door to where the later map has it.
    if let Some(memory) = request.memory {
        merge_entrances(&mut merged, memory);
    }
    // An agent may return anything as its map. One that cannot be parsed has no doors to merge.
    let maps = traces
        .iter()
        .filter_map(|t| OsmData::from_bytes(t.map.as_deref()?).ok());
    for map in maps {
        merge_entrances(&mut merged, &map);
    }
    merged
}
