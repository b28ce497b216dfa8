//! Paths between places far apart, over coarser cells than a robot drives by.
//!
//! The map says where buildings, walls and water are. What the LiDAR saw where the robot has been
//! is remembered, so that a path that proved blocked is not found again. Mapped roads and paths are
//! preferred to ground of which the map says nothing: people who drew them knew that one gets
//! through.

use std::collections::BTreeMap;

use openbench_core::{MapPoint, RobotDescription};
use openbench_geometry::grid::GridGeometry;
use openbench_osm::OsmMap;

use crate::astar::{PlanError, costs, plan};
use crate::costmap::ground::{Ground, MappedObstacle, Preferences};
use crate::costmap::{Costmap, Room};
use crate::search::Search;
use crate::shape::ShapeError;

/// Side of the finest cells, metres.
const FINEST_M: f64 = 0.25;
/// Cells along the longer side, at most: the further apart the places, the coarser the cells.
const MOST_CELLS: f64 = 1400.0;
/// Ground around the places that is searched, metres,
const AROUND_M: f64 = 80.0;
/// and as a share of their distance, in addition.
const AROUND_SHARE: f64 = 0.4;
/// Side of the squares in which LiDAR data are remembered, metres.
const SQUARE_M: f64 = 0.2;
/// Costs of ground: worth detours of a quarter to stay on mapped roads and paths.
const MAPPED: Preferences = Preferences {
    pavement: 1.0,
    unknown: 1.25,
    road: 1.0,
    green: 1.25,
};

/// What was seen in a square, where the map says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    /// An obstacle.
    Hit,
    /// Free ground.
    Free,
}

/// A kind of obstacle between two places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ObstacleKind {
    /// Water of the map.
    Water,
    /// A building of the map.
    Building,
    /// A wall, fence or kerb of the map.
    Barrier,
    /// An obstacle that the LiDAR saw.
    Seen,
}

impl std::fmt::Display for ObstacleKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Water => "water of the map",
            Self::Building => "a building of the map",
            Self::Barrier => "a wall, fence or kerb of the map",
            Self::Seen => "an obstacle that was seen there",
        })
    }
}

/// An obstacle between two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstruction {
    /// Its kind.
    pub kind: ObstacleKind,
    /// Where, in `map`.
    pub at: MapPoint,
}

/// Remembers LiDAR data, and finds paths.
#[derive(Debug, Clone)]
pub struct Overview {
    room: Room,
    known: BTreeMap<Square, Known>,
}

impl Overview {
    /// Without any LiDAR data.
    pub fn new(robot: &RobotDescription) -> Result<Self, ShapeError> {
        Ok(Self {
            room: Room::of(robot)?,
            known: BTreeMap::new(),
        })
    }

    /// Remembers what a costmap has seen and the map does not say.
    pub fn note(&mut self, near: &Costmap) {
        // Obstacles that were seen to be gone are forgotten first. Squares are larger than cells,
        // and an obstacle in one of a square's cells counts.
        self.known.retain(|square, known| {
            let cell = near.grid.cell_at(square.middle());
            let is_gone = cell.is_some_and(|cell| near.seen.is_free(cell));
            *known == Known::Free || !is_gone
        });
        for cell in 0..near.grid.len() {
            let square = Square::at(near.grid.center(cell));
            match near.ground.obstacles[cell] {
                MappedObstacle::No if near.seen.is_hit(cell) => {
                    self.known.insert(square, Known::Hit);
                }
                MappedObstacle::Solid if near.seen.is_free(cell) => {
                    // A hit in another cell of the square is not overwritten.
                    self.known.entry(square).or_insert(Known::Free);
                }
                _ => {}
            }
        }
    }

    /// Forgets seen obstacles: they may have gone. Returns whether there were any.
    pub fn forget(&mut self) -> bool {
        let before = self.known.len();
        self.known.retain(|_, known| *known == Known::Free);
        self.known.len() < before
    }

    /// Forgets all LiDAR data.
    pub fn forget_all(&mut self) {
        self.known.clear();
    }

    /// The path from one place to another, both included, over the ground around them.
    pub fn path(
        &self,
        map: &OsmMap,
        from: MapPoint,
        to: MapPoint,
    ) -> Result<Vec<MapPoint>, PlanError> {
        plan(
            &mut Search::default(),
            &self.lay(map, from, &[to]),
            from,
            to,
        )
    }

    /// Costs of the paths from one place to others, in metres of mapped roads and paths; `None`
    /// where there is none.
    pub fn costs(&self, map: &OsmMap, from: MapPoint, to: &[MapPoint]) -> Vec<Option<f64>> {
        costs(&self.lay(map, from, to), from, to, f64::INFINITY)
    }

