//! Strongly connected components: parts of the network in which every place can be reached from
//! every other.
//!
//! R. Tarjan, *Depth-first search and linear graph algorithms*, 1972.

use crate::costs::Costs;
use crate::overlay::{Arcs, FAR, NONE};
use crate::roads::Roads;
use crate::search::Searched;
use crate::turns::TurnGraph;

/// A component of this size is large, however large others are.
// OSRM's `--small-component-size`, below which a component is "tiny".
const LARGE_STATES: usize = 1000;

/// The component of each edge.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Components {
    /// For each edge its component; [`NONE`] if it is connected with nothing but itself.
    of_edge: Vec<u32>,
    /// For each component whether it is large.
    large: Vec<bool>,
}

impl Components {
    /// The components of a graph with the costs that its weights were made from. `turns` are the
    /// states of the graph, if these are directed edges.
    pub(crate) fn new(
        roads: &Roads,
        costs: &Costs<'_>,
        turns: Option<&TurnGraph>,
        graph: Searched<'_>,
    ) -> Self {
        let of_state = strong_components(&graph.overlay.out, &graph.weights.out);
        let sizes = sizes(&of_state);
        let largest = sizes.iter().max().map_or(0, |size| *size);
        let large = sizes
            .iter()
            // On a map of fewer states the largest component counts, however small it is.
            .map(|size| *size >= largest.min(LARGE_STATES))
            .collect();
        let of_directed = |directed: u32| match turns {
            Some(turns) => {
                let components = turns
                    .states_of(directed)
                    .map(|state| of_state[state as usize]);
                components.max_by_key(|component| sizes[*component as usize])
            }
            None => of_side(roads, costs, &of_state, directed),
        };
        // An edge belongs to the largest component of its open directions.
        let of_edge = (0..roads.network.edge_count() as u32).map(|edge| {
            let sides = [2 * edge, 2 * edge + 1];
            let open = sides
                .into_iter()
                .filter(|side| costs.edges[*side as usize].is_open());
            let components = open.filter_map(of_directed);
            components
                .max_by_key(|component| sizes[*component as usize])
                .unwrap_or(NONE)
        });
        Self {
            of_edge: of_edge.collect(),
            large,
        }
    }

    /// The component of an edge.
    pub(crate) fn of(&self, edge: u32) -> Option<u32> {
        Some(self.of_edge[edge as usize]).filter(|component| *component != NONE)
    }

    /// Whether an edge is in a large component.
    pub(crate) fn is_large(&self, edge: u32) -> bool {
        self.of(edge)
            .is_some_and(|component| self.large[component as usize])
    }
}

/// For each component the number of its states.
fn sizes(of_state: &[u32]) -> Vec<usize> {
    let count = of_state.iter().max().map_or(0, |last| *last as usize + 1);
    let mut sizes = vec![0; count];
    for component in of_state {
        sizes[*component as usize] += 1;
    }
    sizes
}

/// The component from which an open directed edge can be entered and to which it leads.
fn of_side(roads: &Roads, costs: &Costs<'_>, of_vertex: &[u32], directed: u32) -> Option<u32> {
    let [from, to] = roads.network.ends(directed);
    // The edge is entered from `from`. It belongs to that component if a traveller on it can get
    // back into it: over `to`, or by turning round where `to` is a barrier.
    let component = of_vertex[from as usize];
    let can_pass = |vertex: u32| costs.vertices[vertex as usize].weight() < FAR;
    let onwards = can_pass(to) && of_vertex[to as usize] == component;
    let back = costs.edges[(directed ^ 1) as usize].is_open() && can_pass(from);
    (onwards || back).then_some(component)
}

/// For each state its component. Components that can be reached from others have lower numbers.
fn strong_components(arcs: &Arcs, weights: &[u32]) -> Vec<u32> {
    let states = arcs.states();
    let mut search = Tarjan {
        arcs,
        weights,
        number: vec![NONE; states],
        low: vec![0; states],
        component: vec![NONE; states],
        open: Vec::new(),
        numbers: 0,
        components: 0,
    };
    for state in 0..states as u32 {
        if search.number[state as usize] == NONE {
            search.from(state);
        }
    }
    search.component
}

struct Tarjan<'a> {
    arcs: &'a Arcs,
    weights: &'a [u32],
    /// The order in which states were found.
    number: Vec<u32>,
    /// The lowest number of a state that can be reached.
    low: Vec<u32>,
    component: Vec<u32>,
    /// States whose component is not complete yet.
    open: Vec<u32>,
    numbers: u32,
    components: u32,
}

impl Tarjan<'_> {
    fn from(&mut self, state: u32) {
        // The states on the path, each with its next arc. (Recursion would overflow the stack.)
        let mut way = vec![(state, self.find(state))];
        while let Some((state, slot)) = way.last_mut() {
            let state = *state;
            // One arc for each turn of the loop, so that a state that is found is explored first.
            if *slot < self.arcs.first[state as usize + 1] {
                let arc = *slot as usize;
                *slot += 1;
                let head = self.arcs.head[arc];
                if self.weights[arc] >= FAR {
                    continue;
                }
                if self.number[head as usize] == NONE {
                    way.push((head, self.find(head)));
                } else if self.component[head as usize] == NONE {
                    // A state of a complete component cannot lead back here: it would be in this
                    // one. Only open states lower `low`.
                    self.low[state as usize] =
                        self.low[state as usize].min(self.number[head as usize]);
                }
                continue;
            }
            way.pop();
            // All arcs are done: what the state reaches, the one before it reaches too.
            if let Some((before, _)) = way.last() {
                self.low[*before as usize] =
                    self.low[*before as usize].min(self.low[state as usize]);
            }
            // Nothing found earlier can be reached: the state is the root of its component. Its
            // members are the states above it on the stack of open ones.
            if self.low[state as usize] == self.number[state as usize] {
                self.complete(state);
            }
        }
    }

    /// Numbers a state, and returns its first arc.
    fn find(&mut self, state: u32) -> u32 {
        self.number[state as usize] = self.numbers;
        self.low[state as usize] = self.numbers;
        self.numbers += 1;
        self.open.push(state);
        self.arcs.first[state as usize]
    }

    fn complete(&mut self, state: u32) {
        while let Some(member) = self.open.pop() {
            self.component[member as usize] = self.components;
            if member == state {
                break;
            }
        }
        self.components += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlay::Arc;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn states_are_together_if_each_reaches_the_other(
            edges in proptest::collection::vec((0_u32..12, 0_u32..12, any::<bool>()), 0..40),
        ) {
            let arcs = edges.iter().zip(0..);
            let arcs = arcs.map(|((a, b, _), via)| Arc { from: *a, to: *b, via });
            let arcs = Arcs::new(12, arcs);
            let weight = |via: &u32| if edges[*via as usize].2 { 1 } else { FAR };
            let weights: Vec<u32> = arcs.via.iter().map(weight).collect();
            let mut reaches = [[false; 12]; 12];
            (0..12).for_each(|i| reaches[i][i] = true);
            for _ in 0..12 {
                for (a, b, _) in edges.iter().filter(|edge| edge.2) {
                    for row in &mut reaches {
                        row[*b as usize] |= row[*a as usize];
                    }
                }
            }
            let components = strong_components(&arcs, &weights);
            for a in 0..12 {
                for b in 0..12 {
                    prop_assert_eq!(components[a] == components[b], reaches[a][b] && reaches[b][a]);
                }
            }
        }
    }
}
