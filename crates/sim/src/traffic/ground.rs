//! Where people fit, how far it is to where they do not, and what is carriageway: a coarse grid
//! that is made once.

use openbench_core::MapPoint;
use openbench_geometry::grid::{GridGeometry, in_sight, squared_distances};
use openbench_geometry::{Bounds, Segment, segments};
use openbench_osm::OsmMap;

use super::road_tags::carriageway;

/// Side of a cell, metres.
const CELL_M: f64 = 0.25;
/// Traffic moves within this distance of the robot's start along each axis, metres. It bounds
/// memory to some 30 MB.
const REACH_M: f64 = 300.0;
/// Ground beyond the outermost building or road, metres.
const MARGIN_M: f64 = 10.0;

/// The ground in cells.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    grid: GridGeometry,
    /// Metres to the nearest place where no person fits; 0 there.
    clearance: Vec<f32>,
    road: Vec<bool>,
}

/// The room around a point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clearance {
    /// Metres to the nearest place where no person fits.
    pub distance: f64,
    /// Gradient of that distance in `map`: it leads away from obstacles, with a length of at most
    /// about 1.
    pub gradient: [f64; 2],
}

impl Ground {
    /// The ground of a map. `free` tells whether a person fits at a point.
    pub fn new(map: &OsmMap, free: impl Fn(MapPoint) -> bool, start: MapPoint) -> Self {
        let grid = covering(map, start);
        let blocked: Vec<bool> = (0..grid.len())
            .map(|cell| !free(grid.center(cell)))
            .collect();
        let squares = squared_distances(&blocked, grid.width, grid.height);
        // To the edge of the blocked cell, which is half a cell nearer than its middle.
        let metres = |square: f32| ((square.sqrt() - 0.5) * grid.cell as f32).max(0.0);
        let clearance = squares.into_iter().map(metres).collect();
        let mut ground = Self {
            road: vec![false; grid.len()],
            grid,
            clearance,
        };
        for road in &map.roads {
            let Some(way) = carriageway(&road.tags) else {
                continue;
            };
            for segment in segments(&road.points) {
                ground.pave(segment, way.half_width);
            }
        }
        ground
    }

    /// The room around `point`, interpolated between cells; none outside the grid.
    pub fn clearance(&self, point: MapPoint) -> Clearance {
        // In cells from the middle of the first cell: clearances hold in the middles.
        let x = (point.x - self.grid.origin.x) / self.grid.cell - 0.5;
        let y = (point.y - self.grid.origin.y) / self.grid.cell - 0.5;
        let (width, height) = (self.grid.width as f64, self.grid.height as f64);
        let inside = x >= 0.0 && y >= 0.0 && x < width - 1.0 && y < height - 1.0;
        if !inside {
            return Clearance::default();
        }
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f64, y - row as f64);
        let at = |dx: usize, dy: usize| {
            f64::from(self.clearance[(row + dy) * self.grid.width + column + dx])
        };
        // Bilinear interpolation, and its derivatives along both axes.
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        let (low, high) = (a + (b - a) * u, c + (d - c) * u);
        let slope = [(b - a) * (1.0 - v) + (d - c) * v, high - low];
        Clearance {
            distance: low + (high - low) * v,
            gradient: slope.map(|s| s / self.grid.cell),
        }
    }

    /// Whether a person fits at `point`.
    pub fn fits(&self, point: MapPoint) -> bool {
        self.grid
            .cell_at(point)
            .is_some_and(|cell| self.clearance[cell] > 0.0)
    }

    /// Whether `point` is on a carriageway.
    pub fn is_road(&self, point: MapPoint) -> bool {
        self.grid.cell_at(point).is_some_and(|cell| self.road[cell])
    }

    /// Whether one can walk straight from `a` to `b`.
    pub fn sees(&self, a: MapPoint, b: MapPoint) -> bool {
        match (self.grid.cell_at(a), self.grid.cell_at(b)) {
            (Some(a), Some(b)) => in_sight(&self.grid, |cell| self.clearance[cell] > 0.0, a, b),
            _ => false,
        }
    }

    /// Marks the cells within `half` metres of a segment as carriageway.
    fn pave(&mut self, segment: Segment, half: f64) {
        let ends = Bounds::of_point(segment.start).union(Bounds::of_point(segment.end));
        let Bounds { low, high } = ends.grown(half);
        let Some((columns, rows)) = self.grid.window(low, high) else {
            return;
        };
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                let Some(cell) = self.grid.cell_in(column, row) else {
                    continue;
                };
                let away = segment.distance_to_point(self.grid.center(cell));
                self.road[cell] = self.road[cell] || away <= half;
            }
        }
    }
}

/// A grid over a map's buildings and roads, as far as traffic moves.
fn covering(map: &OsmMap, start: MapPoint) -> GridGeometry {
    let buildings = map.buildings.iter().flat_map(|b| &b.polygon.outer);
    let points = buildings.chain(map.roads.iter().flat_map(|r| &r.points));
    let around_start = Bounds::of_point(start);
    let mapped = points
        .map(|p| Bounds::of_point(*p))
        .fold(around_start, Bounds::union)
        .grown(MARGIN_M);
    // A map may be large, or hold a node far away; traffic far from the robot is not needed.
    let Bounds { low, high } = mapped.intersection(around_start.grown(REACH_M));
    GridGeometry::covering(low, high, CELL_M, (2.0 * REACH_M / CELL_M) as usize)
}
