//! The lightest leg.

use super::ends::{Hold, Memory};
use super::travel::{Leg, Measures, cost_before};
use crate::metric::{Metric, PassingCost};
use crate::network::Network;
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;

impl Leg {
    /// The lightest leg from one of some positions to one of others; `None` if there is none.
    pub fn find(
        roads: &Roads,
        metric: &Metric,
        from: &[Position],
        to: &[Position],
        memory: &mut Memory,
    ) -> Option<Self> {
        // A search leaves the first edge at its end and enters the last one at its begin. It cannot
        // find a leg within one edge, which is compared with what it finds.
        let straight = along_one_edge(metric, from, to);
        memory.hold(roads, metric, from, to);
        let Memory {
            workspace,
            path,
            source_ends,
            target_ends,
            ..
        } = memory;
        let graph = metric.searched(roads);
        let around = workspace.route(graph, source_ends, target_ends, path);
        match (straight, around) {
            (Some(straight), None) => Some(straight),
            (Some(straight), Some(weight)) if straight.weight <= weight => Some(straight),
            (_, Some(weight)) => {
                let leg = unpacked(roads, metric, weight, &memory.path.states, memory);
                Some(leg.trimmed(roads, metric))
            }
            (None, None) => None,
        }
    }

    /// Drops edges at its ends of which nothing is travelled and at which nothing else is to be
    /// done: the place is at the end of the next edge, too.
    pub(super) fn trimmed(mut self, roads: &Roads, metric: &Metric) -> Self {
        while let [first, second, ..] = self.edges[..] {
            let is_free = metric.entry_weight(roads, first, second) == 0;
            if !(is_free && self.takes_nothing(roads, metric, 0)) {
                break;
            }
            self.edges.remove(0);
            self.from = at_begin(&roads.network, &self.from, second);
        }
        while let [.., before, last] = self.edges[..] {
            let is_free = metric.passing(roads, before, last) == PassingCost::default();
            if !(is_free && self.takes_nothing(roads, metric, self.edges.len() - 1)) {
                break;
            }
            self.edges.pop();
            self.to = at_end(&roads.network, &self.to, before);
        }
        self
    }

    /// Whether nothing is travelled of the edge of that index, and passing it costs nothing.
    fn takes_nothing(&self, roads: &Roads, metric: &Metric, index: usize) -> bool {
        let [begin, end] = self.travelled(index);
        begin == end && self.measures(roads, metric, index) == Measures::default()
    }
}

/// The same place as the begin of a directed edge.
fn at_begin(network: &Network, position: &Position, directed: u32) -> Position {
    at_vertex(network, position, directed / 2, !directed.is_multiple_of(2))
}

/// The same place as the end of a directed edge.
fn at_end(network: &Network, position: &Position, directed: u32) -> Position {
    at_vertex(network, position, directed / 2, directed.is_multiple_of(2))
}

/// The same place as the first or the last vertex of an edge.
fn at_vertex(network: &Network, position: &Position, edge: u32, is_last: bool) -> Position {
    let segments = network.edge_points(edge).len() as u32 - 1;
    let (share, segment) = if is_last {
        (1.0, segments - 1)
    } else {
        (0.0, 0)
    };
    Position {
        edge,
        share,
        segment,
        ..*position
    }
}

/// The lightest leg along a single edge.
pub(super) fn along_one_edge(metric: &Metric, from: &[Position], to: &[Position]) -> Option<Leg> {
    let mut lightest: Option<Leg> = None;
    for a in from {
        for b in to.iter().filter(|b| b.edge == a.edge) {
            for directed in [2 * a.edge, 2 * a.edge + 1] {
                let Some(leg) = along(metric, directed, a, b) else {
                    continue;
                };
                if lightest
                    .as_ref()
                    .is_none_or(|lightest| leg.weight < lightest.weight)
                {
                    lightest = Some(leg);
                }
            }
        }
    }
    lightest
}

/// The leg between two positions along their edge, in one direction.
fn along(metric: &Metric, directed: u32, from: &Position, to: &Position) -> Option<Leg> {
    let whole = metric.edges[directed as usize].weight();
    let is_ahead = from.share_before(directed) <= to.share_before(directed);
    let is_open = from.open[directed as usize % 2] && to.open[directed as usize % 2];
    if whole >= FAR || !is_ahead || !is_open {
        return None;
    }
    let weight = cost_before(whole, to, directed) - cost_before(whole, from, directed);
    Some(Leg {
        weight,
        edges: vec![directed],
        from: *from,
        to: *to,
    })
}

/// The leg that a path of states stands for, between the ends that `memory` holds.
pub(super) fn unpacked(
    roads: &Roads,
    metric: &Metric,
    weight: u32,
    states: &[u32],
    memory: &Memory,
) -> Leg {
    let [first, last] = [states[0], states[states.len() - 1]];
    // Several positions may hold the same state. The search used the lightest.
    let source = lightest_at(&memory.sources, first);
    let target = lightest_at(&memory.targets, last);
    let mut edges = match &metric.turns {
        // A state is a directed edge, the first of which is the source's own.
        Some(turns) => states
            .iter()
            .map(|state| turns.edge_of[*state as usize])
            .collect(),
        None => edges_between(roads, metric, source, states),
    };
    // The path ends at the begin of the target's edge, which is still to be travelled.
    edges.extend(target.map(|hold| hold.directed));
    // A search begins and ends with what was held.
    let from = source.unwrap_or(&memory.sources[0]).position;
    let to = target.unwrap_or(&memory.targets[0]).position;
    Leg {
        weight,
        edges,
        from,
        to,
    }
}

fn lightest_at(holds: &[Hold], state: u32) -> Option<&Hold> {
    holds
        .iter()
        .filter(|hold| hold.end.state == state)
        .min_by_key(|hold| hold.end.weight)
}

/// The edge on which a leg begins, and the lightest arcs along its vertices.
fn edges_between(
    roads: &Roads,
    metric: &Metric,
    source: Option<&Hold>,
    vertices: &[u32],
) -> Vec<u32> {
    let graph = metric.searched(roads);
    let (out, weights) = (&graph.overlay.out, &graph.weights.out);
    let arcs = vertices.windows(2).filter_map(|pair| {
        // Parallel edges join the same two vertices. The search used the lightest.
        let slots = out.of(pair[0]).filter(|slot| out.head[*slot] == pair[1]);
        slots
            .min_by_key(|slot| weights[*slot])
            .map(|slot| out.via[slot])
    });
    source
        .map(|hold| hold.directed)
        .into_iter()
        .chain(arcs)
        .collect()
}
