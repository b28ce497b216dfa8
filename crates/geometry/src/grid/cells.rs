//! Cells and map points.

use openbench_core::MapPoint;

/// Columns and rows to the neighbours of a cell; each diagonal lies between two of the first four.
pub const NEIGHBOURS: [(i64, i64); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];

/// A grid of square cells, numbered row by row from the south-west.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::grid::GridGeometry;
///
/// let origin = MapPoint::new(100.0, 50.0);
/// let grid = GridGeometry { origin, width: 8, height: 4, cell: 0.5 };
/// let cell = grid.cell_at(MapPoint::new(101.2, 50.6)).ok_or("it is on the grid")?;
/// assert_eq!(grid.column_row(cell), (2, 1));
/// assert_eq!(grid.center(cell), MapPoint::new(101.25, 50.75));
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridGeometry {
    /// South-west corner of the grid in `map`.
    pub origin: MapPoint,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Side of a cell, metres.
    pub cell: f64,
}

impl GridGeometry {
    /// The grid over the box from `low` to `high`, each side at most `max_cells` cells long; `cell`
    /// is the side of a cell, metres.
    pub fn covering(low: MapPoint, high: MapPoint, cell: f64, max_cells: usize) -> Self {
        // At least one cell, also where `low` is beyond `high`. The cast saturates, so an infinite
        // box has `max_cells`.
        let count = |a: f64, b: f64| (((b - a) / cell).ceil().max(1.0) as usize).min(max_cells);
        Self {
            origin: low,
            width: count(low.x, high.x),
            height: count(low.y, high.y),
            cell,
        }
    }

    /// The middle of the grid.
    pub fn middle(&self) -> MapPoint {
        MapPoint::new(
            self.origin.x + 0.5 * self.width as f64 * self.cell,
            self.origin.y + 0.5 * self.height as f64 * self.cell,
        )
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// Whether the grid has no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cell that holds `point`, if the grid does.
    pub fn cell_at(&self, point: MapPoint) -> Option<usize> {
        let (x, y) = (
            (point.x - self.origin.x) / self.cell,
            (point.y - self.origin.y) / self.cell,
        );
        // Before the casts, which would turn -0.5 into column 0. False for NaN.
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }

    /// Column and row of a cell.
    pub fn column_row(&self, cell: usize) -> (i64, i64) {
        ((cell % self.width) as i64, (cell / self.width) as i64)
    }

    /// The cell in a column and row, if the grid has it.
    pub fn cell_in(&self, column: i64, row: i64) -> Option<usize> {
        let inside =
            column >= 0 && row >= 0 && column < self.width as i64 && row < self.height as i64;
        inside.then(|| row as usize * self.width + column as usize)
    }

    /// The cells around a cell, up to eight.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (column, row) = self.column_row(cell);
        let steps = NEIGHBOURS.into_iter();
        steps.filter_map(move |(dx, dy)| self.cell_in(column + dx, row + dy))
    }

    /// The middle of a cell.
    pub fn center(&self, cell: usize) -> MapPoint {
        let (x, y) = self.column_row(cell);
        MapPoint::new(
            self.origin.x + (x as f64 + 0.5) * self.cell,
            self.origin.y + (y as f64 + 0.5) * self.cell,
        )
    }

    /// Distance between the middles of two cells, in sides of cells.
    pub fn cells_apart(&self, a: usize, b: usize) -> f64 {
        let ((ax, ay), (bx, by)) = (self.column_row(a), self.column_row(b));
        let (dx, dy) = ((ax - bx) as f64, (ay - by) as f64);
        (dx * dx + dy * dy).sqrt()
    }

    /// The cells of the box between two points, cut off at the grid's border: ranges of columns and
    /// rows, both inclusive; `None` if there are none.
    pub fn window(&self, low: MapPoint, high: MapPoint) -> Option<((i64, i64), (i64, i64))> {
        // Signed, so that a box to the west of the grid is seen to be outside.
        let index = |v: f64, origin: f64| ((v - origin) / self.cell).floor() as i64;
        let columns = (
            index(low.x, self.origin.x).max(0),
            index(high.x, self.origin.x).min(self.width as i64 - 1),
        );
        let rows = (
            index(low.y, self.origin.y).max(0),
            index(high.y, self.origin.y).min(self.height as i64 - 1),
        );
        (columns.0 <= columns.1 && rows.0 <= rows.1).then_some((columns, rows))
    }

    /// The cells of the box between two points, row by row from the south-west; none outside the
    /// grid.
    pub fn cells_between(
        &self,
        low: MapPoint,
        high: MapPoint,
    ) -> impl Iterator<Item = usize> + use<> {
        let width = self.width;
        let window = self.window(low, high).into_iter();
        window.flat_map(move |(columns, rows)| {
            (rows.0..=rows.1).flat_map(move |row| {
                (columns.0..=columns.1).map(move |column| row as usize * width + column as usize)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_agree() {
        let grid = GridGeometry::covering(
            MapPoint::new(-3.0, 2.0),
            MapPoint::new(4.0, 5.0),
            0.25,
            1000,
        );
        assert_eq!((grid.width, grid.height), (28, 12));
        for cell in 0..grid.len() {
            assert_eq!(grid.cell_at(grid.center(cell)), Some(cell));
        }
        assert_eq!(grid.cell_at(MapPoint::new(-3.01, 3.0)), None);
        assert_eq!(grid.cell_at(MapPoint::new(0.0, f64::NAN)), None);
    }

    #[test]
    fn cells_of_a_box_come_row_by_row_and_end_at_the_border() {
        let grid = GridGeometry {
            origin: MapPoint::default(),
            width: 4,
            height: 3,
            cell: 1.0,
        };
        let cells = |low: f64, high: f64| -> Vec<usize> {
            grid.cells_between(MapPoint::new(low, low), MapPoint::new(high, high))
                .collect()
        };
        assert_eq!(cells(1.5, 2.5), [5, 6, 9, 10]);
        assert_eq!(cells(2.5, 9.0), [10, 11]);
        assert!(cells(-9.0, -1.0).is_empty());
    }
}
