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
        let window = Window {
            first: Cell {
                column: columns.0,
                row: rows.0,
            },
            last: Cell {
                column: columns.1,
                row: rows.1,
            },
        };
        // Borders suffice: nothing gets into a blocked area but across its border.
        let mut border = Border::of(self, window);
        let longest = (LONGEST_M / self.grid().cell) as i64;
        let mut walls = Vec::new();
        for cell in window.cells() {
            if let Some(end) = border.take_run(cell, longest) {
                walls.extend(self.wall(cell, end));
            }
        }
        walls
    }

    /// Whether one of the four cells beside a cell is open.
    fn is_rim(&self, cell: Cell) -> bool {
        !(self.is_blocked(cell.moved(EAST, 1))
            && self.is_blocked(cell.moved(WEST, 1))
            && self.is_blocked(cell.moved(NORTH, 1))
            && self.is_blocked(cell.moved(SOUTH, 1)))
    }

    /// Whether a cell of the grid holds an obstacle.
    fn is_blocked(&self, Cell { column, row }: Cell) -> bool {
        self.grid()
            .cell_in(column, row)
            .is_some_and(|cell| self.is_obstacle(cell))
    }

    /// The wall between the middles of two cells.
    fn wall(&self, from: Cell, to: Cell) -> Option<Obstacle> {
        let ends = [self.middle_of(from)?, self.middle_of(to)?];
        // A wall with both ends at one place would have no direction; one corner makes a disc.
        let corners = if from == to { &ends[..1] } else { &ends[..] };
        Obstacle::new(corners, self.grid().cell / 2.0, Vector2::ZERO).ok()
    }

    fn middle_of(&self, Cell { column, row }: Cell) -> Option<MapPoint> {
        let cell = self.grid().cell_in(column, row)?;
        Some(self.grid().center(cell))
    }
}

/// A cell of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cell {
    column: i64,
    row: i64,
}

/// Columns and rows to a neighbour of a cell.
type Direction = [i64; 2];

const EAST: Direction = [1, 0];
const WEST: Direction = [-1, 0];
const NORTH: Direction = [0, 1];
const SOUTH: Direction = [0, -1];

impl Cell {
    /// The cell so many steps on in a direction.
    fn moved(self, [columns, rows]: Direction, steps: i64) -> Self {
        Self {
            column: self.column + steps * columns,
            row: self.row + steps * rows,
        }
    }
}

/// A rectangle of cells, both corners included.
#[derive(Debug, Clone, Copy)]
struct Window {
    first: Cell,
    last: Cell,
}

impl Window {
    /// All cells, row by row.
    fn cells(self) -> impl Iterator<Item = Cell> {
        let Self { first, last } = self;
        (first.row..=last.row).flat_map(move |row| {
            (first.column..=last.column).map(move |column| Cell { column, row })
        })
    }

    fn width(self) -> usize {
        (self.last.column - self.first.column + 1) as usize
    }
}

/// Cells of a window at the borders of blocked areas.
struct Border {
    window: Window,
    is_border: Vec<bool>,
}

impl Border {
    /// The border cells of a window that lies on the costmap.
    fn of(costmap: &Costmap, window: Window) -> Self {
        let width = costmap.grid().width;
        let is_border = window.cells().map(|cell| {
            let index = cell.row as usize * width + cell.column as usize;
            // Most cells are open: their neighbours need not be looked at.
            costmap.is_obstacle(index) && costmap.is_rim(cell)
        });
        Self {
            window,
            is_border: is_border.collect(),
        }
    }

    /// Takes the longer of the runs of border cells to the east and to the north of a cell,
    /// `longest` cells at most; its last cell, or `None` if the cell is no border.
    fn take_run(&mut self, cell: Cell, longest: i64) -> Option<Cell> {
        if !self.is_border[self.index(cell)] {
            return None;
        }
        let east = self.run(cell, EAST, longest);
        let north = self.run(cell, NORTH, longest);
        let (direction, steps) = if east >= north {
            (EAST, east)
        } else {
            (NORTH, north)
        };
        for k in 0..=steps {
            let index = self.index(cell.moved(direction, k));
            self.is_border[index] = false;
        }
        Some(cell.moved(direction, steps))
    }

    /// How many border cells follow a cell in a direction without a gap.
    fn run(&self, cell: Cell, direction: Direction, longest: i64) -> i64 {
        (1..longest)
            .take_while(|&k| self.is_border(cell.moved(direction, k)))
            .count() as i64
    }

    /// Whether a cell to the east or north of one of the window is a border cell of the window.
    fn is_border(&self, cell: Cell) -> bool {
        let last = self.window.last;
        cell.column <= last.column && cell.row <= last.row && self.is_border[self.index(cell)]
    }

    fn index(&self, cell: Cell) -> usize {
        let first = self.window.first;
        (cell.row - first.row) as usize * self.window.width()
            + (cell.column - first.column) as usize
    }
}
