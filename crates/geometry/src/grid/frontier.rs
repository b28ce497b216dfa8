//! The queue of open cells of a search.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Open cells of a search, the cheapest first; of two with equal estimates, the one with the lower
/// index, so that every search finds the same path.
///
/// ```
/// use openbench_geometry::grid::Frontier;
///
/// let mut open = Frontier::default();
/// open.push(3.5, 17);
/// open.push(2.0, 40);
/// assert_eq!(open.pop(), Some((2.0, 40)));
/// ```
#[derive(Debug, Default)]
pub struct Frontier(BinaryHeap<Entry>);

impl Frontier {
    /// Opens a cell at an estimated cost.
    pub fn push(&mut self, estimate: f64, cell: usize) {
        self.0.push(Entry { estimate, cell });
    }

    /// The cheapest cell and its estimated cost. A cell that was opened several times is returned
    /// several times.
    pub fn pop(&mut self) -> Option<(f64, usize)> {
        self.0.pop().map(|e| (e.estimate, e.cell))
    }
}

#[derive(Debug, PartialEq)]
struct Entry {
    estimate: f64,
    cell: usize,
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            // Reversed, since `BinaryHeap` has the greatest entry on top.
            .estimate
            .total_cmp(&self.estimate)
            .then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_cell_comes_first_and_ties_go_by_index() {
        let mut frontier = Frontier::default();
        for (estimate, cell) in [(2.0, 1), (1.0, 9), (1.0, 4), (3.0, 0)] {
            frontier.push(estimate, cell);
        }
        let order: Vec<usize> = std::iter::from_fn(|| frontier.pop()).map(|e| e.1).collect();
        assert_eq!(order, [4, 9, 1, 0]);
    }
}
