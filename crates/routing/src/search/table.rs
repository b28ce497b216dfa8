//! From each of many places to each of many.
//!
//! S. Knopp, P. Sanders, D. Schultes, F. Schulz, D. Wagner, *Computing many-to-many shortest paths using highway hierarchies*, 2007:
//! a search backwards from each target leaves in *buckets*, at the states it settles, how far the target is; a search from each source
//! looks into them. A search back ends on the border of the target's largest cell, one forwards goes on through all of the highest
//! layer.

use super::side::{Side, Tables};
use super::{End, Ends, Searched};
use crate::overlay::FAR;

/// Memory of tables, used again for the next one.
#[derive(Debug, Default)]
pub struct TableMemory {
    side: Side,
    ends: Ends,
    /// States with a target's number and how far it is.
    found: Vec<(u32, u32, u32)>,
    /// For each state its first bucket, and where the last one's end.
    first: Vec<u32>,
    /// Targets and how far they are.
    buckets: Vec<(u32, u32)>,
}

impl TableMemory {
    /// How far each of `targets` is from each of `sources`, one source after another; [`FAR`] where there is no way.
    pub fn weights(&mut self, graph: Searched<'_>, sources: &[Vec<End>], targets: &[Vec<End>]) -> Vec<u32> {
        self.fill_buckets(graph, targets);
        let mut table = vec![FAR; sources.len() * targets.len()];
        let tables = Tables::forward(graph);
        for (row, source) in table.chunks_exact_mut(targets.len().max(1)).zip(sources) {
            let Self { side, ends, first, buckets, .. } = self;
            search(graph, &tables, side, ends, source, usize::MAX, |state, weight| {
                let [begin, end] = [0, 1].map(|i| first[state as usize + i] as usize);
                for (target, away) in &buckets[begin..end] {
                    let cell = &mut row[*target as usize];
                    *cell = (*cell).min(weight + away);
                }
            });
        }
        table
    }

    fn fill_buckets(&mut self, graph: Searched<'_>, targets: &[Vec<End>]) {
        self.found.clear();
        let tables = Tables::backward(graph);
        let highest = graph.overlay.layers.len();
        for (target, ends) in (0..).zip(targets) {
            let found = &mut self.found;
            search(graph, &tables, &mut self.side, &mut self.ends, ends, highest, |state, weight| {
                found.push((state, target, weight));
            });
        }
        self.first.clear();
        self.first.resize(graph.overlay.out.states() + 1, 0);
        self.found.iter().for_each(|(state, ..)| self.first[*state as usize + 1] += 1);
        for i in 1..self.first.len() {
            self.first[i] += self.first[i - 1];
        }
        self.buckets.clear();
        self.buckets.resize(self.found.len(), (0, 0));
        for (state, target, weight) in self.found.iter().rev() {
            let end = &mut self.first[*state as usize + 1];
            *end -= 1;
            self.buckets[*end as usize] = (*target, *weight);
        }
        // What was the end of each state's buckets is their beginning now.
        self.first.remove(0);
        self.first.push(self.found.len() as u32);
    }
}

/// Settles all that can be reached; what takes part in the layer `highest` is shown, but not gone on from.
fn search(
    graph: Searched<'_>,
    tables: &Tables<'_>,
    side: &mut Side,
    ends: &mut Ends,
    begin: &[End],
    highest: usize,
    mut show: impl FnMut(u32, u32),
) {
    ends.set(graph.overlay, begin.iter().map(|end| end.state));
    side.begin(ends.labels(), begin);
    while let Some((label, weight)) = side.pop() {
        let layer = ends.layer_of_label(label);
        show(ends.state(graph.overlay, label), weight);
        if layer < highest || layer == 0 {
            side.go_on(tables, ends, label, weight, FAR, |_, _| {});
        }
    }
    side.clear();
}
