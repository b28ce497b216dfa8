//! What is known about the ground: buildings, walls and water of the map, and what the LiDAR saw.
//!
//! LiDAR data override the map: a recessed door lies inside its building's outline, and a map may
//! be wrong. Only of water they say nothing. Distances to obstacles are exact (Euclidean distance
//! transform).
//!
//! | module | contents |
//! |---|---|
//! | `exchange` | as grids that other programs keep or show |
//! | `ground` | the layer of the map: obstacles, and kinds of ground |
//! | `seen` | the layer of the LiDAR: hits and free beams, forgotten after a minute |
//! | `walls` | both layers as obstacles for a local planner |
//! | `overview` | [`Overview`]: paths between places far apart, in coarser cells |
//! | `rolling_window` | [`RollingWindow`]: both layers around the robot, in finer cells that move along |
//! | [`map_server`] | files of ROS's map server |

mod exchange;
mod ground;
pub mod map_server;
mod overview;
mod rolling_window;
mod seen;
mod walls;

use openbench_core::{MapPoint, Pose2, RobotDescription};
use openbench_geometry::grid::{GridGeometry, squared_distances};
use openbench_osm::OsmMap;

use crate::costmap::ground::{Ground, MappedObstacle};
use crate::costmap::seen::Seen;
use crate::obstacles::RangeRing;
use crate::search::Costs;
use crate::shape::{Footprint, ShapeError};

pub use ground::Preferences;
pub use overview::{ObstacleKind, Obstruction, Overview};
pub use rolling_window::RollingWindow;

/// Side of a cell, metres, unless the map is so large that cells must be larger.
const CELL_M: f64 = 0.1;
/// Sides that cells may have, metres.
const CELLS_M: std::ops::RangeInclusive<f64> = 1e-4..=1e3;
/// Most cells along one side.
const MOST_CELLS: f64 = 2500.0;
/// Distance beyond the inscribed circle that a path keeps from obstacles, metres.
const MARGIN_M: f64 = 0.05;
/// Distance beyond the circumscribed circle at which obstacles no longer cost anything, metres.
const COMFORT_M: f64 = 0.68;
/// Cost that the nearest obstacle adds to a cell, in cells of open ground.
const DISCOMFORT: f64 = 6.0;
/// Costs of nearness are multiples of this: irrelevant differences would make a search visit cells
/// again and again.
const GRAIN: f64 = 1.0 / 16.0;

/// A costmap cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CostmapError {
    /// A corner of the area is not finite, or the area has no size.
    #[error(
        "the area from {low} to {high} has no size; give two finite corners, the lower one first"
    )]
    NoArea {
        /// Lower corner.
        low: MapPoint,
        /// Upper corner.
        high: MapPoint,
    },
    /// A kind of ground costs less than 1 or more than [`Preferences::DEAREST`].
    #[error("{0:?} are out of range; give costs from 1 to 20")]
    Preferences(Preferences),
    /// A grid has no cells, too many, another number than its sides say, or no finite place.
    #[error(
        "a grid of {0} by {1} cells cannot be used; give 1 to 2501 cells each way, of 0.1 mm \
         to 1 km, a value for each, and a finite origin"
    )]
    NoGrid(usize, usize),
    /// A grid is turned: the costmap's columns run east and its rows north.
    #[error("the grid is turned by {0} rad; give one whose rows run east")]
    Turned(f64),
    /// The robot has no footprint.
    #[error(transparent)]
    Robot(#[from] ShapeError),
}

/// Distances of the robot's middle from obstacles.
#[derive(Debug, Clone, Copy)]
struct Room {
    /// Least distance, metres: nearer it touches them at any heading.
    keep: f64,
    /// Distance from which on obstacles cost nothing, metres: it may turn freely.
    comfort: f64,
}

impl Room {
    fn of(robot: &RobotDescription) -> Result<Self, ShapeError> {
        let footprint = Footprint::of(robot)?;
        Ok(Self {
            keep: footprint.inscribed() + MARGIN_M,
            comfort: footprint.circumscribed() + COMFORT_M,
        })
    }
}

/// A grid of the ground with the cost of driving through each cell.
#[derive(Debug, Clone)]
pub struct Costmap {
    grid: GridGeometry,
    ground: Ground,
    seen: Seen,
    /// Squared distance to the nearest obstacle in sides of cells, as of the last
    /// [`Costmap::inflate`].
    clearance: Vec<f32>,
    /// Cost of driving one side of a cell through each cell, infinite where the robot does not fit;
    /// as of the last [`Costmap::inflate`].
    costs: Vec<f32>,
    room: Room,
    preferences: Preferences,
}

impl Costmap {
    /// The costmap of an area of `map`, from `low` (south-west) to `high`, with its buildings,
    /// barriers and water; all ground costs the same.
    pub fn new(
        map: &OsmMap,
        low: MapPoint,
        high: MapPoint,
        robot: &RobotDescription,
    ) -> Result<Self, CostmapError> {
        Self::with_preferences(map, low, high, robot, Preferences::NONE)
    }

