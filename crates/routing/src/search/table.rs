//! Lightest paths from each of many places to each of many others.
//!
//! S. Knopp, P. Sanders, D. Schultes, F. Schulz, D. Wagner, *Computing many-to-many shortest paths
//! using highway hierarchies*, 2007: a backward search from each target leaves its distance in
//! *buckets* at the states that it settles; a forward search from each source scans them. A
//! backward search ends on the border of the target's largest cell, a forward search continues
//! through the whole highest layer.

use super::Workspace;
use super::graph::{End, Ends, Searched};
use super::side::{BEGUN, Side, Tables};
use super::values::{Value, Values};
use crate::overlay::FAR;

/// A state at which a search begins or ends, with the cost between it and the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValuedEnd {
    /// The state and the weight.
    pub end: End,
    /// What it takes.
    pub value: Value,
}

/// What a lightest path weighs and takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// [`FAR`] if there is no path.
    pub weight: u32,
    /// What it takes.
    pub value: Value,
}

impl Found {
    /// No path.
    const NOTHING: Self = Self {
        weight: FAR,
        value: Value {
            duration: 0,
            length: 0,
        },
    };
}

/// A target that a state reaches.
#[derive(Debug, Clone, Copy)]
struct Reached {
    /// Number of the target.
    target: u32,
    /// From the state to the target.
    away: Found,
}

/// Memory of tables, beside that of searches, which is used again for the next one.
#[derive(Debug, Default)]
pub struct TableMemory {
    /// For each label what it takes to reach it.
    value: Vec<Value>,
    /// States with the targets that they reach, in the order of the searches.
    found: Vec<(u32, Reached)>,
    /// For each state its first bucket, and the end of the last one's.
    first: Vec<u32>,
    /// The same as `found`, by state.
    buckets: Vec<Reached>,
}

impl TableMemory {
    /// The lightest paths from each of `sources` to each of `targets`, one source after another.
    /// Without `values` all paths take 0.
    pub fn table(
        &mut self,
        workspace: &mut Workspace,
        graph: Searched<'_>,
        values: Option<&Values>,
        sources: &[Vec<ValuedEnd>],
        targets: &[Vec<ValuedEnd>],
    ) -> Vec<Found> {
        self.fill_buckets(workspace, graph, values, targets);
        // A forward path joins the backward ones in the bucket of the state that it reaches. Of all
        // states the lightest sum is the lightest path.
        let mut table = vec![Found::NOTHING; sources.len() * targets.len()];
        let tables = Tables::forward(graph);
        // `max(1)`: chunks must not be empty, even if there are no targets.
        for (row, source) in table.chunks_exact_mut(targets.len().max(1)).zip(sources) {
            let Self {
                value,
                first,
                buckets,
                ..
            } = &mut *self;
            let mut search = Search::new(graph, &tables, values, workspace, value);
            search.run(source, usize::MAX, |state, reached| {
                let [begin, end] = [0, 1].map(|i| first[state as usize + i] as usize);
                for Reached { target, away } in &buckets[begin..end] {
                    let cell = &mut row[*target as usize];
                    let weight = reached.weight + away.weight;
                    if weight < cell.weight {
                        *cell = Found {
                            weight,
                            value: reached.value.plus(away.value),
                        };
                    }
                }
            });
        }
        table
    }

    /// Searches backward from each target, and sorts what was settled by state.
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
            let Self { value, found, .. } = &mut *self;
            let mut search = Search::new(graph, &tables, values, workspace, value);
            search.run(begin, highest, |state, away| {
                found.push((state, Reached { target, away }));
            });
        }
        self.sort_buckets(graph.overlay.out.states());
    }

    /// Sorts by counting.
    fn sort_buckets(&mut self, states: usize) {
        self.first.clear();
        self.first.resize(states + 1, 0);
        for (state, _) in &self.found {
            self.first[*state as usize + 1] += 1;
        }
        for i in 1..self.first.len() {
            self.first[i] += self.first[i - 1];
        }
        self.buckets.clear();
        self.buckets.resize(
            self.found.len(),
            Reached {
                target: 0,
                away: Found::NOTHING,
            },
        );
        // Backwards, because buckets are filled from their ends: each keeps the order of targets.
        for (state, reached) in self.found.iter().rev() {
            let end = &mut self.first[*state as usize + 1];
            *end -= 1;
            self.buckets[*end as usize] = *reached;
        }
        // The ends of the states' buckets have become their beginnings.
        self.first.remove(0);
        self.first.push(self.found.len() as u32);
    }
}

/// A search from one end to all that can be reached.
struct Search<'a> {
    graph: Searched<'a>,
    tables: &'a Tables<'a>,
    values: Option<&'a Values>,
    side: &'a mut Side,
    ends: &'a mut Ends,
    value: &'a mut Vec<Value>,
}

impl<'a> Search<'a> {
    fn new(
        graph: Searched<'a>,
        tables: &'a Tables<'a>,
        values: Option<&'a Values>,
        workspace: &'a mut Workspace,
        value: &'a mut Vec<Value>,
    ) -> Self {
        let Workspace {
            sides: [side, _],
            ends,
        } = workspace;
        Self {
            graph,
            tables,
            values,
            side,
            ends,
            value,
        }
    }

    /// Settles all that can be reached. States of the layer `highest` are shown, but the search
    /// does not continue from them.
    fn run(&mut self, begin: &[ValuedEnd], highest: usize, mut show: impl FnMut(u32, Found)) {
        self.ends.set(
            self.graph.overlay,
            begin.iter().map(|begin| begin.end.state),
        );
        let labels = self.ends.labels();
        // Old values need not be cleared: a label's value is written before it is read.
        if self.values.is_some() && self.value.len() < labels {
            self.value.resize(labels, Value::default());
        }
        let ends: Vec<End> = begin.iter().map(|begin| begin.end).collect();
        self.side.begin(labels, &ends);
        while let Some((label, weight)) = self.side.pop() {
            let value = self.settle(begin, label, weight);
            let state = self.ends.state(self.graph.overlay, label);
            show(state, Found { weight, value });
            let layer = self.ends.layer_of_label(label);
            if layer < highest || layer == 0 {
                self.side
                    .go_on(self.tables, self.ends, label, weight, FAR, |_, _| {});
            }
        }
        self.side.clear();
    }

    /// What it takes to reach a label, which is settled.
    fn settle(&mut self, begin: &[ValuedEnd], label: u32, weight: u32) -> Value {
        let Some(values) = self.values else {
            return Value::default();
        };
        let parent = self.side.parent(label);
        let value = if parent == BEGUN {
            let end = End {
                state: label,
                weight,
            };
            let first = begin.iter().find(|begin| begin.end == end);
            first.map_or(Value::default(), |first| first.value)
        } else {
            // The parent was settled before, so its value is final.
            self.value[parent as usize].plus(self.step(values, parent, label))
        };
        self.value[label as usize] = value;
        value
    }

    /// What the step from a label's parent to the label takes.
    fn step(&self, values: &Values, parent: u32, label: u32) -> Value {
        let [from, to] = if self.tables.backward {
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
