//! A* over cells with costs: the cheapest path over the eight neighbours of each cell, without
//! cutting corners.
//!
//! P. Hart, N. Nilsson, B. Raphael, *A Formal Basis for the Heuristic Determination of Minimum Cost
//! Paths*, 1968, with the octile distance for a heuristic. It is never more than the path costs,
//! since no cell costs less than 1, and consistent: it falls along no step by more than the step
//! costs. So the estimates taken from the queue never fall, and a queue of buckets will do (R.
//! Dial, *Algorithm 360*, 1969). Within a bucket cells come in any order; paths are cheapest all
//! the same, since a cell that is reached at a lower cost later is visited again.

use std::f64::consts::SQRT_2;

/// The most that a cell may cost. The queue reaches as far as a step can lead; for dearer cells it
/// would have to be longer or coarser.
pub(crate) const DEAREST: f32 = 256.0;
/// Buckets for each unit of estimated cost.
const FINENESS: f64 = 4.0;
/// Buckets of the queue, used as a ring: a step raises an estimate by at most √2 (`DEAREST` + 1).
const BUCKETS: usize = 2048;
/// Columns and rows to the neighbours; each diagonal lies between two of the first four.
const STEPS: [(i32, i32); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];
/// Instead of the number of a step: the start.
const START: u8 = 8;

/// Costs of cells, row by row: of a path of one cell's side through each. They are 1 to
/// 256, or infinite where no path leads.
#[derive(Debug, Clone, Copy)]
pub struct Costs<'a> {
    width: usize,
    costs: &'a [f32],
}

/// The costs make no grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CostsError {
    /// No cells, more than can be numbered, or rows of different lengths.
    #[error(
        "{cells} costs do not fill rows of {width} cells; give width times height of them, \
         2^31 - 1 at most"
    )]
    NoGrid {
        /// Cells in a row.
        width: usize,
        /// Costs in all.
        cells: usize,
    },
    /// A cost that is too small, too large or NaN.
    #[error(
        "cell {cell} costs {cost}; give costs from 1 to {DEAREST}, or infinity where no path leads"
    )]
    NoCost {
        /// Its number.
        cell: usize,
        /// Its cost.
        cost: f32,
    },
}

impl<'a> Costs<'a> {
    /// Costs that are known to be valid.
    pub(crate) fn known(width: usize, costs: &'a [f32]) -> Self {
        Self { width, costs }
    }

    /// The cost of a cell.
    #[inline]
    pub(crate) fn of(&self, cell: usize) -> f32 {
        self.costs[cell]
    }

    /// Costs of a grid `width` cells wide; each is checked once.
    pub fn new(width: usize, costs: &'a [f32]) -> Result<Self, CostsError> {
        let cells = costs.len();
        if cells == 0 || width == 0 || !cells.is_multiple_of(width) || cells > i32::MAX as usize {
            return Err(CostsError::NoGrid { width, cells });
        }
        // Bounded above: a single very expensive cell once made a search a hundred times as slow.
        let is_cost = |cost: f32| (1.0..=DEAREST).contains(&cost) || cost == f32::INFINITY;
        match costs.iter().position(|cost| !is_cost(*cost)) {
            Some(cell) => Err(CostsError::NoCost {
                cell,
                cost: costs[cell],
            }),
            None => Ok(Self { width, costs }),
        }
    }
}

/// A path over cells.
#[derive(Debug, Clone, PartialEq)]
pub struct GridPath {
    /// What it costs, in sides of cells.
    pub cost: f64,
    /// Its cells, both ends included.
    pub cells: Vec<usize>,
}

/// What a search knows of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Visited {
    /// Cost of the cheapest path to it so far.
    cost: f64,
    /// Number of the search that found it.
    search: u32,
    /// Number of the step that led to it.
    step: u8,
}

/// A cell to expand.
#[derive(Debug, Clone, Copy)]
struct Open {
    cost: f64,
    x: i32,
    y: i32,
}