    /// The first obstacle on the straight line between two places.
    pub fn obstruction(&self, map: &OsmMap, from: MapPoint, to: MapPoint) -> Option<Obstruction> {
        let costmap = self.lay(map, from, &[to]);
        let steps = (from.distance(to) / costmap.grid.cell).ceil().max(1.0) as usize;
        (0..=steps).find_map(|i| {
            let t = i as f64 / steps as f64;
            let at = MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            let kind = match costmap.ground.obstacles[costmap.grid.cell_at(at)?] {
                MappedObstacle::No => return None,
                MappedObstacle::Water => ObstacleKind::Water,
                MappedObstacle::Solid if self.known.get(&Square::at(at)) == Some(&Known::Hit) => {
                    ObstacleKind::Seen
                }
                MappedObstacle::Solid if map.buildings.iter().any(|b| b.polygon.contains(at)) => {
                    ObstacleKind::Building
                }
                MappedObstacle::Solid => ObstacleKind::Barrier,
            };
            Some(Obstruction { kind, at })
        })
    }

    /// Map and memory over some places and the ground around them.
    fn lay(&self, map: &OsmMap, from: MapPoint, to: &[MapPoint]) -> Costmap {
        let (mut low, mut high) = (from, from);
        // A place without finite coordinates has no path; it must not stretch the grid for the
        // others.
        for place in to
            .iter()
            .filter(|place| place.x.is_finite() && place.y.is_finite())
        {
            low = MapPoint::new(low.x.min(place.x), low.y.min(place.y));
            high = MapPoint::new(high.x.max(place.x), high.y.max(place.y));
        }
        let around = AROUND_M + AROUND_SHARE * low.distance(high);
        let (low, high) = (
            MapPoint::new(low.x - around, low.y - around),
            MapPoint::new(high.x + around, high.y + around),
        );
        let cell = FINEST_M.max((high.x - low.x).max(high.y - low.y) / MOST_CELLS);
        let grid = GridGeometry::covering(low, high, cell, MOST_CELLS as usize + 1);
        let mut ground = Ground::of(map, &grid);
        for (square, known) in &self.known {
            let Some(cell) = grid.cell_at(square.middle()) else {
                continue;
            };
            // Neither case touches water, over which the LiDAR sees.
            match (known, &mut ground.obstacles[cell]) {
                (Known::Hit, obstacle) if *obstacle == MappedObstacle::No => {
                    *obstacle = MappedObstacle::Solid
                }
                (Known::Free, obstacle) if *obstacle == MappedObstacle::Solid => {
                    *obstacle = MappedObstacle::No
                }
                _ => {}
            }
        }
        Costmap::over(grid, ground, self.room, MAPPED)
    }
}

/// A square in which LiDAR data are remembered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Square {
    column: i32,
    row: i32,
}

impl Square {
    /// The square of a place.
    fn at(place: MapPoint) -> Self {
        // In an agent's own frame places are at most kilometres from the origin.
        Self {
            column: (place.x / SQUARE_M).floor() as i32,
            row: (place.y / SQUARE_M).floor() as i32,
        }
    }

    /// Its middle.
    fn middle(self) -> MapPoint {
        MapPoint::new(
            (f64::from(self.column) + 0.5) * SQUARE_M,
            (f64::from(self.row) + 0.5) * SQUARE_M,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::tests::{empty_map, open_ground, see_wall};
    use openbench_osm::Barrier;

    fn length(path: &[MapPoint]) -> f64 {
        path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    #[test]
    fn paths_of_a_kilometre_lead_around_mapped_walls() {
        let mut map = empty_map();
        let wall = [("barrier", "wall")].into_iter().collect();
        let points = [(400.0, -200.0), (400.0, 150.0)]
            .map(|(x, y)| MapPoint::new(x, y))
            .to_vec();
        map.barriers.push(Barrier {
            way: 1,
            points,
            gates: vec![],
            tags: wall,
        });
        let overview = Overview::new(&RobotDescription::sentry()).unwrap();
        let (from, to) = (MapPoint::new(0.0, 0.0), MapPoint::new(1000.0, 0.0));
        let path = overview.path(&map, from, to).unwrap();
        let end = MapPoint::new(400.0, 150.0);
        let shortest = from.distance(end) + end.distance(to);
        assert!(
            (shortest..1.02 * shortest).contains(&length(&path)),
            "{} for {shortest}",
            length(&path)
        );
        assert_eq!(
            overview.obstruction(&map, from, to).map(|found| found.kind),
            Some(ObstacleKind::Barrier)
        );
        assert_eq!(
            overview.obstruction(&map, from, MapPoint::new(100.0, 0.0)),
            None
        );
    }

    #[test]
    fn seen_obstacles_are_remembered_until_they_are_forgotten() {
        let mut near = open_ground();
        see_wall(&mut near, MapPoint::new(2.0, -9.0), MapPoint::new(2.0, 9.0));
        let mut overview = Overview::new(&RobotDescription::sentry()).unwrap();
        let (from, to) = (MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0));
        let straight = length(&overview.path(&empty_map(), from, to).unwrap());
        overview.note(&near);
        let round = length(&overview.path(&empty_map(), from, to).unwrap());
        assert!(straight < 4.1 && round > 15.0, "{straight} {round}");
        assert_eq!(
            overview
                .obstruction(&empty_map(), from, to)
                .map(|found| found.kind),
            Some(ObstacleKind::Seen)
        );
        assert!(overview.forget() && !overview.forget());
        assert!(length(&overview.path(&empty_map(), from, to).unwrap()) < 4.1);
    }
}
