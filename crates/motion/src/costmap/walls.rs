//! What is blocked in a costmap, as obstacles for a local planner.

use openbench_core::MapPoint;

use crate::costmap::Costmap;
use crate::shape::Obstacle;
use crate::vector::Vector2;

/// Length of the longest wall, metres: long ones are near to much that they do not touch.
const LONGEST: f64 = 1.0;

impl Costmap {
    /// What stands within `reach` metres of a point, by the newest evidence: the borders of what is blocked, as walls as thick as a cell, none longer than a metre.
    pub fn obstacles_near(&self, point: MapPoint, reach: f64) -> Vec<Obstacle> {
        let low = MapPoint::new(point.x - reach, point.y - reach);
        let high = MapPoint::new(point.x + reach, point.y + reach);
        let Some((columns, rows)) = self.grid().window(low, high) else { return Vec::new() };
        let width = (columns.1 - columns.0 + 1) as usize;
        let index = |column: i64, row: i64| (row - rows.0) as usize * width + (column - columns.0) as usize;
        let mut border = vec![false; width * (rows.1 - rows.0 + 1) as usize];
        for row in rows.0..=rows.1 {
            let first = row as usize * self.grid().width;
            for column in columns.0..=columns.1 {
                // Most cells are open.
                let blocked = self.is_obstacle(first + column as usize);
                border[index(column, row)] = blocked && self.is_rim(column, row);
            }
        }
        let longest = (LONGEST / self.grid().cell) as i64;
        let mut walls = Vec::new();
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                if !border[index(column, row)] {
                    continue;
                }
                let run = |dx: i64, dy: i64| {
                    let inside = |k: i64| column + k * dx <= columns.1 && row + k * dy <= rows.1;
                    let more = (1..longest)
                        .take_while(|&k| inside(k) && border[index(column + k * dx, row + k * dy)]);
                    more.count() as i64
                };
                let (east, north) = (run(1, 0), run(0, 1));
                let (dx, dy) = if east >= north { (east, 0) } else { (0, north) };
                for k in 0..=dx.max(dy) {
                    border[index(column + k * dx.signum(), row + k * dy.signum())] = false;
                }
                walls.extend(self.wall((column, row), (column + dx, row + dy)));
            }
        }
        walls
    }

    /// Whether one of the four cells beside a cell is open.
    fn is_rim(&self, column: i64, row: i64) -> bool {
        let blocked = |dx: i64, dy: i64| {
            self.grid().cell_in(column + dx, row + dy).is_some_and(|cell| self.is_obstacle(cell))
        };
        !(blocked(1, 0) && blocked(-1, 0) && blocked(0, 1) && blocked(0, -1))
    }

    fn wall(&self, from: (i64, i64), to: (i64, i64)) -> Option<Obstacle> {
        let center = |at: (i64, i64)| self.grid().cell_in(at.0, at.1).map(|cell| self.grid().center(cell));
        let ends = [center(from)?, center(to)?];
        let corners = if from == to { &ends[..1] } else { &ends[..] };
        Obstacle::new(corners, self.grid().cell / 2.0, Vector2::ZERO).ok()
    }
}
