//! Customization: the distances from the entries of each cell to its exits, for one set of weights.
//!
//! Layer by layer, a search from each entry of a cell runs along the cliques of the layer below.
//! The trees of these searches are kept, so that a path through a cell is unpacked by look-ups
//! instead of searches.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use rayon::prelude::*;

use super::{FAR, Layer, Overlay};

/// Weights of arcs, at most [`FAR`], which stands for a closed arc.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Weights {
    /// In the order of [`Overlay::out`].
    pub out: Vec<u32>,
    /// In the order of [`Overlay::incoming`].
    pub into: Vec<u32>,
}

/// The cliques of a layer: distances through its cells.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cliques {
    /// For each cell a matrix with a row for each entry: the distances to the exits.
    pub rows: Vec<u32>,
    /// The same transposed: a row for each exit.
    pub(crate) columns: Vec<u32>,
    /// For each entry of a cell and each index inside: the index that precedes it on the shortest
    /// path, counted from the cell's first one. [`UNREACHED`] if there is no path; itself where the
    /// search began.
    pub(crate) trees: Vec<u16>,
}

/// No index.
pub(crate) const UNREACHED: u16 = u16::MAX;

impl Cliques {
    /// The cliques of all layers.
    pub fn all(overlay: &Overlay, weights: &Weights) -> Vec<Self> {
        let mut layers: Vec<Self> = Vec::new();
        // From the lowest layer up: each is made from the cliques of the one below.
        for layer in &overlay.layers {
            let cells: Vec<u32> = (0..layer.cells() as u32).collect();
            let mut cliques = Self::empty(layer);
            let below = Below {
                overlay,
                weights,
                layers: &layers,
            };
            cliques.fill(layer, &below, &cells);
            layers.push(cliques);
        }
        layers
    }

    /// Computes those cells of all layers again that contain one of these states, after the weights
    /// of arcs between them have changed.
    pub fn update(layers: &mut [Self], overlay: &Overlay, weights: &Weights, states: &[u32]) {
        for (height, layer) in overlay.layers.iter().enumerate() {
            let mut cells: Vec<u32> = states
                .iter()
                .map(|state| overlay.cell(height, *state))
                .collect();
            cells.sort_unstable();
            cells.dedup();
            // Lower layers are read, and are up to date already; this one is written.
            let (lower, upper) = layers.split_at_mut(height);
            let below = Below {
                overlay,
                weights,
                layers: lower,
            };
            upper[0].fill(layer, &below, &cells);
        }
    }

    fn empty(layer: &Layer) -> Self {
        let size = |ends: &[u64]| ends.last().map_or(0, |end| *end as usize);
        Self {
            rows: vec![FAR; size(&layer.matrix)],
            columns: vec![FAR; size(&layer.matrix)],
            trees: vec![UNREACHED; size(&layer.trees)],
        }
    }

    /// Computes some cells, which must be in order.
    fn fill(&mut self, layer: &Layer, below: &Below<'_>, cells: &[u32]) {
        let parts = parts(&mut self.rows, &layer.matrix, cells);
        let parts = parts.zip(self::parts(&mut self.columns, &layer.matrix, cells));
        let parts = parts
            .zip(self::parts(&mut self.trees, &layer.trees, cells))
            .zip(cells);
        // Each cell writes to parts of its own, so cells are computed in parallel without locks,
        // and in any order with the same result.
        let work: Vec<_> = parts
            .map(|(((rows, columns), trees), cell)| (rows, columns, trees, *cell))
            .collect();
        work.into_par_iter().for_each_init(
            Local::default,
            |local, (rows, columns, trees, cell)| {
                local.load(below, layer.inner(cell));
                local.cell(layer, cell, rows, trees);
                transpose(rows, columns, layer.exits(cell).len());
            },
        );
    }
}

/// The parts of some cells, which must be in order.
fn parts<'a, T>(
    mut all: &'a mut [T],
    ends: &'a [u64],
    cells: &'a [u32],
) -> impl Iterator<Item = &'a mut [T]> {
    let mut done = 0;
    cells.iter().map(move |cell| {
        let [begin, end] = [0, 1].map(|i| ends[*cell as usize + i] as usize);
        // `done` elements are split off already. Cells in order make all parts disjoint.
        let rest = std::mem::take(&mut all);
        let (part, rest) = rest[begin - done..].split_at_mut(end - begin);
        done = end;
        all = rest;
        part
    })
}

fn transpose(rows: &[u32], columns: &mut [u32], width: usize) {
    if width == 0 {
        return;
    }
    let height = rows.len() / width;
    for (entry, row) in rows.chunks_exact(width).enumerate() {
        for (exit, weight) in row.iter().enumerate() {
            columns[exit * height + entry] = *weight;
        }
    }
}

