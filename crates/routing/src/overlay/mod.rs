//! Layers of cells over a graph: which states are on the borders of cells, and where the distances
//! through each cell are stored.
//!
//! A *state* is what a search settles: a vertex, or a directed edge where turns matter. Layer 0
//! consists of the states themselves. In layer *k* ≥ 1 only those states remain, as *slots*, to
//! which an arc from another cell leads (*entries*), or from which an arc leaves the cell
//! (*exits*). The slots of a cell are contiguous: entries first, exits last, those that are both in
//! the middle. The distances from a cell's entries to its exits are therefore a matrix whose rows
//! run along neighbouring slots. The slots of a cell's subcells are contiguous too: the inside of a
//! cell is a range of the layer below.
//!
//! None of this depends on a profile. Delling et al. 2017 call it the overlay's topology.
//!
//! | module | contents |
//! |---|---|
//! | `arcs` | states and arcs |
//! | `customize` | distances through cells, for a profile |

mod arcs;
mod customize;

pub use arcs::{Arc, Arcs, NONE};
pub(crate) use customize::UNREACHED;
pub use customize::{Cliques, Weights};

/// The weight from which on there is no path. Two weights up to it can be added without overflow.
pub const FAR: u32 = i32::MAX as u32;

/// How many numbers a layer may store for each state: the most that cells of 32 states can need.
const MOST_NUMBERS_PER_STATE: u64 = 64;

/// A layer of cells.
#[derive(Debug, Clone, Default)]
pub struct Layer {
    /// For each cell its first slot, and the end of the last one's.
    pub(crate) first: Vec<u32>,
    /// For each cell where its entries end.
    pub(crate) entries_end: Vec<u32>,
    /// For each cell where its exits begin.
    pub(crate) exits_begin: Vec<u32>,
    /// For each slot its state.
    pub state: Vec<u32>,
    /// For each slot its index in the layer below.
    pub(crate) below: Vec<u32>,
    /// For each index in the layer below its slot, or [`NONE`].
    pub(crate) slot: Vec<u32>,
    /// For each cell the begin of its inside in the layer below, and the end of the last one's.
    pub(crate) inner: Vec<u32>,
    /// For each cell the begin of its matrix, and the end of the last one.
    pub(crate) matrix: Vec<u64>,
    /// For each cell the begin of its trees, and the end of the last one's: a tree for each entry,
    /// over all indices inside.
    pub(crate) trees: Vec<u64>,
    /// For each cell of the lowest layer the cell of this layer that contains it.
    pub(crate) cell_of_leaf: Vec<u32>,
}

impl Layer {
    /// A cell's entries.
    pub(crate) fn entries(&self, cell: u32) -> std::ops::Range<usize> {
        self.first[cell as usize] as usize..self.entries_end[cell as usize] as usize
    }

    /// A cell's exits.
    pub(crate) fn exits(&self, cell: u32) -> std::ops::Range<usize> {
        self.exits_begin[cell as usize] as usize..self.first[cell as usize + 1] as usize
    }

    /// The inside of a cell, as indices of the layer below.
    pub(crate) fn inner(&self, cell: u32) -> std::ops::Range<usize> {
        self.inner[cell as usize] as usize..self.inner[cell as usize + 1] as usize
    }

    /// Whether the distances through its cells fit into memory. On planar maps, as of streets, they
    /// always do. On other maps the borders of cells are as long as the cells are large, and
    /// searches are faster without them.
    fn is_affordable(&self, states: usize) -> bool {
        let known =
            [&self.matrix, &self.trees].map(|ends| ends.last().copied().unwrap_or_default());
        let inner = (0..self.cells() as u32).map(|cell| self.inner(cell).len());
        // The constant lets small maps keep their layers whatever they look like: up to 16.8
        // million numbers. Trees store local indices in 16 bits, of which one stands for
        // `UNREACHED`.
        known.iter().sum::<u64>() <= MOST_NUMBERS_PER_STATE * (states as u64 + (1 << 18))
            && inner
                .max()
                .is_none_or(|largest| largest < usize::from(UNREACHED))
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.first.len().saturating_sub(1)
    }
}

