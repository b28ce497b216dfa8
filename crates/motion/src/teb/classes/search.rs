//! A* over cells and signatures: the cheapest path of each of the cheapest classes.

use openbench_core::MapPoint;
use openbench_geometry::grid::{Frontier, GridGeometry, NEIGHBOURS};

use super::crossings::Crossings;
use super::signature::Signature;

/// No entry of a list.
const NOWHERE: u32 = u32::MAX;

/// What is searched.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    pub(super) grid: &'a GridGeometry,
    /// Cost of a cell, infinite where the robot does not fit.
    pub(super) costs: &'a [f64],
    /// A point in each cluster.
    pub(super) clusters: &'a [MapPoint],
    /// Most classes.
    pub(super) most: usize,
    /// Paths that cost more than this many times the cheapest are left out.
    pub(super) longest: f64,
}

/// A cell that was reached, with the class of the path to it.
#[derive(Debug, Clone, Copy)]
struct Reached {
    cell: usize,
    signature: Signature,
    cost: f64,
    from: u32,
}

/// A path over cells.
pub(super) struct Found {
    pub(super) cells: Vec<usize>,
    pub(super) signature: Signature,
    /// In sides of cells.
    pub(super) cost: f64,
}

/// The buffers of a search, used again from one to the next.
#[derive(Debug, Default)]
pub(super) struct ClassSearch {
    reached: Vec<Reached>,
    /// For each cell the last entry of `reached` that was closed there, and for each entry the one
    /// before.
    closed: Vec<u32>,
    closed_before: Vec<u32>,
    /// The same of those that were opened.
    opened: Vec<u32>,
    opened_before: Vec<u32>,
    crossings: Crossings,
}

impl ClassSearch {
    /// The cheapest paths between two cells, each of a class of its own, the cheapest first.
    pub(super) fn run(&mut self, field: &Field<'_>, from: usize, to: usize) -> Vec<Found> {
        self.begin(field, from);
        let mut queue = Frontier::default();
        queue.push(octile(field.grid, from, to), 0);
        let mut found = Vec::new();
        let mut limit = f64::INFINITY;
        while let Some((total, entry)) = queue.pop() {
            if total > limit || found.len() == field.most {
                break;
            }
            if !self.close(entry, field.most) {
                continue;
            }
            let here = self.reached[entry];
            if here.cell == to {
                // Costs are in sides of cells, and a metre more is always allowed. The first goal
                // sets the limit: it is the cheapest.
                limit = limit.min(field.longest * here.cost + 1.0 / field.grid.cell);
                found.push(entry);
                continue;
            }
            self.expand(field, entry, |cost, cell, entry| {
                queue.push(cost + octile(field.grid, cell, to), entry);
            });
        }
        found.into_iter().map(|end| self.trace(end)).collect()
    }

    /// Empties the buffers and opens the first cell.
    fn begin(&mut self, field: &Field<'_>, from: usize) {
        let cells = field.grid.len();
        for lists in [&mut self.closed, &mut self.opened] {
            lists.clear();
            lists.resize(cells, NOWHERE);
        }
        self.reached.clear();
        self.closed_before.clear();
        self.opened_before.clear();
        self.crossings.lay(field.grid, field.clusters);
        let start = Reached {
            cell: from,
            signature: Signature::default(),
            cost: 0.0,
            from: NOWHERE,
        };
        self.reached.push(start);
        self.closed_before.push(NOWHERE);
        self.opened_before.push(NOWHERE);
    }

    /// Whether the entry is the first of its class at its cell, and not one of too many.
    fn close(&mut self, entry: usize, most: usize) -> bool {
        let here = self.reached[entry];
        let mut other = self.closed[here.cell];
        let mut classes = 0;
        while other != NOWHERE {
            classes += 1;
            if self.reached[other as usize].signature == here.signature || classes == most {
                return false;
            }
            other = self.closed_before[other as usize];
        }
        self.closed_before[entry] = self.closed[here.cell];
        self.closed[here.cell] = entry as u32;
        true
    }

    /// Opens the neighbours of an entry's cell.
    fn expand(&mut self, field: &Field<'_>, entry: usize, mut open: impl FnMut(f64, usize, usize)) {
        let here = self.reached[entry];
        let (x, y) = field.grid.column_row(here.cell);
        let at = field.grid.center(here.cell);
        let mut free = [false; 4];
        for (k, (dx, dy)) in NEIGHBOURS.iter().enumerate() {
            // A diagonal runs between two cells, which must both be free.
            if k >= 4 && !(free[k - 4] && free[(k - 3) % 4]) {
                continue;
            }
            let next = field.grid.cell_in(x + dx, y + dy);
            let Some(cell) = next.filter(|&cell| field.costs[cell].is_finite()) else {
                continue;
            };
            let length = if k < 4 { 1.0 } else { std::f64::consts::SQRT_2 };
            if k < 4 {
                free[k] = true;
            }
            // A step crosses no rays but those between its two columns.
            let crossed = self.crossings.between(x, x + dx).iter();
            let signature = crossed.fold(here.signature, |signature, &i| {
                signature.wound(i, field.clusters[i], at, field.grid.center(cell))
            });
            // A path of this class got there before, and costs no more.
            if self.is_closed(cell, signature) {
                continue;
            }
            let cost = here.cost + length * 0.5 * (field.costs[here.cell] + field.costs[cell]);
            if self.is_open(cell, signature, cost) {
                continue;
            }
            self.reached.push(Reached {
                cell,
                signature,
                cost,
                from: entry as u32,
            });
            self.closed_before.push(NOWHERE);
            let new = self.reached.len() - 1;
            self.opened_before
                .push(std::mem::replace(&mut self.opened[cell], new as u32));
            open(cost, cell, new);
        }
    }

    /// Whether a path of the class to the cell is open that costs no more: it will be closed first.
    fn is_open(&self, cell: usize, signature: Signature, cost: f64) -> bool {
        let mut other = self.opened[cell];
        while other != NOWHERE {
            let known = &self.reached[other as usize];
            // The last of a class is the cheapest of it.
            if known.signature == signature {
                return known.cost <= cost;
            }
            other = self.opened_before[other as usize];
        }
        false
    }

    fn is_closed(&self, cell: usize, signature: Signature) -> bool {
        let mut other = self.closed[cell];
        while other != NOWHERE {
            if self.reached[other as usize].signature == signature {
                return true;
            }
            other = self.closed_before[other as usize];
        }
        false
    }

    /// The path that ends in an entry.
    fn trace(&self, end: usize) -> Found {
        let Reached {
            signature, cost, ..
        } = self.reached[end];
        let mut cells = Vec::new();
        let mut at = end as u32;
        while at != NOWHERE {
            cells.push(self.reached[at as usize].cell);
            at = self.reached[at as usize].from;
        }
        cells.reverse();
        Found {
            cells,
            signature,
            cost,
        }
    }
}

/// Octile distance of two cells, cells.
fn octile(grid: &GridGeometry, a: usize, b: usize) -> f64 {
    let ((x, y), (u, v)) = (grid.column_row(a), grid.column_row(b));
    let (dx, dy) = ((x - u).abs() as f64, (y - v).abs() as f64);
    dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
}
