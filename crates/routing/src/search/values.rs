//! Durations and lengths of lightest paths, beside their weights.
//!
//! A table asks for durations and lengths of paths that are chosen by weight. Both are summed up
//! once along the trees of customization, for each path through a cell, so that a search can carry
//! them along.

use rayon::prelude::*;

use super::graph::Searched;
use crate::overlay::{FAR, Layer};

/// What a path takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Value {
    /// Hundredths of a second.
    pub duration: u32,
    /// Centimetres.
    pub length: u32,
}

impl Value {
    /// The sum of both, the largest number at most.
    #[must_use]
    #[inline]
    pub fn plus(self, other: Self) -> Self {
        Self {
            duration: self.duration.saturating_add(other.duration),
            length: self.length.saturating_add(other.length),
        }
    }
}

/// Values of arcs and of paths through cells.
#[derive(Debug, Clone, Default)]
pub struct Values {
    /// In the order of the arcs that leave states.
    arcs: Vec<Value>,
    /// For each layer in the order of its matrices.
    rows: Vec<Vec<Value>>,
}

impl Values {
    /// Sums up the values of arcs, which are in the order of
    /// [`Overlay::out`](crate::overlay::Overlay::out).
    pub fn new(graph: Searched<'_>, arcs: Vec<Value>) -> Self {
        let mut values = Self {
            arcs,
            rows: Vec::new(),
        };
        // From below, because a path through a cell is made of paths through its subcells.
        for (height, layer) in graph.overlay.layers.iter().enumerate() {
            let cells = (0..layer.cells() as u32).into_par_iter();
            let rows: Vec<Vec<Value>> = cells
                .map(|cell| values.cell(graph, height, layer, cell))
                .collect();
            values.rows.push(rows.concat());
        }
        values
    }

    /// The values of a cell's matrix, row by row.
    fn cell(&self, graph: Searched<'_>, height: usize, layer: &Layer, cell: u32) -> Vec<Value> {
        let cliques = &graph.cliques[height];
        let (inner, exits) = (layer.inner(cell), layer.exits(cell));
        let mut rows = Vec::new();
        for (row, entry) in layer.entries(cell).enumerate() {
            let matrix = layer.matrix[cell as usize] as usize + row * exits.len();
            let begin = layer.trees[cell as usize] as usize + row * inner.len();
            let tree = &cliques.trees[begin..begin + inner.len()];
            let first = layer.below[entry] as usize - inner.start;
            for (exit, weight) in exits.clone().zip(&cliques.rows[matrix..]) {
                let mut value = Value::default();
                let mut last = layer.below[exit] as usize - inner.start;
                // Back along the tree, from the exit to the entry.
                while *weight < FAR && last != first {
                    let before = usize::from(tree[last]);
                    let [from, to] = [before, last].map(|local| (inner.start + local) as u32);
                    value = value.plus(self.below(graph, height, from, to));
                    last = before;
                }
                rows.push(value);
            }
        }
        rows
    }

    /// From one index in the layer below to the next.
    fn below(&self, graph: Searched<'_>, height: usize, from: u32, to: u32) -> Value {
        let Some(lower) = height.checked_sub(1) else {
            return self.arc(graph, from, to);
        };
        let layer = &graph.overlay.layers[lower];
        let [a, b] = [from, to].map(|slot| layer.state[slot as usize]);
        let [p, q] = [a, b].map(|state| graph.overlay.cell(lower, state));
        if p == q {
            self.through(graph, lower, from, to)
        } else {
            self.arc(graph, a, b)
        }
    }

    /// Through a cell, from an entry to an exit, by their slots.
    pub(super) fn through(
        &self,
        graph: Searched<'_>,
        height: usize,
        entry: u32,
        exit: u32,
    ) -> Value {
        let layer = &graph.overlay.layers[height];
        let cell = graph.overlay.cell(height, layer.state[entry as usize]);
        let (entries, exits) = (layer.entries(cell), layer.exits(cell));
        let matrix = layer.matrix[cell as usize] as usize;
        self.rows[height]
            [matrix + (entry as usize - entries.start) * exits.len() + exit as usize - exits.start]
    }

    /// Along the lightest arc from one state to another.
    pub(super) fn arc(&self, graph: Searched<'_>, from: u32, to: u32) -> Value {
        let out = &graph.overlay.out;
        let slots = out.of(from).filter(|slot| out.head[*slot] == to);
        slots
            .min_by_key(|slot| graph.weights.out[*slot])
            .map_or(Value::default(), |slot| self.arcs[slot])
    }
}