/// Buffers of searches, used again from one to the next.
#[derive(Debug, Clone)]
pub struct Search {
    visited: Vec<Visited>,
    number: u32,
    buckets: Vec<Vec<Open>>,
}

impl Default for Search {
    fn default() -> Self {
        Self {
            visited: Vec::new(),
            number: 0,
            buckets: vec![Vec::new(); BUCKETS],
        }
    }
}

impl Search {
    /// The cheapest path from one cell to another; `None` if there is none. A step costs its
    /// length, in sides of cells, times the mean cost of both cells.
    ///
    /// ```
    /// use openbench_motion::{Costs, Search};
    ///
    /// // Three rows of four cells; a wall leaves one way around it.
    /// let wall = f32::INFINITY;
    /// let cells = [
    ///     1.0, 1.0, 1.0, 1.0, //
    ///     1.0, wall, wall, 1.0, //
    ///     1.0, wall, 1.0, 1.0,
    /// ];
    /// let costs = Costs::new(4, &cells)?;
    /// let path = Search::default().cheapest(&costs, 8, 10).ok_or("there is a path")?;
    /// assert_eq!(path.cells, [8, 4, 0, 1, 2, 3, 7, 11, 10]);
    /// assert_eq!(path.cost, 8.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    ///
    /// If `start` or `goal` is no cell of the grid.
    pub fn cheapest(&mut self, costs: &Costs<'_>, start: usize, goal: usize) -> Option<GridPath> {
        assert!(
            start < costs.costs.len() && goal < costs.costs.len(),
            "a cell of another grid"
        );
        if costs.costs[start].is_infinite() || costs.costs[goal].is_infinite() {
            return None;
        }
        self.begin(costs.costs.len());
        let mut run = Run {
            costs: costs.costs,
            // All of these fit: `Costs::new` allows 2^31 - 1 cells, and a costmap has fewer.
            columns: costs.width as i32,
            rows: (costs.costs.len() / costs.width) as i32,
            goal_column: (goal % costs.width) as i32,
            goal_row: (goal / costs.width) as i32,
            number: self.number,
            visited: &mut self.visited,
            buckets: &mut self.buckets,
            waiting: 0,
        };
        let cost = run.search(start, goal)?;
        Some(GridPath {
            cost,
            cells: self.trace(costs.width, goal),
        })
    }

    /// Whether the last search reached a cell. A search that found no path to its goal has reached
    /// all cells connected with its start.
    pub fn reached(&self, cell: usize) -> bool {
        self.number > 0
            && self
                .visited
                .get(cell)
                .is_some_and(|visited| visited.search == self.number)
    }

    fn begin(&mut self, cells: usize) {
        // A search that found its goal left entries behind.
        self.buckets.iter_mut().for_each(Vec::clear);
        if self.visited.len() != cells || self.number == u32::MAX {
            self.visited.clear();
            self.visited.resize(cells, Visited::default());
            self.number = 0;
        }
        // What earlier searches visited has another number, and need not be cleared.
        self.number += 1;
    }

    fn trace(&self, width: usize, goal: usize) -> Vec<usize> {
        let mut cells = vec![goal];
        let mut at = goal;
        // `START` is the number of no step, and ends the walk back.
        while let Some((dx, dy)) = STEPS.get(usize::from(self.visited[at].step)) {
            at = (at as i64 - i64::from(*dx) - i64::from(*dy) * width as i64) as usize;
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}

/// A running search.
struct Run<'a> {
    costs: &'a [f32],
    columns: i32,
    rows: i32,
    goal_column: i32,
    goal_row: i32,
    number: u32,
    visited: &'a mut [Visited],
    buckets: &'a mut [Vec<Open>],
    /// Entries in all buckets.
    waiting: usize,
}

impl Run<'_> {
    fn search(&mut self, start: usize, goal: usize) -> Option<f64> {
        self.visited[start] = Visited {
            cost: 0.0,
            search: self.number,
            step: START,
        };
        let (x, y) = (start as i32 % self.columns, start as i32 / self.columns);
        let mut bucket = (self.estimate(x, y) * FINENESS) as usize;
        self.open(Open { cost: 0.0, x, y }, bucket);
        while self.waiting > 0 {
            if self.visited[goal].search == self.number {
                let cost = self.visited[goal].cost;
                // No open path costs less.
                if bucket as f64 >= cost * FINENESS {
                    return Some(cost);
                }
            }
            // All open estimates lie within one round of the ring, so a bucket never mixes two
            // rounds.
            while let Some(open) = self.buckets[bucket % BUCKETS].pop() {
                self.waiting -= 1;
                let cell = (open.y * self.columns + open.x) as usize;
                // Entries of cells that were reached more cheaply since are outdated. What lies
                // beyond the goal does not matter.
                if open.cost <= self.visited[cell].cost && cell != goal {
                    self.expand(open, cell, bucket);
                }
            }
            bucket += 1;
        }
        (self.visited[goal].search == self.number).then(|| self.visited[goal].cost)
    }

