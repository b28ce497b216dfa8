//! What is known about the ground: buildings, walls and water of the map, and what the LiDAR saw.
//!
//! LiDAR data override the map: a recessed door lies inside its building's outline, and a map may
//! be wrong. Only of water they say nothing. Distances to obstacles are exact (Euclidean distance
//! transform).
//!
//! | module | contents |
//! |---|---|
//! | `ground` | the layer of the map: obstacles, and kinds of ground |
//! | `seen` | the layer of the LiDAR: hits and free beams, forgotten after a minute |
//! | `walls` | both layers as obstacles for a local planner |
//! | `overview` | [`Overview`]: paths between places far apart, in coarser cells |
//! | `rolling_window` | [`RollingWindow`]: both layers around the robot, in finer cells that move along |
//! | [`map_server`] | files of ROS's map server |

mod ground;
pub mod map_server;
mod overview;
mod rolling_window;
mod seen;
mod walls;

use openbench_core::{CostGrid, MapPoint, Pose2, RobotDescription};
use openbench_geometry::grid::{GridGeometry, squared_distances};
use openbench_osm::OsmMap;

use crate::costmap::ground::{Ground, MappedObstacle, Surface};
use crate::costmap::map_server::Occupancy;
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
pub(crate) mod tests {
    use super::*;
    use crate::obstacles::{Beam, ScanPoint};
    use openbench_core::{Georeference, LonLat};
    use openbench_geometry::Polygon;
    use openbench_osm::{Area, Barrier, ElementId, ElementKind, OsmData};

    pub(crate) fn empty_map() -> OsmMap {
        OsmMap::new(
            &OsmData::default(),
            Georeference::tangent_plane(LonLat::new(8.0, 50.0)),
        )
    }

    pub(crate) fn open_ground() -> Costmap {
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        Costmap::new(&empty_map(), low, high, &RobotDescription::sentry()).unwrap()
    }

