//! Where a search begins and ends for places within edges.
//!
//! A search settles vertices, or directed edges where turns matter. A place within an edge is
//! therefore represented by *holds*: for each direction in which its edge can be left or reached,
//! a state of the search and the cost between that state and the place.

use super::travel::{cost_before, part};
use crate::costs::centimetres;
use crate::metric::Metric;
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;
use crate::search::{End, Path, Value, Workspace};

/// A directed edge at one of a leg's ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    pub(super) directed: u32,
    pub(super) position: Position,
    pub(super) end: End,
    /// What the part of the edge takes.
    pub(super) value: Value,
}

/// Memory of finding legs, which is used again for the next one.
#[derive(Debug, Default)]
pub struct Memory {
    pub(super) workspace: Workspace,
    pub(super) path: Path,
    pub(super) sources: Vec<Hold>,
    pub(super) targets: Vec<Hold>,
    /// The states of both.
    pub(super) source_ends: Vec<End>,
    pub(super) target_ends: Vec<End>,
}

impl Memory {
    /// Collects the directed edges on which a leg can begin and end.
    pub(super) fn hold(
        &mut self,
        roads: &Roads,
        metric: &Metric,
        from: &[Position],
        to: &[Position],
    ) {
        self.sources.clear();
        let sources = open_sides(metric, from);
        self.sources
            .extend(sources.map(|side| source(roads, metric, side)));
        self.targets.clear();
        for side in open_sides(metric, to) {
            self.hold_target(roads, metric, side);
        }
        // Weights from `FAR` on are places behind an impassable vertex. Searches expect lower ones.
        self.sources.retain(|hold| hold.end.weight < FAR);
        self.targets.retain(|hold| hold.end.weight < FAR);
        self.source_ends.clear();
        self.source_ends
            .extend(self.sources.iter().map(|hold| hold.end));
        self.target_ends.clear();
        self.target_ends
            .extend(self.targets.iter().map(|hold| hold.end));
    }

    /// Collects the states from which a place can be reached along a directed edge.
    fn hold_target(&mut self, roads: &Roads, metric: &Metric, side: Side) {
        let Side { directed, position } = side;
        let cost = metric.edges[directed as usize];
        let weight = cost_before(cost.weight(), &position, directed);
        let duration = cost_before(cost.duration(), &position, directed);
        let whole = centimetres(&roads.network, directed);
        let length = part(whole, position.share_before(directed));
        let Some(turns) = &metric.turns else {
            // The search ends where the edge begins. The part up to the place is in the end's
            // weight.
            let [state, _] = roads.network.ends(directed);
            let weight = metric.costs().edge_weight(&roads.network, directed, weight);
            let end = End { state, weight };
            let value = Value { duration, length };
            return self.targets.push(Hold {
                directed,
                position,
                end,
                value,
            });
        };
        // One hold for each turn into the edge.
        let graph = metric.searched(roads);
        let incoming = graph.overlay.incoming();
        let slots = turns
            .states_of(directed)
            .flat_map(|state| incoming.of(state));
        // The states on the edge itself would be settled only at its end, beyond the place.
        for slot in slots.filter(|slot| graph.weights.into[*slot] < FAR) {
            let from = incoming.head[slot];
            let end = End {
                state: from,
                // The arc's weight contains the turn and the whole edge. The edge is replaced by
                // its part before the place. No underflow: a weight below `FAR` was not cut off,
                // and contains the edge.
                weight: graph.weights.into[slot] - cost.weight() + weight,
            };
            let passed = metric.passing(roads, turns.edge_of[from as usize], directed);
            let value = Value {
                duration: duration + passed.duration,
                length,
            };
            self.targets.push(Hold {
                directed,
                position,
                end,
                value,
            });
        }
    }
}

/// A direction in which a place can be left or reached.
#[derive(Debug, Clone, Copy)]
struct Side {
    directed: u32,
    position: Position,
}

fn open_sides<'a>(
    metric: &'a Metric,
    positions: &'a [Position],
) -> impl Iterator<Item = Side> + 'a {
    let sides = positions.iter().flat_map(|at| {
        [0, 1].map(|side| Side {
            directed: 2 * at.edge + side,
            position: *at,
        })
    });
    sides.filter(|side| {
        side.position.open[side.directed as usize % 2]
            && metric.edges[side.directed as usize].is_open()
    })
}

/// The state in which a leg continues that leaves a place along a directed edge.
fn source(roads: &Roads, metric: &Metric, side: Side) -> Hold {
    let Side { directed, position } = side;
    let cost = metric.edges[directed as usize];
    let weight = cost.weight() - cost_before(cost.weight(), &position, directed);
    let duration = cost.duration() - cost_before(cost.duration(), &position, directed);
    let whole = centimetres(&roads.network, directed);
    let length = part(whole, 1.0 - position.share_before(directed));
    match &metric.turns {
        Some(turns) => {
            let end = End {
                // The edge alone, without a prefix of a restriction: no road has been travelled
                // before.
                state: turns.state_of[directed as usize],
                weight,
            };
            Hold {
                directed,
                position,
                end,
                value: Value { duration, length },
            }
        }
        None => {
            let [_, state] = roads.network.ends(directed);
            // Arcs carry the vertex at their end, and so does this part of an edge. `hold` drops
            // the result if the vertex cannot be passed.
            let passed = metric.vertices[state as usize];
            let end = End {
                state,
                weight: weight + passed.weight(),
            };
            let value = Value {
                duration: duration + passed.duration(),
                length,
            };
            Hold {
                directed,
                position,
                end,
                value,
            }
        }
    }
}
