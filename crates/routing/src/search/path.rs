//! The states of a path, from the labels of a search.

use super::graph::{Ends, Searched};
use super::side::{BEGUN, Side};
use crate::overlay::UNREACHED;

/// A piece of a path: from one index in a layer to another.
#[derive(Debug, Clone, Copy)]
struct Piece {
    height: usize,
    from: u32,
    to: u32,
}

/// The states of a path, in order. Its memory is used again.
#[derive(Debug, Default, Clone)]
pub struct Path {
    /// From the source with which it begins to the target with which it ends.
    pub states: Vec<u32>,
    labels: Vec<u32>,
    /// Pieces that are yet to be unpacked, the last one first.
    waiting: Vec<Piece>,
}

impl Path {
    /// The path through the label at which both sides met.
    pub(super) fn unpack(&mut self, graph: Searched<'_>, ends: &Ends, sides: &[Side; 2], met: u32) {
        self.labels.clear();
        let mut label = met;
        // From the meeting back to the source, then reversed.
        while label != BEGUN {
            self.labels.push(label);
            label = sides[0].parent(label);
        }
        self.labels.reverse();
        // The backward side's parents lead on to the target, in the right order already.
        label = sides[1].parent(met);
        while label != BEGUN {
            self.labels.push(label);
            label = sides[1].parent(label);
        }
        self.states.clear();
        self.states.push(ends.state(graph.overlay, self.labels[0]));
        for i in 1..self.labels.len() {
            self.step(graph, ends, self.labels[i - 1], self.labels[i]);
        }
    }

    /// From one label to the next.
    fn step(&mut self, graph: Searched<'_>, ends: &Ends, from: u32, to: u32) {
        let layer = ends.layer_of_label(from);
        let within = layer > 0 && layer == ends.layer_of_label(to);
        let base = ends.base[layer];
        // Within a layer a search only uses arcs that leave a cell. Two slots of one cell are
        // therefore joined by a path through it.
        if within && cell(graph, layer, from - base) == cell(graph, layer, to - base) {
            self.through(graph, layer, from - base, to - base);
        } else {
            self.states.push(ends.state(graph.overlay, to));
        }
    }

    /// From one slot of a cell to another, by the trees of all layers below.
    fn through(&mut self, graph: Searched<'_>, layer: usize, from: u32, to: u32) {
        self.waiting.clear();
        self.waiting.push(Piece {
            height: layer,
            from,
            to,
        });
        while let Some(Piece { height, from, to }) = self.waiting.pop() {
            if height == 0 {
                self.states.push(to);
                continue;
            }
            let layer = &graph.overlay.layers[height - 1];
            if cell(graph, height, from) != cell(graph, height, to) {
                self.states.push(layer.state[to as usize]);
                continue;
            }
            self.climb_down(graph, height, from, to);
        }
    }

    /// Puts the steps of a path through a cell, in the layer below, before the pieces that wait.
    fn climb_down(&mut self, graph: Searched<'_>, height: usize, from: u32, to: u32) {
        let layer = &graph.overlay.layers[height - 1];
        let cell = cell(graph, height, from);
        let inner = layer.inner(cell);
        let row = from as usize - layer.first[cell as usize] as usize;
        let begin = layer.trees[cell as usize] as usize + row * inner.len();
        let tree = &graph.cliques[height - 1].trees[begin..begin + inner.len()];
        let local = |slot: u32| layer.below[slot as usize] as usize - inner.start;
        let (first, mut last) = (local(from), local(to));
        // A tree has no cycles, and only reached exits are unpacked.
        // Parents lead backwards, so the last step is pushed first and the first one is popped
        // first.
        while last != first && tree[last] != UNREACHED {
            let before = usize::from(tree[last]);
            self.waiting.push(Piece {
                height: height - 1,
                from: (inner.start + before) as u32,
                to: (inner.start + last) as u32,
            });
            last = before;
        }
    }
}

/// The cell of a slot.
fn cell(graph: Searched<'_>, height: usize, slot: u32) -> u32 {
    graph.overlay.cell(
        height - 1,
        graph.overlay.layers[height - 1].state[slot as usize],
    )
}
