//! A grid of what is known to be occupied.

use openbench_geometry::grid::GridGeometry;

/// A grid of what is known to be occupied (`nav_msgs/OccupancyGrid`).
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    /// Its cells; where [`Occupancy::yaw`] is not zero the grid is turned about its origin.
    pub grid: GridGeometry,
    /// Direction of its rows, radians counter-clockwise from east.
    pub yaw: f64,
    /// Row by row from the south: [`Occupancy::UNKNOWN`], or how likely the cell is occupied, from
    /// [`Occupancy::FREE`] to [`Occupancy::OCCUPIED`].
    pub cells: Vec<i8>,
}

impl Occupancy {
    /// Nothing is known of the cell.
    pub const UNKNOWN: i8 = -1;
    /// The cell is free.
    pub const FREE: i8 = 0;
    /// From here on the cell is likely occupied.
    pub const LIKELY: i8 = 65;
    /// The cell is occupied.
    pub const OCCUPIED: i8 = 100;
}