    pub(crate) fn see_wall(costmap: &mut Costmap, from: MapPoint, to: MapPoint) {
        let points = (0..=200).map(|i| {
            let t = f64::from(i) / 200.0;
            ScanPoint::new(
                MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)),
                0.3,
            )
        });
        costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, points));
        costmap.inflate();
    }

    #[test]
    fn kerbs_block_except_where_a_road_leads_over_them() {
        let line = |points: [(f64, f64); 2]| points.map(|(x, y)| MapPoint::new(x, y)).to_vec();
        let mut map = empty_map();
        let kerb = [("barrier", "kerb")].into_iter().collect();
        map.barriers.push(Barrier {
            way: 1,
            points: line([(-8.0, 0.0), (8.0, 0.0)]),
            gates: vec![],
            tags: kerb,
        });
        let path = [("highway", "footway")].into_iter().collect();
        let points = line([(2.0, -9.0), (2.0, 9.0)]);
        map.roads.push(openbench_osm::Road {
            way: 2,
            nodes: vec![1, 2],
            points,
            tags: path,
        });
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        let costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
        let closed =
            |x: f64| costmap.is_obstacle(costmap.grid.cell_at(MapPoint::new(x, 0.0)).unwrap());
        assert!(closed(-5.0) && closed(6.0) && !closed(2.0) && !closed(1.3));
    }

    #[test]
    fn a_seen_obstacle_blocks_until_beams_pass_through_it() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -1.0),
            MapPoint::new(2.0, 1.0),
        );
        let beside = costmap.grid().cell_at(MapPoint::new(1.9, 0.0)).unwrap();
        assert_eq!(costmap.cost(beside), None);
        assert!(!costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
        // The wall has gone: beams reach the ground behind it.
        let ground = |i: i32| ScanPoint::new(MapPoint::new(5.0, f64::from(i) / 20.0), 0.0);
        for _ in 0..12 {
            costmap.observe(&RangeRing::new(
                MapPoint::default(),
                0.25,
                (-60..60).map(ground),
            ));
        }
        assert!(costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
    }

    #[test]
    fn an_obstacle_that_is_not_seen_for_a_minute_is_forgotten() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -1.0),
            MapPoint::new(2.0, 1.0),
        );
        let wall = costmap.grid().cell_at(MapPoint::new(2.0, 0.0)).unwrap();
        let elsewhere = || {
            RangeRing::new(
                MapPoint::new(-9.0, 0.0),
                0.25,
                std::iter::once(ScanPoint::new(MapPoint::new(-9.5, 0.0), 0.3)),
            )
        };
        for (scans, is_known) in [(599, true), (2, false)] {
            (0..scans).for_each(|_| costmap.observe(&elsewhere()));
            costmap.inflate();
            assert_eq!(
                (costmap.is_obstacle(wall), costmap.cost(wall).is_none()),
                (is_known, is_known)
            );
        }
    }

    #[test]
    fn costs_fall_from_the_inscribed_circle_to_beyond_the_circumscribed_one() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.05, -10.0),
            MapPoint::new(2.05, 10.0),
        );
        let robot = Footprint::of(&RobotDescription::sentry()).unwrap();
        let costs: Vec<(f64, Option<f64>)> = (0..20)
            .map(|i| MapPoint::new(1.95 - 0.1 * f64::from(i), 0.05))
            .map(|p| {
                (
                    costmap.clearance_at(p),
                    costmap.cost(costmap.grid().cell_at(p).unwrap()),
                )
            })
            .collect();
        for (clearance, cost) in &costs {
            assert_eq!(
                cost.is_none(),
                *clearance < robot.inscribed() + MARGIN_M,
                "{clearance} {cost:?}"
            );
            assert_eq!(
                *cost == Some(1.0),
                *clearance >= robot.circumscribed() + COMFORT_M - 0.1,
                "{clearance} {cost:?}"
            );
        }
        let known: Vec<f64> = costs.iter().filter_map(|(_, cost)| *cost).collect();
        assert!(
            known[0] > 5.0 && known.windows(2).all(|w| w[0] >= w[1]),
            "{known:?}"
        );
    }

    #[test]
    fn a_low_obstacle_stays_though_beams_pass_over_it() {
        let mut costmap = open_ground();
        // A kerb of 12 cm, seen from afar; then the robot stands before it, and its lowest beam
        // reaches the ground behind.
        let kerb =
            (0..=40).map(|i| ScanPoint::new(MapPoint::new(2.0, f64::from(i) * 0.05 - 1.0), 0.12));
        costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, kerb));
        let behind = |i: i32| ScanPoint::new(MapPoint::new(3.7, f64::from(i) / 30.0), 0.0);
        for _ in 0..30 {
            costmap.observe(&RangeRing::new(
                MapPoint::new(1.4, 0.0),
                0.25,
                (-60..60).map(behind),
            ));
        }
        assert!(!costmap.is_clear(MapPoint::new(1.4, 0.0), MapPoint::new(3.0, 0.0)));
    }

    #[test]
    fn water_stays_though_beams_pass_over_it_and_the_robot_is_in_it() {
        let mut map = empty_map();
        let corners =
            [(2.0, -9.0), (9.0, -9.0), (9.0, 9.0), (2.0, 9.0)].map(|(x, y)| MapPoint::new(x, y));
        map.areas.push(Area {
            element: ElementId {
                kind: ElementKind::Way,
                id: 1,
            },
            polygon: Polygon::new(corners.to_vec(), vec![]).unwrap(),
            tags: [("natural", "water")].into_iter().collect(),
        });
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        let mut costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
        let beyond = |i: i32| ScanPoint::new(MapPoint::new(9.5, f64::from(i) / 20.0), 0.0);
        for _ in 0..12 {
            costmap.observe(&RangeRing::new(
                MapPoint::default(),
                0.25,
                (-60..60).map(beyond),
            ));
        }
        let is_clear = |costmap: &Costmap, x: f64| {
            costmap.is_clear(MapPoint::new(x, 0.0), MapPoint::new(x, 0.0))
        };
        assert!(is_clear(&costmap, 0.0) && !is_clear(&costmap, 5.0));
        let robot = Footprint::of(&RobotDescription::sentry()).unwrap();
        let at = Pose2::new(5.0, 0.0, 0.0);
        costmap.clear_below(&robot, at);
        assert!(costmap.is_obstacle(costmap.grid().cell_at(at.point()).unwrap()));
    }

    #[test]
    fn a_costmap_is_written_and_read_again() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -1.0),
            MapPoint::new(2.0, 1.0),
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ground.yaml");
        map_server::write(&path, &costmap.occupancy()).unwrap();
        let read = map_server::read(&path).unwrap();
        let again = Costmap::from_occupancy(&read, &RobotDescription::sentry()).unwrap();
        assert_eq!(again.grid(), costmap.grid());
        let blocked = |costmap: &Costmap| {
            (0..costmap.grid().len())
                .map(|c| costmap.cost(c).is_none())
                .collect::<Vec<_>>()
        };
        assert!(blocked(&again).contains(&true));
        assert_eq!(blocked(&again), blocked(&costmap));
    }

    #[test]
    fn grids_that_cannot_be_used_are_refused() {
        let robot = RobotDescription::sentry();
        let grid = GridGeometry {
            origin: MapPoint::default(),
            width: 2,
            height: 1,
            cell: 0.1,
        };
        let sound = Occupancy {
            grid,
            yaw: 0.0,
            cells: vec![64, 65],
        };
        let costmap = Costmap::from_occupancy(&sound, &robot).unwrap();
        assert!(!costmap.is_obstacle(0) && costmap.is_obstacle(1));
        for cell in [0.0, 1e-300, f64::NAN, f64::INFINITY] {
            let odd = Occupancy {
                grid: GridGeometry { cell, ..grid },
                ..sound.clone()
            };
            assert_eq!(
                Costmap::from_occupancy(&odd, &robot).unwrap_err(),
                CostmapError::NoGrid(2, 1)
            );
        }
        let nowhere = GridGeometry {
            origin: MapPoint::new(f64::NAN, 0.0),
            ..grid
        };
        let nowhere = Occupancy {
            grid: nowhere,
            ..sound.clone()
        };
        assert_eq!(
            Costmap::from_occupancy(&nowhere, &robot).unwrap_err(),
            CostmapError::NoGrid(2, 1)
        );
        let empty = Occupancy {
            grid: GridGeometry { width: 0, ..grid },
            yaw: 0.0,
            cells: vec![],
        };
        assert_eq!(
            Costmap::from_occupancy(&empty, &robot).unwrap_err(),
            CostmapError::NoGrid(0, 1)
        );
        let few = Occupancy {
            cells: vec![0],
            ..sound.clone()
        };
        assert_eq!(
            Costmap::from_occupancy(&few, &robot).unwrap_err(),
            CostmapError::NoGrid(2, 1)
        );
        let turned = Occupancy { yaw: 0.5, ..sound };
        assert_eq!(
            Costmap::from_occupancy(&turned, &robot).unwrap_err(),
            CostmapError::Turned(0.5)
        );
    }

    #[test]
    fn a_beam_without_an_end_is_cut_off() {
        let mut costmap = open_ground();
        let mut ring = RangeRing::new(MapPoint::default(), 0.25, std::iter::empty());
        ring.beams = vec![
            Beam {
                reach: f64::INFINITY,
                end_height: 0.0,
            },
            Beam {
                reach: f64::NAN,
                end_height: 0.0,
            },
        ];
        costmap.observe(&ring);
        assert!(costmap.is_clear(MapPoint::default(), MapPoint::new(5.0, 0.0)));
    }

    #[test]
    fn impossible_areas_robots_and_preferences_are_refused() {
        let robot = RobotDescription::sentry();
        for (low, high) in [
            ((0.0, 0.0), (0.0, 5.0)),
            ((f64::NAN, 0.0), (1.0, 1.0)),
            ((5.0, 0.0), (0.0, 5.0)),
        ] {
            let corner = |c: (f64, f64)| MapPoint::new(c.0, c.1);
            let refused = Costmap::new(&empty_map(), corner(low), corner(high), &robot);
            assert!(matches!(refused, Err(CostmapError::NoArea { .. })));
        }
        let (low, high) = (MapPoint::default(), MapPoint::new(1.0, 1.0));
        for width in [f64::NAN, -1.0, 0.0] {
            let robot = RobotDescription {
                width,
                ..RobotDescription::sentry()
            };
            let refused = Costmap::new(&empty_map(), low, high, &robot);
            assert!(matches!(refused, Err(CostmapError::Robot(_))));
        }
        let odd = Preferences {
            road: 0.5,
            ..Preferences::NONE
        };
        let refused = Costmap::with_preferences(&empty_map(), low, high, &robot, odd);
        assert!(matches!(refused, Err(CostmapError::Preferences(_))));
    }

    #[test]
    fn clearance_is_euclidean() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(3.05, 0.05),
            MapPoint::new(3.05, 0.05),
        );
        let clearance = costmap.clearance_at(MapPoint::new(0.05, 4.05));
        assert!((clearance - 5.0).abs() < 1e-6, "{clearance}");
    }
}