/// What is known of the layer below.
struct Below<'a> {
    overlay: &'a Overlay,
    weights: &'a Weights,
    layers: &'a [Cliques],
}

/// The inside of a cell, numbered from 0, and a search in it.
#[derive(Default)]
struct Local {
    begin: usize,
    /// For each index inside its first arc, and the end of the last one's.
    first: Vec<u32>,
    arcs: Vec<(u32, u32)>,
    distance: Vec<u32>,
    heap: BinaryHeap<Reverse<u64>>,
}

impl Local {
    fn load(&mut self, below: &Below<'_>, inner: Range<usize>) {
        self.begin = inner.start;
        self.first.clear();
        self.arcs.clear();
        for index in inner.clone() {
            self.first.push(self.arcs.len() as u32);
            self.load_arcs(below, index, &inner);
            self.load_clique(below, index);
        }
        self.first.push(self.arcs.len() as u32);
    }

    /// The arcs that lead from one subcell to another; in the lowest layer, from one state to
    /// another.
    fn load_arcs(&mut self, below: &Below<'_>, index: usize, inner: &Range<usize>) {
        let (overlay, height) = (below.overlay, below.layers.len());
        let state = height
            .checked_sub(1)
            .map_or(index as u32, |h| overlay.layers[h].state[index]);
        for slot in overlay.out.of(state) {
            let weight = below.weights.out[slot];
            // Exactly the arcs between subcells of one cell: subcells differ up to layer `height`,
            // and the cells above are the same. Arcs within a subcell are in its clique.
            if usize::from(overlay.out.border[slot]) != height || weight >= FAR {
                continue;
            }
            let head = overlay.index(height, overlay.out.head[slot]) as usize;
            if inner.contains(&head) {
                self.arcs.push(((head - inner.start) as u32, weight));
            }
        }
    }

    /// The distances through the subcell of an entry.
    fn load_clique(&mut self, below: &Below<'_>, index: usize) {
        let Some(height) = below.layers.len().checked_sub(1) else {
            return;
        };
        let (layer, cliques) = (&below.overlay.layers[height], &below.layers[height]);
        let cell = below.overlay.cell(height, layer.state[index]);
        // Only entries begin rows of the matrix; nothing enters the subcell elsewhere.
        if !layer.entries(cell).contains(&index) {
            return;
        }
        let exits = layer.exits(cell);
        let row = layer.matrix[cell as usize] as usize
            + (index - layer.first[cell as usize] as usize) * exits.len();
        for (exit, weight) in exits.clone().zip(&cliques.rows[row..row + exits.len()]) {
            // A slot that is entry and exit reaches itself for nothing: no arc.
            if *weight < FAR && exit != index {
                self.arcs.push(((exit - self.begin) as u32, *weight));
            }
        }
    }

    fn cell(&mut self, layer: &Layer, cell: u32, rows: &mut [u32], trees: &mut [u16]) {
        let (exits, size) = (layer.exits(cell), layer.inner(cell).len());
        if exits.is_empty() || size == 0 {
            return;
        }
        let searches = rows
            .chunks_exact_mut(exits.len())
            .zip(trees.chunks_exact_mut(size));
        for (entry, (row, tree)) in layer.entries(cell).zip(searches) {
            self.search(layer.below[entry] as usize - self.begin, tree);
            for (weight, exit) in row.iter_mut().zip(exits.clone()) {
                *weight = self.distance[layer.below[exit] as usize - self.begin];
            }
        }
    }

    /// Dijkstra's algorithm from one index inside.
    fn search(&mut self, from: usize, tree: &mut [u16]) {
        tree.fill(UNREACHED);
        self.distance.clear();
        self.distance.resize(tree.len(), FAR);
        self.distance[from] = 0;
        // `is_affordable` has left out layers whose cells have `UNREACHED` indices or more.
        tree[from] = from as u16;
        self.heap.push(Reverse(from as u64));
        while let Some(Reverse(top)) = self.heap.pop() {
            let (distance, index) = ((top >> 32) as u32, top as u32 as usize);
            // An outdated entry: entries are not moved within the heap, but added again.
            if distance > self.distance[index] {
                continue;
            }
            for (head, weight) in
                &self.arcs[self.first[index] as usize..self.first[index + 1] as usize]
            {
                let reached = distance + weight;
                if reached < self.distance[*head as usize] {
                    self.distance[*head as usize] = reached;
                    tree[*head as usize] = index as u16;
                    self.heap
                        .push(Reverse(u64::from(reached) << 32 | u64::from(*head)));
                }
            }
        }
    }
}
