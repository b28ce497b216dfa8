//! Costmaps as grids that other programs keep or show.

use openbench_core::{CostGrid, MapPoint, RobotDescription};

use super::ground::{Ground, MappedObstacle, Surface};
use super::map_server::Occupancy;
use super::{CELLS_M, Costmap, CostmapError, MOST_CELLS, Preferences, Room};

impl Costmap {
    /// The costmap of a grid as ROS's map server keeps it: what is not likely occupied
    /// ([`Occupancy::LIKELY`]) is open.
    pub fn from_occupancy(
        occupancy: &Occupancy,
        robot: &RobotDescription,
    ) -> Result<Self, CostmapError> {
        let grid = &occupancy.grid;
        let most = MOST_CELLS as usize + 1;
        let fits = (1..=most).contains(&grid.width) && (1..=most).contains(&grid.height);
        let is_somewhere = grid.origin.x.is_finite() && grid.origin.y.is_finite();
        if !fits
            || grid.len() != occupancy.cells.len()
            || !CELLS_M.contains(&grid.cell)
            || !is_somewhere
        {
            return Err(CostmapError::NoGrid(grid.width, grid.height));
        }
        if occupancy.yaw != 0.0 {
            return Err(CostmapError::Turned(occupancy.yaw));
        }
        // Kinds of ground stay unknown: such a grid says nothing about them.
        let mut ground = Ground::unknown(occupancy.grid.len());
        for (obstacle, value) in ground.obstacles.iter_mut().zip(&occupancy.cells) {
            *obstacle = if *value >= Occupancy::LIKELY {
                MappedObstacle::Solid
            } else {
                MappedObstacle::No
            };
        }
        Ok(Self::over(
            occupancy.grid,
            ground,
            Room::of(robot)?,
            Preferences::NONE,
        ))
    }

    /// The estimate of the ground as ROS's map server keeps it: occupied; free by LiDAR data or the
    /// map; or unknown.
    pub fn occupancy(&self) -> Occupancy {
        Occupancy {
            grid: self.grid,
            yaw: 0.0,
            cells: (0..self.grid.len())
                .map(|cell| self.occupancy_of(cell))
                .collect(),
        }
    }

    /// The part of the costmap within `half_m` metres of a place along x and y, as it is shown.
    pub fn around(&self, place: MapPoint, half_m: f64) -> CostGrid {
        let grid = &self.grid;
        let low = |at: f64, origin: f64| ((at - half_m - origin) / grid.cell).max(0.0) as usize;
        let high = |at: f64, origin: f64| ((at + half_m - origin) / grid.cell).max(0.0) as usize;
        let columns = low(place.x, grid.origin.x)..high(place.x, grid.origin.x).min(grid.width);
        let rows = low(place.y, grid.origin.y)..high(place.y, grid.origin.y).min(grid.height);
        let row = |y: usize| columns.clone().map(move |x| self.shown(y * grid.width + x));
        CostGrid {
            origin: MapPoint::new(
                grid.origin.x + columns.start as f64 * grid.cell,
                grid.origin.y + rows.start as f64 * grid.cell,
            ),
            cell_m: grid.cell,
            width: columns.len(),
            cells: rows.clone().flat_map(row).collect(),
        }
    }

    /// The value of a cell as it is shown.
    fn shown(&self, cell: usize) -> i8 {
        /// As in ROS: free, but the robot does not fit.
        const TOO_NARROW: i8 = 99;
        match self.occupancy_of(cell) {
            Occupancy::FREE if self.cost(cell).is_none() => TOO_NARROW,
            value => value,
        }
    }

    /// The value of a cell in an occupancy grid.
    fn occupancy_of(&self, cell: usize) -> i8 {
        if self.is_obstacle(cell) {
            Occupancy::OCCUPIED
        } else if self.seen.is_free(cell) || self.ground.surface[cell] != Surface::Unknown {
            Occupancy::FREE
        } else {
            Occupancy::UNKNOWN
        }
    }
}
