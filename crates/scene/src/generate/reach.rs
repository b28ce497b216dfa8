//! Which parts of the ground hang together, roughly: walls and barriers of the map on a grid of half a metre.
//!
//! Only for choosing a start from which most doors are reached; what a robot can really do is for
//! [`FreeSpace`](crate::FreeSpace) to say when the world stands.

use openbench_core::MapPoint;
use openbench_grid::{GridGeometry, squared_distances};

use super::Extent;
use super::entrances::Doorway;
use super::shapes::along;

/// Side of a cell, metres, unless the map is so large that cells must be larger.
const CELL: f64 = 0.5;
/// Largest number of cells on one side.
const MAX_CELLS: usize = 4_000;
/// Ground around the buildings that is looked at, metres.
const MARGIN: f64 = 20.0;
/// Free space that a robot needs to each side, metres.
const HALF_WIDTH: f64 = 0.45;
/// How far in front of a door one must be able to stand, metres.
const BEFORE_DOOR: f64 = 1.2;

/// The ground from which the most doors are reached.
pub(super) struct Reach {
    grid: GridGeometry,
    part: Vec<u32>,
    best: u32,
}

impl Reach {
    /// The ground between `walls` (segments).
    pub fn new(
        extent: Extent,
        walls: impl Iterator<Item = (MapPoint, MapPoint)>,
        doors: &[Doorway],
    ) -> Self {
        let low = MapPoint::new(extent.min.x - MARGIN, extent.min.y - MARGIN);
        let high = MapPoint::new(extent.max.x + MARGIN, extent.max.y + MARGIN);
        let cell = CELL.max((high.x - low.x).max(high.y - low.y) / (MAX_CELLS - 1) as f64);
        let grid = GridGeometry::covering(low, high, cell, MAX_CELLS);
        let mut blocked = vec![false; grid.len()];
        for (a, b) in walls {
            let steps = (2.0 * a.distance(b) / cell)
                .ceil()
                .clamp(1.0, 4.0 * MAX_CELLS as f64) as usize;
            for i in 0..=steps {
                if let Some(c) = grid.cell_at(along(a, b, i as f64 / steps as f64)) {
                    blocked[c] = true;
                }
            }
        }
        let limit = (HALF_WIDTH / cell) * (HALF_WIDTH / cell);
        let clearance = squared_distances(&blocked, grid.width, grid.height);
        let part = parts(&grid, |c| f64::from(clearance[c]) > limit);
        let best = most_doors(&grid, &part, doors);
        Self { grid, part, best }
    }

    /// Whether most doors are reached from `point`.
    pub fn serves(&self, point: MapPoint) -> bool {
        self.grid
            .cell_at(point)
            .is_some_and(|c| self.part[c] == self.best && self.best > 0)
    }
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
                part[n] = next;
                stack.push(n);
            }
        }
    }
    part
}

fn most_doors(grid: &GridGeometry, part: &[u32], doors: &[Doorway]) -> u32 {
    let mut counts = std::collections::BTreeMap::<u32, usize>::new();
    for door in doors {
        let front = door.middle().offset(door.facing, BEFORE_DOOR);
        if let Some(c) = grid.cell_at(front).filter(|c| part[*c] > 0) {
            *counts.entry(part[c]).or_default() += 1;
        }
    }
    counts
        .into_iter()
        .max_by_key(|(part, n)| (*n, std::cmp::Reverse(*part)))
        .map_or(0, |(part, _)| part)
}
