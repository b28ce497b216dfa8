//! From each of many places to each of many.
//!
//! S. Knopp, P. Sanders, D. Schultes, F. Schulz, D. Wagner, *Computing many-to-many shortest paths using highway hierarchies*, 2007:
//! a search backwards from each target leaves in *buckets*, at the states it settles, how far the target is; a search from each source
//! looks into them. A search back ends on the border of the target's largest cell, one forwards goes on through all of the highest
//! layer.

use super::Workspace;
use super::graph::{End, Ends, Searched};
use super::side::{BEGUN, Side, Tables};
use super::values::{Value, Values, plus};
use crate::overlay::FAR;

/// A state with what reaching it (or going on from it) counts as and takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValuedEnd {
    /// The state and the weight.
    pub end: End,
    /// What it takes.
    pub value: Value,
}

/// What a lightest way weighs and takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// [`FAR`] if there is no way.
    pub weight: u32,
    /// What it takes.
    pub value: Value,
}

/// Memory of tables, beside that of searches, used again for the next one.
#[derive(Debug, Default)]
pub struct TableMemory {
    /// For each label what it takes to reach it.
    value: Vec<Value>,
    /// States with a target's number and how far it is.
    found: Vec<(u32, u32, Found)>,
    /// For each state its first bucket, and where the last one's end.
    first: Vec<u32>,
    /// Targets and how far they are.
    buckets: Vec<(u32, Found)>,
}

impl TableMemory {
    /// How far each of `targets` is from each of `sources`, one source after another. Without `values` all take 0.
    pub fn table(
        &mut self,
        workspace: &mut Workspace,
        graph: Searched<'_>,
        values: Option<&Values>,
        sources: &[Vec<ValuedEnd>],
        targets: &[Vec<ValuedEnd>],
    ) -> Vec<Found> {
        self.fill_buckets(workspace, graph, values, targets);
        let mut table = vec![
            Found {
                weight: FAR,
                value: [0, 0]
            };
            sources.len() * targets.len()
        ];
        let tables = Tables::forward(graph);
        for (row, source) in table.chunks_exact_mut(targets.len().max(1)).zip(sources) {
            let (
                Workspace {
                    sides: [side, _],
                    ends,
                },
                Self {
                    value,
                    first,
                    buckets,
                    ..
                },
            ) = (&mut *workspace, &mut *self);
            let mut search = Search {
                graph,
                tables: &tables,
                values,
                backward: false,
                side,
                ends,
                value,
            };
            search.run(source, usize::MAX, |state, reached| {
                let [begin, end] = [0, 1].map(|i| first[state as usize + i] as usize);
                for (target, away) in &buckets[begin..end] {
                    let cell = &mut row[*target as usize];
                    let weight = reached.weight + away.weight;
                    if weight < cell.weight {
                        *cell = Found {
                            weight,
                            value: plus(reached.value, away.value),
                        };
                    }
                }
            });
        }
        table
    }

    fn fill_buckets(
        &mut self,
        workspace: &mut Workspace,
        graph: Searched<'_>,
        values: Option<&Values>,
        targets: &[Vec<ValuedEnd>],
    ) {
        self.found.clear();
        let tables = Tables::backward(graph);
        let highest = graph.overlay.layers.len();
        for (target, begin) in (0..).zip(targets) {
            let (
                Workspace {
                    sides: [side, _],
                    ends,
                },
                Self { value, found, .. },
            ) = (&mut *workspace, &mut *self);
            let mut search = Search {
                graph,
                tables: &tables,
                values,
                backward: true,
                side,
                ends,
                value,
            };
            search.run(begin, highest, |state, reached| {
                found.push((state, target, reached))
            });
        }
        self.first.clear();
        self.first.resize(graph.overlay.out.states() + 1, 0);
        self.found
            .iter()
            .for_each(|(state, ..)| self.first[*state as usize + 1] += 1);
        for i in 1..self.first.len() {
            self.first[i] += self.first[i - 1];
        }
        self.buckets.clear();
        self.buckets.resize(
            self.found.len(),
            (
                0,
                Found {
                    weight: FAR,
                    value: [0, 0],
                },
            ),
        );
        for (state, target, away) in self.found.iter().rev() {
            let end = &mut self.first[*state as usize + 1];
            *end -= 1;
            self.buckets[*end as usize] = (*target, *away);
        }
        // What was the end of each state's buckets is their beginning now.
        self.first.remove(0);
        self.first.push(self.found.len() as u32);
    }
}

/// A search from one end to all that can be reached.
struct Search<'a> {
    graph: Searched<'a>,
    tables: &'a Tables<'a>,
    values: Option<&'a Values>,
    backward: bool,
    side: &'a mut Side,
    ends: &'a mut Ends,
    value: &'a mut Vec<Value>,
}

impl Search<'_> {
    /// Settles all that can be reached; what takes part in the layer `highest` is shown, but not gone on from.
    fn run(&mut self, begin: &[ValuedEnd], highest: usize, mut show: impl FnMut(u32, Found)) {
        self.ends.set(
            self.graph.overlay,
            begin.iter().map(|begin| begin.end.state),
        );
        let labels = self.ends.labels();
        if self.values.is_some() && self.value.len() < labels {
            self.value.resize(labels, [0, 0]);
        }
        let ends: Vec<End> = begin.iter().map(|begin| begin.end).collect();
        self.side.begin(labels, &ends);
        while let Some((label, weight)) = self.side.pop() {
            let value = self.reach(begin, label, weight);
            show(
                self.ends.state(self.graph.overlay, label),
                Found { weight, value },
            );
            let layer = self.ends.layer_of_label(label);
            if layer < highest || layer == 0 {
                self.side
                    .go_on(self.tables, self.ends, label, weight, FAR, |_, _| {});
            }
        }
        self.side.clear();
    }

    /// What it takes to reach a label, which is settled.
    fn reach(&mut self, begin: &[ValuedEnd], label: u32, weight: u32) -> Value {
        let Some(values) = self.values else {
            return [0, 0];
        };
        let parent = self.side.parent(label);
        let value = if parent == BEGUN {
            let first = begin.iter().find(|begin| {
                begin.end
                    == End {
                        state: label,
                        weight,
                    }
            });
            first.map_or([0, 0], |first| first.value)
        } else {
            plus(
                self.value[parent as usize],
                self.step(values, parent, label),
            )
        };
        self.value[label as usize] = value;
        value
    }

    fn step(&self, values: &Values, parent: u32, label: u32) -> Value {
        let [from, to] = if self.backward {
            [label, parent]
        } else {
            [parent, label]
        };
        if self.side.is_through(label) {
            let layer = self.ends.layer_of_label(label);
            let base = self.ends.base[layer];
            return values.through(self.graph, layer - 1, from - base, to - base);
        }
        let [from, to] = [from, to].map(|label| self.ends.state(self.graph.overlay, label));
        values.arc(self.graph, from, to)
    }
}
