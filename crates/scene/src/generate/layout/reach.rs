//! Which parts of the ground are connected, roughly: walls and barriers of the map on a grid of
//! half a metre.
//!
//! Only for choosing doors to which streets lead, and a start from which most doors are reached;
//! [`FreeSpace`](crate::FreeSpace) says where a robot can really drive in the finished world.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_geometry::grid::{GridGeometry, squared_distances};
use openbench_geometry::{Bounds, Segment};

/// Side of a cell, metres, unless the map is so large that cells must be larger.
const CELL_M: f64 = 0.5;
/// Largest number of cells on one side.
const MAX_CELLS: usize = 4_000;
/// Ground around the buildings that is searched, metres.
const MARGIN_M: f64 = 20.0;
/// Free space that a robot needs to each side, metres.
const HALF_WIDTH_M: f64 = 0.45;

/// The connected ground that holds the most of some places.
pub(crate) struct Reach {
    grid: GridGeometry,
    /// For each cell the number of its connected part; 0 where there is no room.
    part: Vec<u32>,
    /// The part that holds the most places; 0 if none does.
    best: u32,
}

impl Reach {
    /// The ground between `walls` that holds the most of `places`.
    pub fn new(
        extent: Bounds,
        walls: impl Iterator<Item = Segment>,
        places: impl Iterator<Item = MapPoint>,
    ) -> Self {
        let Bounds { low, high } = extent.grown(MARGIN_M);
        let longer_side = (high.x - low.x).max(high.y - low.y);
        let cell = CELL_M.max(longer_side / (MAX_CELLS - 1) as f64);
        let grid = GridGeometry::covering(low, high, cell, MAX_CELLS);
        let blocked = blocked(&grid, cell, walls);
        // Squares are compared, so no cell needs a root.
        let limit = (HALF_WIDTH_M / cell) * (HALF_WIDTH_M / cell);
        let clearance = squared_distances(&blocked, grid.width, grid.height);
        let part = parts(&grid, |c| f64::from(clearance[c]) > limit);
        let best = most_places(&grid, &part, places);
        Self { grid, part, best }
    }

    /// Whether `point` is on that ground.
    pub fn serves(&self, point: MapPoint) -> bool {
        let cell = self.grid.cell_at(point);
        // Part 0 has no room, so without any place that is reached nothing serves.
        cell.is_some_and(|c| self.part[c] == self.best && self.best > 0)
    }
}

/// For each cell whether a wall is in it.
fn blocked(grid: &GridGeometry, cell: f64, walls: impl Iterator<Item = Segment>) -> Vec<bool> {
    let mut blocked = vec![false; grid.len()];
    for wall in walls {
        // Twice a cell, so that no cell on the way is stepped over.
        let steps = (2.0 * wall.length() / cell).ceil();
        let steps = steps.clamp(1.0, 4.0 * MAX_CELLS as f64) as usize;
        for i in 0..=steps {
            if let Some(c) = grid.cell_at(wall.at(i as f64 / steps as f64)) {
                blocked[c] = true;
            }
        }
    }
    blocked
}

/// For each cell the number of the connected part that it is in, from 1; 0 where there is no room.
fn parts(grid: &GridGeometry, free: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut part = vec![0; grid.len()];
    let (mut next, mut stack) = (0, Vec::new());
    for start in 0..grid.len() {
        if part[start] > 0 || !free(start) {
            continue;
        }
        next += 1;
        part[start] = next;
        stack.push(start);
        while let Some(cell) = stack.pop() {
            let (x, y) = grid.column_row(cell);
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                let Some(n) = grid
                    .cell_in(x + dx, y + dy)
                    .filter(|n| part[*n] == 0 && free(*n))
                else {
                    continue;
                };
                // Marked when it is pushed, so that no cell is pushed twice.
                part[n] = next;
                stack.push(n);
            }
        }
    }
    part
}

/// The part that holds the most places, of several the first; 0 if none holds any.
fn most_places(grid: &GridGeometry, part: &[u32], places: impl Iterator<Item = MapPoint>) -> u32 {
    let mut counts = BTreeMap::<u32, usize>::new();
    for place in places {
        if let Some(c) = grid.cell_at(place).filter(|c| part[*c] > 0) {
            *counts.entry(part[c]).or_default() += 1;
        }
    }
    let best = counts
        .into_iter()
        // The lowest number wins a tie, so that the start does not depend on the search.
        .max_by_key(|(part, count)| (*count, Reverse(*part)));
    best.map_or(0, |(part, _)| part)
}
