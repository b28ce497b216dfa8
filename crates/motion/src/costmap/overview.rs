//! Ways between places far apart, over coarser cells than a robot drives by.
//!
//! The map says where buildings, walls and water are; what the LiDAR saw where the robot has been
//! is remembered, so that a way that proved blocked is not found again. Mapped roads and paths are
//! preferred to ground of which the map says nothing: people who drew them knew that one gets
//! through.

use std::collections::BTreeMap;

use openbench_core::{MapPoint, RobotDescription};
use openbench_grid::GridGeometry;
use openbench_osm::OsmMap;

use crate::astar::{PlanError, costs, plan};
use crate::costmap::ground::{Barred, Ground, Preferences};
use crate::costmap::{Costmap, Room};
use crate::search::Search;
use crate::shape::ShapeError;

/// Side of the finest cells, metres.
const FINEST: f64 = 0.25;
/// Cells along the longer side, at most: what is farther apart is looked at in coarser ones.
const SIDE: f64 = 1400.0;
/// Ground around the places that is looked at, metres, and the share of their distance.
const AROUND: (f64, f64) = (80.0, 0.4);
/// Side of the squares in which it is remembered what was seen, metres.
const MEMORY: f64 = 0.2;
/// What ground costs: detours of a quarter to stay on mapped ways.
const WAYS: Preferences = Preferences { pavement: 1.0, unknown: 1.25, road: 1.0, green: 1.25 };

/// What was seen in a square, where the map says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    /// Something stands there.
    Hit,
    /// Nothing does.
    Free,
}

/// What bars the way between two places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bar {
    /// Water of the map.
    Water,
    /// A building of the map.
    Building,
    /// A wall, fence or kerb of the map.
    Barrier,
    /// Something that the LiDAR saw.
    Seen,
}

impl std::fmt::Display for Bar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Water => "water of the map",
            Self::Building => "a building of the map",
            Self::Barrier => "a wall, fence or kerb of the map",
            Self::Seen => "something that was seen there",
        })
    }
}

/// What bars the way somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstruction {
    /// What it is.
    pub bar: Bar,
    /// Where, in `map`.
    pub at: MapPoint,
}

/// Remembers what was seen, and finds ways.
#[derive(Debug, Clone)]
pub struct Overview {
    room: Room,
    known: BTreeMap<(i32, i32), Known>,
}

impl Overview {
    /// Nothing was seen yet.
    pub fn new(robot: &RobotDescription) -> Result<Self, ShapeError> {
        Ok(Self { room: Room::of(robot)?, known: BTreeMap::new() })
    }

    /// Remembers what a costmap has seen and the map does not say.
    pub fn note(&mut self, near: &Costmap) {
        // What stood somewhere and was seen to be gone is forgotten first: squares are larger than
        // cells, and what stands in one of a square's cells counts.
        let is_gone = |square: &(i32, i32)| {
            let cell = near.grid.cell_at(middle(*square));
            cell.is_some_and(|cell| near.seen.is_free(cell))
        };
        self.known.retain(|square, known| *known == Known::Free || !is_gone(square));
        for cell in 0..near.grid.len() {
            let square = square(near.grid.center(cell));
            match near.ground.barred[cell] {
                Barred::No if near.seen.is_hit(cell) => drop(self.known.insert(square, Known::Hit)),
                Barred::Solid if near.seen.is_free(cell) => {
                    self.known.entry(square).or_insert(Known::Free);
                }
                _ => {}
            }
        }
    }

    /// Forgets what was seen to stand somewhere: it may have gone. Whether there was anything.
    pub fn forget(&mut self) -> bool {
        let before = self.known.len();
        self.known.retain(|_, known| *known == Known::Free);
        self.known.len() < before
    }

    /// Forgets all that was seen.
    pub fn forget_all(&mut self) {
        self.known.clear();
    }

    /// The way from one place to another, both included, over the ground around them.
    pub fn way(&self, map: &OsmMap, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        plan(&mut Search::default(), &self.lay(map, from, &[to]), from, to)
    }

    /// What the ways from one place to others cost, in metres of mapped ways; `None` where none
    /// leads.
    pub fn costs(&self, map: &OsmMap, from: MapPoint, to: &[MapPoint]) -> Vec<Option<f64>> {
        costs(&self.lay(map, from, to), from, to, f64::INFINITY)
    }