/// A graph with layers of cells.
#[derive(Debug, Clone, Default)]
pub struct Overlay {
    /// Arcs by the state that they leave.
    pub out: Arcs,
    /// Arcs by the state that they lead to. `None` if each arc has one in the opposite direction
    /// along the same edge: then those that lead to a state are in the order of those that leave
    /// it.
    into: Option<Arcs>,
    /// For each state its cell in the lowest layer.
    pub(crate) leaf: Vec<u32>,
    /// Layers 1, 2, …
    pub layers: Vec<Layer>,
}

impl Overlay {
    /// Puts layers over a graph.
    ///
    /// `levels` gives, smallest cells first, the state at which each cell begins, and the end of
    /// the last one. Layers are left out from the first one on that does not fit into memory.
    pub fn new(mut out: Arcs, levels: &[Vec<u32>]) -> Self {
        let leaf = match levels.first() {
            Some(starts) => (0..starts.len() as u32 - 1)
                .flat_map(|cell| {
                    (starts[cell as usize]..starts[cell as usize + 1]).map(move |_| cell)
                })
                .collect(),
            None => vec![0; out.states()],
        };
        let cells_of_leaf: Vec<Vec<u32>> = levels
            .iter()
            .map(|starts| cells_of_leaves(levels, starts))
            .collect();
        // Cells are nested: two states in one cell are in one cell of all layers above. The layers
        // that tell them apart are therefore the lowest ones, and counting them gives the highest.
        let border = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|state| leaf[state as usize] as usize);
            cells_of_leaf
                .iter()
                .take_while(|cells| cells[a] != cells[b])
                .count() as u8
        };
        let borders: Vec<u8> = out
            .iter()
            .map(|(from, slot)| border(from, out.head[slot]))
            .collect();
        out.border = borders;
        // Over vertices each arc has its opposite, and half of the memory is saved.
        let into = (!out.is_symmetric()).then(|| {
            let mut into = out.reversed();
            into.border = into
                .iter()
                .map(|(to, slot)| border(to, into.head[slot]))
                .collect();
            into
        });
        let mut overlay = Self {
            out,
            into,
            leaf,
            layers: Vec::new(),
        };
        for (starts, cell_of_leaf) in levels.iter().zip(cells_of_leaf) {
            let layer = overlay.layer(starts, cell_of_leaf);
            // Layers above are made from this one, so they are left out too.
            if !layer.is_affordable(overlay.out.states()) {
                break;
            }
            overlay.layers.push(layer);
        }
        overlay
    }

    /// The next layer.
    fn layer(&self, starts: &[u32], cell_of_leaf: Vec<u32>) -> Layer {
        let height = self.layers.len() as u8 + 1;
        let lower = self.layers.last();
        let crosses =
            |arcs: &Arcs, state: u32| arcs.of(state).any(|slot| arcs.border[slot] >= height);
        let mut layer = Layer {
            cell_of_leaf,
            ..Layer::default()
        };
        let size = lower.map_or(self.out.states(), |lower| lower.state.len());
        layer.slot = vec![NONE; size];
        for cell in 0..starts.len() - 1 {
            let inner = [0, 1].map(|i| {
                lower.map_or(starts[cell + i], |l| {
                    first_slot(l, &self.leaf, starts[cell + i])
                })
            });
            let state = |index: u32| lower.map_or(index, |lower| lower.state[index as usize]);
            // Entries only, both, exits only: in this order entries and exits are ranges that
            // overlap in the middle group.
            let mut groups = [const { Vec::new() }; 3];
            for index in inner[0]..inner[1] {
                match (
                    crosses(self.incoming(), state(index)),
                    crosses(&self.out, state(index)),
                ) {
                    (true, false) => groups[0].push(index),
                    (true, true) => groups[1].push(index),
                    (false, true) => groups[2].push(index),
                    (false, false) => {}
                }
            }
            layer.push_cell(inner, &groups, state);
        }
        layer.end(size as u32);
        layer
    }

    /// Arcs by the state that they lead to; `head` is the state that each comes from. What they
    /// pass along is given by [`Overlay::via_incoming`].
    #[inline]
    pub fn incoming(&self) -> &Arcs {
        self.into.as_ref().unwrap_or(&self.out)
    }

    /// The directed edge that an arc of [`Overlay::incoming`] passes along.
    pub fn via_incoming(&self, slot: usize) -> u32 {
        self.into
            .as_ref()
            .map_or_else(|| self.out.via[slot] ^ 1, |into| into.via[slot])
    }

    /// The number of edges between cells of a layer, which is counted from 0.
    pub fn edges_between_cells(&self, layer: usize) -> usize {
        let is_between = |border: &&u8| usize::from(**border) > layer;
        // An edge has an arc in each direction.
        self.out.border.iter().filter(is_between).count() / 2
    }

    /// The cell of a state in a layer, which is counted from 0.
    #[inline]
    pub(crate) fn cell(&self, layer: usize, state: u32) -> u32 {
        self.layers[layer].cell_of_leaf[self.leaf[state as usize] as usize]
    }

    /// The index of a state in a layer; [`NONE`] if it is on no border there.
    #[inline]
    pub(crate) fn index(&self, height: usize, state: u32) -> u32 {
        let mut index = state;
        for layer in &self.layers[..height] {
            if index == NONE {
                return NONE;
            }
            index = layer.slot[index as usize];
        }
        index
    }
}

