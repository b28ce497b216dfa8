//! The graph that is searched, and the ends of a search.

use crate::overlay::{Cliques, Overlay, Weights};

/// A graph with its layers, customized for one set of weights.
#[derive(Debug, Clone, Copy)]
pub struct Searched<'a> {
    /// The layers.
    pub overlay: &'a Overlay,
    /// Weights of arcs.
    pub weights: &'a Weights,
    /// Distances through cells, by layer.
    pub cliques: &'a [Cliques],
}

/// A state at which a search begins or ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct End {
    /// The state.
    pub state: u32,
    /// The weight between it and the place, below [`FAR`](crate::overlay::FAR).
    pub weight: u32,
}

/// The cells that contain the ends of a search.
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
        // Labels are numbered through: the states first, then the slots of each layer.
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

    /// The layer in which a state takes part.
    #[inline]
    pub(super) fn layer(&self, overlay: &Overlay, state: u32) -> usize {
        let leaf = overlay.leaf[state as usize] as usize;
        // Few ends have few cells, so a linear look-up suffices.
        let away = |height: &usize| {
            let cell = overlay.layers[*height].cell_of_leaf[leaf];
            !self.cells[*height].contains(&cell)
        };
        (0..overlay.layers.len())
            .rev()
            .find(away)
            .map_or(0, |height| height + 1)
    }

    /// The layer of a label.
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
