//! Which ground a robot reaches from the streets, on a grid.

use openbench_core::MapPoint;
use openbench_geometry::Segment;
use openbench_geometry::grid::{GridGeometry, squared_distances};

use crate::plan::Half;

/// Side of a cell, metres.
const CELL_M: f64 = 0.3;
/// Ground around the planned rectangle that is searched, metres.
const MARGIN_M: f64 = 12.0;
/// Free space that a robot needs to each side, with the error of the grid, metres.
const HALF_WIDTH_M: f64 = 0.5;
/// Largest number of cells on one side.
const MOST_CELLS: usize = 2_000;

/// The ground that is reached.
pub(crate) struct Reach {
    grid: GridGeometry,
    reached: Vec<bool>,
}

impl Reach {
    /// The ground between `walls` that is reached from `start`.
    pub fn new(half: Half, walls: impl Iterator<Item = Segment>, start: MapPoint) -> Self {
        let low = MapPoint::new(-half.x - MARGIN_M, -half.y - MARGIN_M);
        let high = MapPoint::new(half.x + MARGIN_M, half.y + MARGIN_M);
        let grid = GridGeometry::covering(low, high, CELL_M, MOST_CELLS);
        let mut blocked = vec![false; grid.len()];
        for wall in walls {
            let steps = (2.0 * wall.length() / CELL_M).ceil().clamp(1.0, 1e5) as usize;
            for i in 0..=steps {
                if let Some(cell) = grid.cell_at(wall.at(i as f64 / steps as f64)) {
                    blocked[cell] = true;
                }
            }
        }
        let limit = (HALF_WIDTH_M / CELL_M) * (HALF_WIDTH_M / CELL_M);
        let distances = squared_distances(&blocked, grid.width, grid.height);
        let is_free = |cell: usize| f64::from(distances[cell]) > limit;
        let mut reached = vec![false; grid.len()];
        let mut stack: Vec<usize> = grid.cell_at(start).into_iter().collect();
        while let Some(cell) = stack.pop() {
            if reached[cell] || !is_free(cell) {
                continue;
            }
            reached[cell] = true;
            let (x, y) = grid.column_row(cell);
            let steps = [(-1, 0), (1, 0), (0, -1), (0, 1)];
            stack.extend(
                steps
                    .iter()
                    .filter_map(|(dx, dy)| grid.cell_in(x + dx, y + dy)),
            );
        }
        Self { grid, reached }
    }

    /// Whether a robot can stand at a point.
    pub fn holds(&self, point: MapPoint) -> bool {
        self.grid
            .cell_at(point)
            .is_some_and(|cell| self.reached[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_yard_is_not_reached() {
        let p = MapPoint::new;
        let corners = [p(-5.0, -5.0), p(5.0, -5.0), p(5.0, 5.0), p(-5.0, 5.0)];
        let walls = openbench_geometry::sides(&corners);
        let half = Half { x: 10.0, y: 10.0 };
        let reach = Reach::new(half, walls, p(8.0, 8.0));
        assert!(reach.holds(p(-8.0, 0.0)));
        assert!(!reach.holds(p(0.0, 0.0)) && !reach.holds(p(5.2, 0.0)));
    }
}
