//! Other legs that are worth offering.

use std::collections::HashSet;

use super::ends::Memory;
use super::find::unpacked;
use super::travel::Leg;
use crate::metric::Metric;
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;
use crate::search::{Candidates, End, Path, Searched, Workspace};

/// How much heavier an alternative may be than the lightest leg, as a factor.
const MOST_STRETCH: f64 = 1.25;
/// The share of the lightest leg that an alternative may have in common with it.
const MOST_SHARED: f64 = 0.75;
/// How many candidates are examined.
const MOST_CANDIDATES: usize = 64;

impl Leg {
    /// The lightest leg and up to `others` alternatives, the lightest first.
    ///
    /// I. Abraham, D. Delling, A. Goldberg, R. Werneck, *Alternative routes in road networks*,
    /// 2013: a path through a place aside is admitted if it is at most a quarter heavier than the
    /// lightest one. It may share at most three quarters of that path and of those admitted before.
    /// It must be locally optimal: within a quarter of the lightest path's weight around that place
    /// there is no lighter path.
    pub fn alternatives(
        roads: &Roads,
        metric: &Metric,
        from: &[Position],
        to: &[Position],
        others: usize,
        memory: &mut Memory,
    ) -> Vec<Self> {
        let Some(best) = Self::find(roads, metric, from, to, memory) else {
            return Vec::new();
        };
        let mut legs = vec![best];
        if legs[0].edges.len() < 2 {
            return legs;
        }
        memory.hold(roads, metric, from, to);
        let graph = metric.searched(roads);
        let Memory {
            workspace,
            source_ends,
            target_ends,
            ..
        } = memory;
        let wanted = Candidates {
            stretch: MOST_STRETCH,
            most: MOST_CANDIDATES,
        };
        for candidate in workspace.candidates(graph, source_ends, target_ends, wanted) {
            if legs.len() > others {
                break;
            }
            let states = &candidate.states;
            let leg = unpacked(roads, metric, candidate.weight, states, memory);
            let leg = leg.trimmed(roads, metric);
            let Memory {
                workspace, path, ..
            } = memory;
            // The cheapest tests come first: the last one runs searches. A path through a place
            // joins two lightest paths, which may overlap: then a state appears twice.
            if leg.is_different(metric, &legs)
                && is_simple(states)
                && is_locally_optimal(graph, states, legs[0].weight, workspace, path)
            {
                legs.push(leg);
            }
        }
        legs
    }

    /// Whether it shares little enough with each of the known legs, the first of which is the
    /// lightest.
    fn is_different(&self, metric: &Metric, known: &[Self]) -> bool {
        let lightest = f64::from(known[0].weight);
        known.iter().all(|known| {
            // `edge_weight` counts the first and the last edge whole, and leaves out turns. It may
            // be more or less than the leg's own weight.
            let most = MOST_SHARED * known.edge_weight(metric).min(lightest);
            self.shared_weight(metric, known) <= most
        })
    }

    /// The weight of those edges that both have.
    fn shared_weight(&self, metric: &Metric, other: &Self) -> f64 {
        let others: HashSet<u32> = other.edges.iter().copied().collect();
        let shared = self.edges.iter().filter(|edge| others.contains(edge));
        shared
            .map(|edge| f64::from(metric.edges[*edge as usize].weight()))
            .sum()
    }

    /// The weight of all its edges.
    fn edge_weight(&self, metric: &Metric) -> f64 {
        self.edges
            .iter()
            .map(|edge| f64::from(metric.edges[*edge as usize].weight()))
            .sum()
    }
}

/// Whether no state appears twice.
fn is_simple(states: &[u32]) -> bool {
    let mut sorted = states.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|pair| pair[0] != pair[1])
}

/// Whether stretches of the path of twice a quarter of `best` are lightest paths themselves.
///
/// The paper examines the stretch around the place where the two search trees meet. That place is
/// not known here, so the whole path is examined in steps of a quarter of `best`.
fn is_locally_optimal(
    graph: Searched<'_>,
    states: &[u32],
    best: u32,
    workspace: &mut Workspace,
    path: &mut Path,
) -> bool {
    let stretch = best / 4;
    let along = weights_along(graph, states);
    // Windows of two stretches that begin one stretch apart: any part of the path that weighs up to
    // one stretch lies within one of them, up to the length of one arc.
    let mut first = 0;
    while first + 1 < states.len() {
        let reach = along[first] + 2 * stretch;
        // At least one arc, even if it alone weighs more than the window. `along` ascends, so that
        // both look-ups are binary searches.
        let end = along
            .partition_point(|a| *a <= reach)
            .clamp(first + 2, states.len())
            - 1;
        // Both ends are states of the path itself, so the weights between them can be compared.
        let [source, target] = [first, end].map(|i| {
            [End {
                state: states[i],
                weight: 0,
            }]
        });
        let lightest = workspace.route(graph, &source, &target, path);
        if lightest.is_none_or(|weight| weight < along[end] - along[first]) {
            return false;
        }
        if end + 1 == states.len() {
            return true;
        }
        first = along
            .partition_point(|a| *a <= along[first] + stretch)
            .max(first + 1);
    }
    true
}

/// For each state of a path the weight of the path up to it.
fn weights_along(graph: Searched<'_>, states: &[u32]) -> Vec<u32> {
    let mut along = vec![0_u32];
    for pair in states.windows(2) {
        let weight = lightest_arc(graph, pair[0], pair[1]);
        along.push(along[along.len() - 1].saturating_add(weight));
    }
    along
}

fn lightest_arc(graph: Searched<'_>, from: u32, to: u32) -> u32 {
    let out = &graph.overlay.out;
    // Of parallel arcs the search has taken the lightest.
    let slots = out.of(from).filter(|slot| out.head[*slot] == to);
    slots
        .map(|slot| graph.weights.out[slot])
        .min()
        .unwrap_or(FAR)
}