    /// The same with preferred kinds of ground.
    pub fn with_preferences(
        map: &OsmMap,
        low: MapPoint,
        high: MapPoint,
        robot: &RobotDescription,
        preferences: Preferences,
    ) -> Result<Self, CostmapError> {
        let finite = [low.x, low.y, high.x, high.y]
            .iter()
            .all(|c| c.is_finite() && c.abs() < 1e7);
        if !finite || high.x <= low.x || high.y <= low.y {
            return Err(CostmapError::NoArea { low, high });
        }
        if !preferences.is_sound() {
            return Err(CostmapError::Preferences(preferences));
        }
        let cell = CELL_M.max((high.x - low.x).max(high.y - low.y) / MOST_CELLS);
        let grid = GridGeometry::covering(low, high, cell, MOST_CELLS as usize + 1);
        let ground = Ground::of(map, &grid);
        Ok(Self::over(grid, ground, Room::of(robot)?, preferences))
    }

    /// Moves to the square that reaches `half` metres to each side of `middle`. The ground is the
    /// map's; LiDAR data are kept where both areas overlap. [`Costmap::inflate`] makes it count.
    pub fn cover(&mut self, map: &OsmMap, middle: MapPoint, half: f64) {
        let before = self.grid;
        // By whole cells, so that cells keep their places.
        let origin = MapPoint::new(
            nearest_border(middle.x - half, before.origin.x, before.cell),
            nearest_border(middle.y - half, before.origin.y, before.cell),
        );
        let side = ((2.0 * half / before.cell).ceil() as usize).clamp(1, MOST_CELLS as usize + 1);
        self.grid = GridGeometry {
            origin,
            width: side,
            height: side,
            cell: before.cell,
        };
        self.ground = Ground::of(map, &self.grid);
        self.seen.carry(&before, &self.grid);
    }

    fn over(grid: GridGeometry, ground: Ground, room: Room, preferences: Preferences) -> Self {
        let mut costmap = Self {
            ground,
            seen: Seen::nothing(grid.len()),
            clearance: Vec::new(),
            costs: Vec::new(),
            room,
            preferences,
            grid,
        };
        costmap.inflate();
        costmap
    }

    /// The cells.
    pub fn grid(&self) -> &GridGeometry {
        &self.grid
    }

    /// The points of a scan where the ground was known to be free a moment ago, away from standing
    /// obstacles: moving bodies.
    pub fn new_points(&self, ring: &RangeRing) -> Vec<MapPoint> {
        ring.obstacles
            .iter()
            .map(|point| point.at)
            .filter(|point| self.is_new_at(*point))
            .collect()
    }

    /// Whether the ground at a point was free a moment ago.
    fn is_new_at(&self, point: MapPoint) -> bool {
        self.grid
            .cell_at(point)
            .is_some_and(|cell| self.is_new(cell))
    }

    /// Whether a cell was free a moment ago, and the cells around it were or are free.
    fn is_new(&self, cell: usize) -> bool {
        let (x, y) = self.grid.column_row(cell);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let mut around = around.filter_map(|(x, y)| self.grid.cell_in(x, y));
        // Beside a standing obstacle a new point may be of its edge.
        around.all(|c| self.seen.was_free(c) || !self.is_obstacle(c)) && self.seen.was_free(cell)
    }

    /// Takes in a scan. [`Costmap::inflate`] makes it count.
    pub fn observe(&mut self, ring: &RangeRing) {
        self.observe_static(ring, |_| false);
    }

    /// The same without the points for which `moves` says that they belong to moving bodies.
    pub fn observe_static(&mut self, ring: &RangeRing, moves: impl Fn(MapPoint) -> bool) {
        self.seen.observe(&self.grid, ring, moves);
    }

    /// Forgets all LiDAR data. [`Costmap::inflate`] makes it count.
    pub fn forget_seen(&mut self) {
        self.seen = Seen::nothing(self.grid.len());
    }

    /// Computes distances to obstacles and costs anew, and forgets obstacles that were not seen for
    /// a minute.
    pub fn inflate(&mut self) {
        self.seen.forget();
        let blocked: Vec<bool> = (0..self.grid.len()).map(|c| self.is_obstacle(c)).collect();
        self.clearance = squared_distances(&blocked, self.grid.width, self.grid.height);
        // Clearances are squared, and in sides of cells.
        let comfort = (self.room.comfort / self.grid.cell).powi(2) as f32;
        let costs = self.clearance.iter().enumerate().map(|(cell, clearance)| {
            // Most cells are far from everything.
            if *clearance > comfort {
                self.preferences.of(self.ground.surface[cell])
            } else {
                self.cost_now(cell)
            }
        });
        self.costs = costs.collect();
    }

