//! Shortest paths of any angle over a grid: Theta* (Nash, Daniel, Koenig and Felner 2007), then
//! pulled taut.

use openbench_geometry::grid::{Frontier, GridGeometry, in_sight};

/// Steps to the eight neighbours of a cell: columns, rows.
const NEIGHBOURS: [[i64; 2]; 8] = [
    [-1, -1],
    [0, -1],
    [1, -1],
    [-1, 0],
    [1, 0],
    [-1, 1],
    [0, 1],
    [1, 1],
];

/// A grid with the cells that paths may use.
#[derive(Clone, Copy)]
pub(super) struct Terrain<'a> {
    pub(super) grid: &'a GridGeometry,
    pub(super) free: &'a [bool],
}

impl Terrain<'_> {
    /// The shortest path between two free cells, both included; `None` if there is none.
    pub(super) fn shortest_path(self, start: usize, goal: usize) -> Option<Vec<usize>> {
        Some(self.pull_taut(self.theta_star(start, goal)?))
    }

    fn theta_star(self, start: usize, goal: usize) -> Option<Vec<usize>> {
        let mut search = Search::new(self.free.len());
        search.open(start, start, 0.0, self.grid.cells_apart(start, goal));
        while let Some((_, cell)) = search.queue.pop() {
            if cell == goal {
                return Some(search.trace(start, goal));
            }
            // The queue has no cheaper entry instead of a dearer one, but both.
            if std::mem::replace(&mut search.closed[cell], true) {
                continue;
            }
            self.expand(cell, goal, &mut search);
        }
        None
    }

    fn expand(self, cell: usize, goal: usize, search: &mut Search) {
        let parent = search.parent[cell] as usize;
        let (x, y) = self.grid.column_row(cell);
        for [dx, dy] in NEIGHBOURS {
            let Some(next) = self.grid.cell_in(x + dx, y + dy) else {
                continue;
            };
            // As in A* with a consistent estimate, closed cells are not opened again.
            if !self.free[next] || search.closed[next] {
                continue;
            }
            // No path through `cell` is shorter than the straight line from its parent, so most
            // lines of sight need no test.
            if search.cost[parent] + self.grid.cells_apart(parent, next) >= search.cost[next] {
                continue;
            }
            // The step of Theta*: the cell's parent is tried first, so a path bends at obstacles
            // only.
            let from = if self.in_sight(parent, next) {
                parent
            } else if self.in_sight(cell, next) {
                cell
            } else {
                continue;
            };
            let cost = search.cost[from] + self.grid.cells_apart(from, next);
            // The line from `cell` may still be longer than what is known: the test above was for
            // its parent.
            if cost < search.cost[next] {
                search.open(next, from, cost, cost + self.grid.cells_apart(next, goal));
            }
        }
    }

    /// Removes corners that a straight line avoids, until there is none left.
    fn pull_taut(self, mut cells: Vec<usize>) -> Vec<usize> {
        loop {
            let before = cells.len();
            let mut i = 1;
            while i + 1 < cells.len() {
                // A corner that goes may let its neighbours see each other, hence the rounds.
                if self.in_sight(cells[i - 1], cells[i + 1]) {
                    cells.remove(i);
                } else {
                    i += 1;
                }
            }
            if cells.len() == before {
                return cells;
            }
        }
    }

    fn in_sight(self, a: usize, b: usize) -> bool {
        in_sight(self.grid, |c| self.free[c], a, b)
    }
}

struct Search {
    cost: Vec<f64>,
    parent: Vec<u32>,
    closed: Vec<bool>,
    queue: Frontier,
}

impl Search {
    fn new(cells: usize) -> Self {
        Self {
            cost: vec![f64::INFINITY; cells],
            parent: vec![0; cells],
            closed: vec![false; cells],
            queue: Frontier::default(),
        }
    }

    fn open(&mut self, cell: usize, parent: usize, cost: f64, estimate: f64) {
        self.cost[cell] = cost;
        self.parent[cell] = parent as u32;
        self.queue.push(estimate, cell);
    }

    fn trace(&self, start: usize, goal: usize) -> Vec<usize> {
        let mut cells = vec![goal];
        let mut at = goal;
        while at != start {
            at = self.parent[at] as usize;
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}