    /// What stands first on the straight line between two places.
    pub fn bar(&self, map: &OsmMap, from: MapPoint, to: MapPoint) -> Option<Obstruction> {
        let costmap = self.lay(map, from, &[to]);
        let steps = (from.distance(to) / costmap.grid.cell).ceil().max(1.0) as usize;
        (0..=steps).find_map(|i| {
            let t = i as f64 / steps as f64;
            let at = MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            let bar = match costmap.ground.barred[costmap.grid.cell_at(at)?] {
                Barred::No => return None,
                Barred::Water => Bar::Water,
                Barred::Solid if self.known.get(&square(at)) == Some(&Known::Hit) => Bar::Seen,
                Barred::Solid if map.buildings.iter().any(|b| b.polygon.contains(at)) => Bar::Building,
                Barred::Solid => Bar::Barrier,
            };
            Some(Obstruction { bar, at })
        })
    }

    /// Map and memory over the places and the ground around them.
    fn lay(&self, map: &OsmMap, from: MapPoint, to: &[MapPoint]) -> Costmap {
        let (mut low, mut high) = (from, from);
        for place in to.iter().filter(|place| place.x.is_finite() && place.y.is_finite()) {
            low = MapPoint::new(low.x.min(place.x), low.y.min(place.y));
            high = MapPoint::new(high.x.max(place.x), high.y.max(place.y));
        }
        let around = AROUND.0 + AROUND.1 * low.distance(high);
        let (low, high) =
            (MapPoint::new(low.x - around, low.y - around), MapPoint::new(high.x + around, high.y + around));
        let cell = FINEST.max((high.x - low.x).max(high.y - low.y) / SIDE);
        let grid = GridGeometry::covering(low, high, cell, SIDE as usize + 1);
        let mut ground = Ground::of(map, &grid);
        for (square, known) in &self.known {
            let Some(cell) = grid.cell_at(middle(*square)) else { continue };
            match (known, &mut ground.barred[cell]) {
                (Known::Hit, barred) if *barred == Barred::No => *barred = Barred::Solid,
                (Known::Free, barred) if *barred == Barred::Solid => *barred = Barred::No,
                _ => {}
            }
        }
        Costmap::over(grid, ground, self.room, WAYS)
    }
}

fn middle((column, row): (i32, i32)) -> MapPoint {
    let at = |n: i32| (f64::from(n) + 0.5) * MEMORY;
    MapPoint::new(at(column), at(row))
}

fn square(at: MapPoint) -> (i32, i32) {
    // Within an agent's own frame places are kilometres from the origin at most.
    ((at.x / MEMORY).floor() as i32, (at.y / MEMORY).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::tests::{empty_map, open_ground, see_wall};
    use openbench_osm::Barrier;

    fn length(way: &[MapPoint]) -> f64 {
        way.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    #[test]
    fn ways_of_a_kilometre_lead_round_what_the_map_has() {
        let mut map = empty_map();
        let wall = [("barrier", "wall")].into_iter().collect();
        let points = [(400.0, -200.0), (400.0, 150.0)].map(|(x, y)| MapPoint::new(x, y)).to_vec();
        map.barriers.push(Barrier { way: 1, points, gates: vec![], tags: wall });
        let overview = Overview::new(&RobotDescription::sentry()).unwrap();
        let (from, to) = (MapPoint::new(0.0, 0.0), MapPoint::new(1000.0, 0.0));
        let way = overview.way(&map, from, to).unwrap();
        let end = MapPoint::new(400.0, 150.0);
        let shortest = from.distance(end) + end.distance(to);
        assert!((shortest..1.02 * shortest).contains(&length(&way)), "{} for {shortest}", length(&way));
        assert_eq!(overview.bar(&map, from, to).map(|found| found.bar), Some(Bar::Barrier));
        assert_eq!(overview.bar(&map, from, MapPoint::new(100.0, 0.0)), None);
    }

    #[test]
    fn what_was_seen_is_remembered_until_it_is_forgotten() {
        let mut near = open_ground();
        see_wall(&mut near, MapPoint::new(2.0, -9.0), MapPoint::new(2.0, 9.0));
        let mut overview = Overview::new(&RobotDescription::sentry()).unwrap();
        let (from, to) = (MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0));
        let straight = length(&overview.way(&empty_map(), from, to).unwrap());
        overview.note(&near);
        let round = length(&overview.way(&empty_map(), from, to).unwrap());
        assert!(straight < 4.1 && round > 15.0, "{straight} {round}");
        assert_eq!(overview.bar(&empty_map(), from, to).map(|found| found.bar), Some(Bar::Seen));
        assert!(overview.forget() && !overview.forget());
        assert!(length(&overview.way(&empty_map(), from, to).unwrap()) < 4.1);
    }
}