impl Layer {
    fn push_cell(&mut self, inner: [u32; 2], groups: &[Vec<u32>; 3], state: impl Fn(u32) -> u32) {
        let [entries, both, exits] = groups.each_ref().map(|group| group.len() as u32);
        let first = self.state.len() as u32;
        self.first.push(first);
        self.entries_end.push(first + entries + both);
        self.exits_begin.push(first + entries);
        self.inner.push(inner[0]);
        self.matrix
            .push(u64::from(entries + both) * u64::from(both + exits));
        self.trees
            .push(u64::from(entries + both) * u64::from(inner[1] - inner[0]));
        for index in groups.iter().flatten() {
            self.slot[*index as usize] = self.state.len() as u32;
            self.below.push(*index);
            self.state.push(state(*index));
        }
    }

    /// Turns sizes into begins.
    fn end(&mut self, inner: u32) {
        self.first.push(self.state.len() as u32);
        self.inner.push(inner);
        for sizes in [&mut self.matrix, &mut self.trees] {
            let mut sum = 0;
            for size in sizes.iter_mut() {
                // Each size is replaced by the sum of those before it.
                sum += std::mem::replace(size, sum);
            }
            sizes.push(sum);
        }
    }
}

/// The first slot of a layer whose state is not before `state`, at which a cell begins.
fn first_slot(lower: &Layer, leaf: &[u32], state: u32) -> u32 {
    match leaf.get(state as usize) {
        Some(leaf) => lower.first[lower.cell_of_leaf[*leaf as usize] as usize],
        None => lower.state.len() as u32,
    }
}

/// For each of the smallest cells the cell of another level that contains it.
fn cells_of_leaves(levels: &[Vec<u32>], starts: &[u32]) -> Vec<u32> {
    let leaves = &levels[0];
    let mut cell = 0;
    let up = leaves[..leaves.len() - 1].iter().map(|start| {
        // Both rows ascend and levels are nested, so one pass over both suffices.
        while starts[cell + 1] <= *start {
            cell += 1;
        }
        cell as u32
    });
    up.collect()
}
