//! Obstacles of a costmap for a local planner.

use openbench_core::MapPoint;

use crate::costmap::Costmap;
use crate::shape::Obstacle;
use crate::vector::Vector2;

/// Length of the longest wall, metres: long ones are near to much that they do not touch.
const LONGEST_M: f64 = 1.0;

impl Costmap {
    /// What stands within `reach` metres of a point, by the newest evidence: the borders of blocked
    /// areas, as walls as thick as a cell, none longer than a metre.
    pub fn obstacles_near(&self, point: MapPoint, reach: f64) -> Vec<Obstacle> {
        let low = MapPoint::new(point.x - reach, point.y - reach);
        let high = MapPoint::new(point.x + reach, point.y + reach);
        let Some((columns, rows)) = self.grid().window(low, high) else {
            return Vec::new();
        };
        let mut border = Border::of(self, columns, rows);
        let longest = (LONGEST_M / self.grid().cell) as i64;
        let mut walls = Vec::new();
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                if let Some(end) = border.take_run(column, row, longest) {
                    walls.extend(self.wall((column, row), end));
                }
            }
        }
        walls
    }

    /// Whether one of the four cells beside a cell is open.
    fn is_rim(&self, column: i64, row: i64) -> bool {
        let blocked = |dx: i64, dy: i64| {
            self.grid()
                .cell_in(column + dx, row + dy)
                .is_some_and(|cell| self.is_obstacle(cell))
        };
        !(blocked(1, 0) && blocked(-1, 0) && blocked(0, 1) && blocked(0, -1))
    }

    /// The wall between the middles of two cells.
    fn wall(&self, from: (i64, i64), to: (i64, i64)) -> Option<Obstacle> {
        let center = |(column, row)| {
            self.grid()
                .cell_in(column, row)
                .map(|cell| self.grid().center(cell))
        };
        let ends = [center(from)?, center(to)?];
        let corners = if from == to { &ends[..1] } else { &ends[..] };
        Obstacle::new(corners, self.grid().cell / 2.0, Vector2::ZERO).ok()
    }
}

/// Cells of a window at the borders of blocked areas.
struct Border {
    columns: (i64, i64),
    rows: (i64, i64),
    is_border: Vec<bool>,
}

impl Border {
    /// The border cells of a window, ranges inclusive.
    fn of(costmap: &Costmap, columns: (i64, i64), rows: (i64, i64)) -> Self {
        let mut is_border = Vec::new();
        for row in rows.0..=rows.1 {
            let first = row as usize * costmap.grid().width;
            is_border.extend((columns.0..=columns.1).map(|column| {
                // Most cells are open.
                costmap.is_obstacle(first + column as usize) && costmap.is_rim(column, row)
            }));
        }
        Self {
            columns,
            rows,
            is_border,
        }
    }

    /// Takes the longer of the runs of border cells to the east and to the north of a cell,
    /// `longest` cells at most; the column and row of its last cell, or `None` if the cell is no
    /// border.
    fn take_run(&mut self, column: i64, row: i64, longest: i64) -> Option<(i64, i64)> {
        if !self.is_border[self.index(column, row)] {
            return None;
        }
        let east = self.run(column, row, (1, 0), longest);
        let north = self.run(column, row, (0, 1), longest);
        let (dx, dy) = if east >= north { (east, 0) } else { (0, north) };
        for k in 0..=dx.max(dy) {
            let index = self.index(column + k * dx.signum(), row + k * dy.signum());
            self.is_border[index] = false;
        }
        Some((column + dx, row + dy))
    }

    /// How many border cells follow a cell in a direction without a gap.
    fn run(&self, column: i64, row: i64, (dx, dy): (i64, i64), longest: i64) -> i64 {
        let is_border = |k: i64| {
            let (x, y) = (column + k * dx, row + k * dy);
            x <= self.columns.1 && y <= self.rows.1 && self.is_border[self.index(x, y)]
        };
        (1..longest).take_while(|&k| is_border(k)).count() as i64
    }

    fn index(&self, column: i64, row: i64) -> usize {
        let width = (self.columns.1 - self.columns.0 + 1) as usize;
        (row - self.rows.0) as usize * width + (column - self.columns.0) as usize
    }
}