    #[inline]
    fn open(&mut self, open: Open, bucket: usize) {
        self.buckets[bucket % BUCKETS].push(open);
        self.waiting += 1;
    }

    /// Octile distance to the goal, cells.
    #[inline]
    fn estimate(&self, x: i32, y: i32) -> f64 {
        let (dx, dy) = ((x - self.goal_column).abs(), (y - self.goal_row).abs());
        f64::from(dx.max(dy)) + (SQRT_2 - 1.0) * f64::from(dx.min(dy))
    }

    /// Opens the neighbours that are reached at a lower cost than before.
    #[inline]
    fn expand(&mut self, from: Open, cell: usize, bucket: usize) {
        let here = f64::from(self.costs[cell]);
        let mut free = [false; 4];
        for (step, &(dx, dy)) in STEPS.iter().enumerate() {
            let (u, v) = (from.x + dx, from.y + dy);
            // A diagonal runs between two cells, which must both be free.
            let open = step < 4 || (free[step - 4] && free[(step - 3) % 4]);
            if !open || u < 0 || v < 0 || u >= self.columns || v >= self.rows {
                continue;
            }
            let next = (v * self.columns + u) as usize;
            let there = self.costs[next];
            if there == f32::INFINITY {
                continue;
            }
            // Half the length of the step: times the sum of both costs it gives the mean.
            let length = if step < 4 {
                free[step] = true;
                0.5
            } else {
                0.5 * SQRT_2
            };
            let cost = from.cost + length * (here + f64::from(there));
            let known = &mut self.visited[next];
            if known.search != self.number || cost < known.cost {
                *known = Visited {
                    cost,
                    search: self.number,
                    step: step as u8,
                };
                let estimate = ((cost + self.estimate(u, v)) * FINENESS) as usize;
                // Rounding may put the estimate just below the bucket that is visited now.
                self.open(Open { cost, x: u, y: v }, estimate.max(bucket));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COLUMNS: usize = 9;
    const ROWS: usize = 7;
    const WALL: f32 = f32::INFINITY;

    /// The distance of two neighbours: side by side, or across a corner that is free on both sides.
    fn length(costs: &[f32], a: usize, b: usize) -> Option<f64> {
        let (dx, dy) = (
            (a % COLUMNS).abs_diff(b % COLUMNS),
            (a / COLUMNS).abs_diff(b / COLUMNS),
        );
        let beside = [
            a / COLUMNS * COLUMNS + b % COLUMNS,
            b / COLUMNS * COLUMNS + a % COLUMNS,
        ];
        match (dx, dy) {
            (0, 1) | (1, 0) => Some(1.0),
            (1, 1) if beside.iter().all(|&cell| costs[cell] < WALL) => Some(SQRT_2),
            _ => None,
        }
    }

    fn step(costs: &[f32], a: usize, b: usize) -> Option<f64> {
        let mean = (f64::from(costs[a]) + f64::from(costs[b])) / 2.0;
        length(costs, a, b)
            .map(|length| length * mean)
            .filter(|cost| cost.is_finite())
    }

    /// Least costs by relaxing every step until nothing changes (Bellman and Ford).
    fn by_relaxation(costs: &[f32], start: usize) -> Vec<f64> {
        let mut best = vec![f64::INFINITY; costs.len()];
        best[start] = if costs[start] < WALL {
            0.0
        } else {
            f64::INFINITY
        };
        for _ in 0..costs.len() {
            for a in 0..costs.len() {
                for b in 0..costs.len() {
                    let through = step(costs, a, b).map_or(f64::INFINITY, |cost| best[a] + cost);
                    best[b] = best[b].min(through);
                }
            }
        }
        best
    }

    fn terrain() -> impl Strategy<Value = Vec<f32>> {
        let cost =
            prop_oneof![3 => Just(1.0), 2 => 1.0_f32..9.0, 1 => 9.0_f32..DEAREST, 2 => Just(WALL)];
        prop::collection::vec(cost, COLUMNS * ROWS)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

        #[test]
        fn paths_are_the_cheapest_and_cost_what_their_steps_cost(
            cells in terrain(),
            start in 0..COLUMNS * ROWS,
        ) {
            let costs = Costs::new(COLUMNS, &cells).unwrap();
            let best = by_relaxation(&cells, start);
            let mut search = Search::default();
            for (goal, &best) in best.iter().enumerate() {
                let Some(path) = search.cheapest(&costs, start, goal) else {
                    prop_assert!(best.is_infinite() || cells[goal] == WALL);
                    continue;
                };
                let tolerance = 1e-9 * best.max(1.0);
                prop_assert!((path.cost - best).abs() < tolerance, "{} {best}", path.cost);
                prop_assert_eq!((path.cells[0], path.cells.last()), (start, Some(&goal)));
                let steps = path.cells.windows(2).map(|pair| step(&cells, pair[0], pair[1]));
                let sum: Option<f64> = steps.sum();
                prop_assert!((sum.unwrap() - path.cost).abs() < tolerance);
                let back = search.cheapest(&costs, goal, start).unwrap();
                prop_assert!((back.cost - path.cost).abs() < tolerance);
            }
        }
    }

    #[test]
    fn buffers_are_reused_for_another_grid() {
        let (small, large) = (vec![1.0; 12], vec![2.0; 20]);
        let mut search = Search::default();
        for _ in 0..2 {
            assert_eq!(
                search
                    .cheapest(&Costs::new(4, &small).unwrap(), 0, 3)
                    .unwrap()
                    .cells,
                [0, 1, 2, 3]
            );
            assert_eq!(
                search
                    .cheapest(&Costs::new(5, &large).unwrap(), 0, 4)
                    .unwrap()
                    .cost,
                8.0
            );
        }
    }

    #[test]
    fn costs_that_make_no_grid_are_refused() {
        assert!(matches!(
            Costs::new(3, &[1.0; 4]),
            Err(CostsError::NoGrid { width: 3, cells: 4 })
        ));
        assert!(
            Costs::new(0, &[]).is_err()
                && Costs::new(0, &[1.0]).is_err()
                && Costs::new(2, &[]).is_err()
        );
        for bad in [f32::NAN, 0.5, -1.0, f32::NEG_INFINITY, 256.5, 1e30] {
            assert!(
                matches!(
                    Costs::new(1, &[1.0, bad]),
                    Err(CostsError::NoCost { cell: 1, .. })
                ),
                "{bad}"
            );
        }
    }

    #[test]
    fn no_path_leads_from_or_to_a_wall() {
        let cells = [1.0, WALL, 1.0];
        let (costs, mut search) = (Costs::new(3, &cells).unwrap(), Search::default());
        assert_eq!(search.cheapest(&costs, 0, 2), None);
        assert_eq!(search.cheapest(&costs, 1, 2), None);
        assert_eq!(search.cheapest(&costs, 0, 1), None);
        assert_eq!(
            search.cheapest(&costs, 2, 2),
            Some(GridPath {
                cost: 0.0,
                cells: vec![2]
            })
        );
    }
}