    /// Whether a cell holds an obstacle, by the newest evidence.
    pub fn is_obstacle(&self, cell: usize) -> bool {
        match self.ground.obstacles[cell] {
            MappedObstacle::Water => true,
            // The map counts until beams have passed through, and again once they hit something
            // there.
            MappedObstacle::Solid => self.seen.is_hit(cell) || !self.seen.is_free(cell),
            MappedObstacle::No => self.seen.is_hit(cell),
        }
    }

    /// Distance from a cell to the nearest obstacle, metres, as of the last inflation.
    pub fn clearance(&self, cell: usize) -> f64 {
        f64::from(self.clearance[cell]).sqrt() * self.grid.cell
    }

    /// Distance from `point` to the nearest obstacle, metres; zero outside the map.
    pub fn clearance_at(&self, point: MapPoint) -> f64 {
        self.grid.cell_at(point).map_or(0.0, |c| self.clearance(c))
    }

    /// Cost of driving one side of a cell through a cell, as of the last inflation: 1 far from
    /// obstacles on preferred ground, more near them and elsewhere; `None` where the robot does not
    /// fit.
    pub fn cost(&self, cell: usize) -> Option<f64> {
        let cost = self.costs[cell];
        cost.is_finite().then(|| f64::from(cost))
    }

    /// Cost of a cell from its clearance, infinite where the robot does not fit.
    fn cost_now(&self, cell: usize) -> f32 {
        let clearance = self.clearance(cell);
        let Room { keep, comfort } = self.room;
        if clearance < keep {
            return f32::INFINITY;
        }
        // From 0 at the comfortable distance to 1 at the least one. The square begins without a
        // kink.
        let near = (comfort - clearance).max(0.0) / (comfort - keep);
        // In grains: a search over a large costmap then takes little more than half the time.
        let cost = 1.0 + (DISCOMFORT * near * near / GRAIN).round() * GRAIN;
        self.preferences.of(self.ground.surface[cell]) * cost as f32
    }

    /// The costs of all cells, as of the last inflation.
    pub fn costs(&self) -> Costs<'_> {
        Costs::known(self.grid.width, &self.costs)
    }

    /// Distance that the robot's middle keeps from obstacles, metres.
    pub fn keep(&self) -> f64 {
        self.room.keep
    }

    /// Whether the robot fits along the segment from `from` to `to`, by the newest evidence; cheap
    /// enough for every scan. Lenient by the diagonal of a cell, since a path is planned between
    /// the middles of cells.
    pub fn is_clear(&self, from: MapPoint, to: MapPoint) -> bool {
        let steps = (from.distance(to) / self.grid.cell).ceil().max(1.0) as usize;
        (0..=steps).all(|i| {
            let t = i as f64 / steps as f64;
            let p = MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            // A point of the line is up to 0.71 sides away from the middle of its cell, for which
            // alone the path was planned.
            self.nearest_obstacle_within(p, self.room.keep - 0.75 * self.grid.cell)
                .is_none()
        })
    }

    /// Distance from `point` to the nearest obstacle by the newest evidence, metres, if it is less
    /// than `reach`.
    pub(crate) fn nearest_obstacle_within(&self, point: MapPoint, reach: f64) -> Option<f64> {
        let low = MapPoint::new(point.x - reach, point.y - reach);
        let high = MapPoint::new(point.x + reach, point.y + reach);
        self.grid
            .cells_between(low, high)
            .filter(|&c| self.is_obstacle(c))
            .map(|c| self.grid.center(c).distance(point))
            .filter(|&d| d < reach)
            .reduce(f64::min)
    }

    /// Forgets obstacles where the robot is: there cannot be any. Water stays: the estimated pose
    /// may be off by more than the distance to the bank, and no scan would bring the water back.
    pub fn clear_below(&mut self, footprint: &Footprint, pose: Pose2) {
        for cell in self.obstacles_below(footprint, pose) {
            self.seen.clear(cell);
        }
    }

    /// Cells below the robot that hold an obstacle by the newest evidence.
    fn obstacles_below(&self, footprint: &Footprint, pose: Pose2) -> Vec<usize> {
        let (placed, reach) = (footprint.at(pose), footprint.circumscribed());
        let low = MapPoint::new(pose.x - reach, pose.y - reach);
        let high = MapPoint::new(pose.x + reach, pose.y + reach);
        self.grid
            .cells_between(low, high)
            .filter(|cell| self.is_obstacle(*cell) && placed.holds(self.grid.center(*cell)))
            .collect()
    }
}

/// The border between cells nearest to a coordinate, metres; one of the borders is at `origin`.
fn nearest_border(at: f64, origin: f64, cell: f64) -> f64 {
    origin + ((at - origin) / cell).round() * cell
}

#[cfg(test)]
pub(crate) mod tests;
