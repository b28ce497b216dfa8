//! One direction of a search.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::graph::{End, Ends, Searched};
use crate::overlay::{Arcs, Cliques, FAR, Layer, Overlay};

/// Flags the parent of a label that was reached straight through a cell.
const THROUGH: u32 = 1 << 31;
/// The parent of a label at which the search began.
pub(super) const BEGUN: u32 = THROUGH - 1;

/// The tables of one direction.
pub(super) struct Tables<'a> {
    pub(super) overlay: &'a Overlay,
    arcs: &'a Arcs,
    weights: &'a [u32],
    cliques: &'a [Cliques],
    pub(super) backward: bool,
}

impl<'a> Tables<'a> {
    pub(super) fn forward(graph: Searched<'a>) -> Self {
        let Searched {
            overlay,
            weights,
            cliques,
        } = graph;
        Self {
            overlay,
            arcs: &overlay.out,
            weights: &weights.out,
            cliques,
            backward: false,
        }
    }

    pub(super) fn backward(graph: Searched<'a>) -> Self {
        let Searched {
            overlay,
            weights,
            cliques,
        } = graph;
        Self {
            overlay,
            arcs: overlay.incoming(),
            weights: &weights.into,
            cliques,
            backward: true,
        }
    }

    /// The slots by which a slot's cell is left, beginning with the returned one, and their
    /// distances; `None` if the cell cannot be entered there.
    #[inline]
    fn row(&self, height: usize, slot: usize) -> Option<(usize, &'a [u32])> {
        let layer: &Layer = &self.overlay.layers[height];
        let cell = self.overlay.cell(height, layer.state[slot]);
        let (from, to) = if self.backward {
            (layer.exits(cell), layer.entries(cell))
        } else {
            (layer.entries(cell), layer.exits(cell))
        };
        // A slot that is an exit only is left by its arcs alone.
        if !from.contains(&slot) {
            return None;
        }
        let cliques = &self.cliques[height];
        let matrix = if self.backward {
            &cliques.columns
        } else {
            &cliques.rows
        };
        let begin = layer.matrix[cell as usize] as usize + (slot - from.start) * to.len();
        Some((to.start, &matrix[begin..begin + to.len()]))
    }
}

/// The labels that one direction has reached.
#[derive(Debug, Default)]
pub(super) struct Side {
    /// For each label its distance; [`FAR`] if it was not reached.
    weight: Vec<u32>,
    parent: Vec<u32>,
    /// The labels that were reached.
    touched: Vec<u32>,
    heap: BinaryHeap<Reverse<u64>>,
    /// The labels at which the search began.
    pub(super) begun: Vec<u32>,
}

impl Side {
    pub(super) fn begin(&mut self, labels: usize, ends: &[End]) {
        if self.weight.len() < labels {
            self.weight.resize(labels, FAR);
            self.parent.resize(labels, BEGUN);
        }
        for end in ends {
            if self.reach(end.state, end.weight, BEGUN) {
                self.begun.push(end.state);
            }
        }
    }

    pub(super) fn clear(&mut self) {
        // Only what the search reached, so that a short search on a large map costs little.
        for label in self.touched.drain(..) {
            self.weight[label as usize] = FAR;
        }
        self.heap.clear();
        self.begun.clear();
    }

    #[inline]
    pub(super) fn weight(&self, label: u32) -> u32 {
        self.weight[label as usize]
    }

    /// All labels that were reached.
    pub(super) fn reached(&self) -> impl Iterator<Item = u32> + '_ {
        self.touched.iter().copied()
    }

    pub(super) fn parent(&self, label: u32) -> u32 {
        self.parent[label as usize] & !THROUGH
    }

    /// Whether a label was reached straight through a cell.
    pub(super) fn is_through(&self, label: u32) -> bool {
        self.parent[label as usize] & THROUGH != 0
    }

    /// The distance of the next label.
    #[inline]
    pub(super) fn next(&mut self) -> u32 {
        while let Some(Reverse(top)) = self.heap.peek() {
            let (weight, label) = ((top >> 32) as u32, *top as u32);
            // Entries of the heap are not moved when a label gets a lighter path. Those whose
            // weight has changed since are outdated.
            if weight == self.weight[label as usize] {
                return weight;
            }
            self.heap.pop();
        }
        FAR
    }

    /// Stores a path to a label if it is the shortest so far. Returns whether it is.
    #[inline]
    fn reach(&mut self, label: u32, weight: u32, parent: u32) -> bool {
        let before = &mut self.weight[label as usize];
        if weight >= *before {
            return false;
        }
        if *before == FAR {
            self.touched.push(label);
        }
        *before = weight;
        self.parent[label as usize] = parent;
        self.heap
            // One number sorts by weight, then by label, so that the order of equal weights is
            // fixed.
            .push(Reverse(u64::from(weight) << 32 | u64::from(label)));
        true
    }

    /// The next label and its distance.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<(u32, u32)> {
        while let Some(Reverse(top)) = self.heap.pop() {
            let (weight, label) = ((top >> 32) as u32, top as u32);
            if weight == self.weight[label as usize] {
                return Some((label, weight));
            }
        }
        None
    }

    /// Continues from a label, below `limit`. Shows labels that are reached for the first time or
    /// by a shorter path.
    #[inline]
    pub(super) fn go_on(
        &mut self,
        tables: &Tables<'_>,
        ends: &Ends,
        label: u32,
        weight: u32,
        limit: u32,
        mut show: impl FnMut(u32, u32),
    ) {
        let height = ends.layer_of_label(label);
        let state = if height == 0 {
            label
        } else {
            let (base, slot) = (ends.base[height], (label - ends.base[height]) as usize);
            let through = self.parent[label as usize] & THROUGH != 0;
            // Two paths through one cell are never joined: the direct one is at least as light.
            if let Some((first, row)) = tables.row(height - 1, slot).filter(|_| !through) {
                self.cross(base + first as u32, row, weight, label, limit, &mut show);
            }
            tables.overlay.layers[height - 1].state[slot]
        };
        for arc in tables.arcs.of(state) {
            let reached = weight + tables.weights[arc];
            // In layer `height` only arcs that leave the cell count. Those inside are in its
            // matrix.
            if usize::from(tables.arcs.border[arc]) < height || reached >= limit {
                continue;
            }
            let head = tables.arcs.head[arc];
            let layer = ends.layer(tables.overlay, head);
            let to = ends.base[layer] + tables.overlay.index(layer, head);
            if self.reach(to, reached, label) {
                show(to, reached);
            }
        }
    }

    /// From a cell's entry to its exits.
    #[inline]
    fn cross(
        &mut self,
        first: u32,
        row: &[u32],
        weight: u32,
        from: u32,
        limit: u32,
        show: &mut impl FnMut(u32, u32),
    ) {
        for (to, through) in (first..).zip(row) {
            let reached = weight + through;
            if reached < limit && self.reach(to, reached, from | THROUGH) {
                show(to, reached);
            }
        }
    }
}
