//! What is searched, and the ends of a search.

use crate::overlay::{Cliques, Overlay, Weights};

/// A graph with its layers and what is known of them for one set of weights.
#[derive(Debug, Clone, Copy)]
pub struct Searched<'a> {
    /// The layers.
    pub overlay: &'a Overlay,
    /// The weights of arcs.
    pub weights: &'a Weights,
    /// Ways through cells, a layer each.
    pub cliques: &'a [Cliques],
}

/// A state with what reaching it (or going on from it) counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct End {
    /// The state.
    pub state: u32,
    /// Below [`FAR`](crate::overlay::FAR).
    pub weight: u32,
}

/// The cells that the ends of a search are in.
#[derive(Debug, Default)]
pub(super) struct Ends {
    /// For each layer the cells of all ends.
    pub(super) cells: Vec<Vec<u32>>,
    /// For each layer its first label.
    pub(super) base: Vec<u32>,
}

impl Ends {
    pub(super) fn set(&mut self, overlay: &Overlay, states: impl Iterator<Item = u32> + Clone) {
        self.base.clear();
        self.base.push(0);
        self.cells.resize_with(overlay.layers.len(), Vec::new);
        let mut base = overlay.out.states() as u32;
        for (height, cells) in self.cells.iter_mut().enumerate() {
            self.base.push(base);
            base += overlay.layers[height].state.len() as u32;
            cells.clear();
            cells.extend(states.clone().map(|state| overlay.cell(height, state)));
            cells.sort_unstable();
            cells.dedup();
        }
        self.base.push(base);
    }

    /// The layer that a state takes part in.
    #[inline]
    pub(super) fn layer(&self, overlay: &Overlay, state: u32) -> usize {
        let leaf = overlay.leaf[state as usize] as usize;
        let away = |height: &usize| {
            let cell = overlay.layers[*height].cell_of_leaf[leaf];
            !self.cells[*height].contains(&cell)
        };
        (0..overlay.layers.len())
            .rev()
            .find(away)
            .map_or(0, |height| height + 1)
    }

    /// The layer that a label is of.
    #[inline]
    pub(super) fn layer_of_label(&self, label: u32) -> usize {
        let mut layer = 0;
        while self.base[layer + 1] <= label {
            layer += 1;
        }
        layer
    }

    pub(super) fn state(&self, overlay: &Overlay, label: u32) -> u32 {
        match self.layer_of_label(label) {
            0 => label,
            layer => overlay.layers[layer - 1].state[(label - self.base[layer]) as usize],
        }
    }

    pub(super) fn labels(&self) -> usize {
        self.base.last().map_or(0, |end| *end as usize)
    }
}
