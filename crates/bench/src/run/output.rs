//! The output of a run, from its record and the traces of its episodes.

use openbench_core::ModelUse;
use openbench_osm::{OsmData, merge_entrances};
use openbench_sim::{Defects, LensBuild};

use super::record::RunRecord;
use crate::score::deliveries;
use crate::score::metrics::localization::localization;
use crate::score::metrics::{ErrorCounts, RunTotals, summarize};
use crate::score::results::{ModelTotals, Results};
use crate::suite::Condition;
use crate::trace::EpisodeTrace;
use crate::worlds::{Prepared, split_of};

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MachineTimes {
    /// Wall-clock time, seconds.
    pub wall_seconds: f64,
    /// CPU time of the process, seconds.
    pub cpu_seconds: f64,
}

/// The defects of the robot, if a suite has any drawn.
fn drawn(prepared: &Prepared) -> Option<Defects> {
    let is_off = prepared.suite.conditions.robot.is_off();
    (!is_off).then_some(prepared.defects)
}

/// The lens of the camera, if a suite has any drawn.
fn drawn_lens(prepared: &Prepared) -> Option<LensBuild> {
    let lens = &prepared.surroundings.lens;
    (*lens != LensBuild::default()).then(|| lens.clone())
}

/// A finished run.
#[derive(Clone, Copy)]
pub(super) struct FinishedRun<'a> {
    pub record: &'a RunRecord,
    pub prepared: &'a Prepared,
    /// The doors that the agents knew before it.
    pub memory: Option<&'a OsmData>,
    pub traces: &'a [EpisodeTrace],
    /// `None` for a run that was resumed: parts of it ran at other times.
    pub times: Option<MachineTimes>,
}

impl FinishedRun<'_> {
    /// What the run put out.
    pub(super) fn output(&self) -> RunOutput {
        let errors = self.traces.iter().flat_map(|trace| &trace.pose_errors);
        RunOutput {
            results: self.results(),
            memory: self.merged_memory(),
            pose_errors: ErrorCounts::of(errors),
        }
    }

    /// The results. `verify` computes them with the same function.
    pub(super) fn results(&self) -> Results {
        let Self {
            record,
            prepared,
            traces,
            ..
        } = *self;
        let pairs = prepared.episodes.iter().zip(traces).enumerate();
        let deliveries: Vec<_> = pairs
            .flat_map(|(i, (episode, trace))| {
                deliveries::score_episode(prepared, i, episode, trace)
            })
            .collect();
        let totals = RunTotals {
            sim_seconds: traces.iter().map(|t| t.sim_seconds).sum(),
            wall_seconds: self.times.map(|times| times.wall_seconds),
            cpu_seconds: self.times.map(|times| times.cpu_seconds),
            instructions: deliveries::understood(prepared, traces),
            localization: localization(traces.iter().map(|t| &t.pose_errors[..])),
            seed: record.seed,
        };
        Results {
            suite: prepared.suite.name.clone(),
            agent: record.agent.clone(),
            seed: record.seed,
            split: split_of(&prepared.suite.world),
            version: record.version.clone(),
            provenance: record.provenance(),
            settings: record.in_force.clone(),
            targets: prepared.target_source(),
            goal: prepared.suite.goal,
            traffic: prepared.suite.traffic,
            sensors: prepared.suite.sensors,
            conditions: prepared.suite.conditions,
            drawn_map: prepared.on_map().drawn(),
            public_frame: prepared.on_map().frame(),
            drawn_robot: drawn(prepared),
            drawn_lens: drawn_lens(prepared),
            drawn_light: prepared.surroundings.light,
            drawn_doors: prepared.world.doors,
            drawn_plates: prepared.world.plates.clone(),
            drawn_scenery: prepared.world.scenery.clone(),
            memory: record.memory.clone(),
            metrics: summarize(&deliveries, &totals),
            episodes: deliveries::score_episodes(prepared, traces),
            deliveries,
            models: self.models(),
            doors: deliveries::score_written_doors(prepared, traces),
            attribution: prepared.world.attribution.clone(),
        }
    }

    fn models(&self) -> Option<ModelTotals> {
        let uses = self.traces.iter().map(|trace| trace.models);
        let used = uses.fold(ModelUse::default(), ModelUse::plus);
        let mut totals = ModelTotals::from(used);
        totals.latency_ms = totals.latency_ms.filter(|_| self.times.is_some());
        Some(totals).filter(|totals| totals.calls > 0)
    }

    /// The public map with the doors known before and those found in each episode, in the order of
    /// the episodes.
    fn merged_memory(&self) -> OsmData {
        let mut merged = self.prepared.public_data().clone();
        // In this order, since `merge_entrances` moves a known door to where the later map has it.
        if let Some(memory) = self.memory {
            merge_entrances(&mut merged, memory);
        }
        // An agent may return anything as its map. One that cannot be parsed has no doors to merge.
        let maps = self
            .traces
            .iter()
            .filter_map(|t| OsmData::from_bytes(t.map.as_deref()?).ok());
        for map in maps {
            merge_entrances(&mut merged, &map);
        }
        merged
    }
}
