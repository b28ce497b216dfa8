//! What is known about the ground: buildings, walls and water of the map, and what the LiDAR saw.
//!
//! What the LiDAR saw overrules the map: a recessed door lies inside its building's outline, and a map may be wrong.
//! Distances to obstacles are exact (Euclidean distance transform).

use openbench_core::{MapPoint, Pose2, RobotDescription};
use openbench_grid::{GridGeometry, squared_distances};
use openbench_osm::{Barrier, OsmMap};

use crate::obstacles::{Beam, RangeRing};
use crate::shape::{Footprint, Obstacle};

/// Side of a cell, metres, unless the map is so large that cells must be larger.
const CELL: f64 = 0.1;
/// Most cells along one side.
const MAX_SIDE: f64 = 2500.0;
/// Evidence of one hit, and its bounds; one miss counts -1.
const HIT: i8 = 4;
const EVIDENCE: (i8, i8) = (-6, 12);
/// Evidence below which a cell is known to be free.
const FREE: i8 = -3;
/// Scans after which an obstacle that is not seen again is forgotten: a minute.
const MEMORY: u32 = 600;
/// Scans ago that are a moment: two seconds.
const MOMENT: u32 = 20;
/// Room beyond the footprint that a way keeps from obstacles, metres.
const MARGIN: f64 = 0.05;
/// Distance at which obstacles no longer cost anything, metres.
const COMFORT: f64 = 0.9;
/// Cost of a cell right beside an obstacle, in cells.
const DISCOMFORT: f64 = 6.0;

/// Half the width of the gap that a gate leaves in a barrier, metres.
const GATE: f64 = 1.0;

/// A costmap cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CostmapError {
    /// A corner of the area is not a number, or the area has no size.
    #[error("the area from {low} to {high} is no area; give two finite corners, the lower one first")]
    NoArea {
        /// Lower corner.
        low: MapPoint,
        /// Upper corner.
        high: MapPoint,
    },
}

/// Cells with what is known about them.
#[derive(Debug, Clone)]
pub struct Costmap {
    grid: GridGeometry,
    mapped: Vec<bool>,
    evidence: Vec<i8>,
    /// Number of the scan that last hit each cell.
    hit_in: Vec<u32>,
    /// Height above the ground of the highest hit in each cell since it was last free, centimetres.
    top: Vec<u8>,
    /// Number of the scan by which each cell was last known to be free; 0 if never.
    free_in: Vec<u32>,
    /// Number of the scan that last cleared each cell: beams crowd near the sensor, and one scan is one piece of evidence.
    cleared_in: Vec<u32>,
    scans: u32,
    /// Distance to the nearest obstacle in cells, squared; as of the last [`Costmap::inflate`].
    clearance: Vec<f32>,
    /// Distance that the middle of the robot must keep, metres.
    keep: f64,
}

impl Costmap {
    /// The costmap of an area, from the buildings and barriers of `map` in it.
    pub fn new(
        map: &OsmMap,
        low: MapPoint,
        high: MapPoint,
        robot: &RobotDescription,
    ) -> Result<Self, CostmapError> {
        let finite = [low.x, low.y, high.x, high.y].iter().all(|c| c.is_finite() && c.abs() < 1e7);
        if !finite || high.x <= low.x || high.y <= low.y {
            return Err(CostmapError::NoArea { low, high });
        }
        let cell = CELL.max((high.x - low.x).max(high.y - low.y) / MAX_SIDE);
        let grid = GridGeometry::covering(low, high, cell, MAX_SIDE as usize + 1);
        let mut costmap = Self {
            mapped: vec![false; grid.len()],
            evidence: vec![0; grid.len()],
            hit_in: vec![0; grid.len()],
            top: vec![0; grid.len()],
            cleared_in: vec![0; grid.len()],
            free_in: vec![0; grid.len()],
            scans: 0,
            clearance: Vec::new(),
            keep: robot.inscribed_radius() + MARGIN,
            grid,
        };
        costmap.draw_map(map);
        costmap.inflate();
        Ok(costmap)
    }

    /// The cells.
    pub fn grid(&self) -> &GridGeometry {
        &self.grid
    }

    /// The middles of cells that a scan shows something in where the ground was known to be free a moment ago, away from what stands: who or what has come there.
    pub fn newcomers(&self, ring: &RangeRing) -> Vec<MapPoint> {
        let hit = ring.obstacles.iter().filter_map(|(point, _)| self.grid.cell_at(*point));
        let mut cells: Vec<usize> = hit.filter(|&cell| self.is_new(cell)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.into_iter().map(|cell| self.grid.center(cell)).collect()
    }

    /// Whether a cell was free a moment ago and so were or are those around it.
    fn is_new(&self, cell: usize) -> bool {
        let was_free = |cell: usize| self.free_in[cell] > 0 && self.scans - self.free_in[cell] < MOMENT;
        let (x, y) = self.grid.column_row(cell);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let mut around = around.filter_map(|(x, y)| self.grid.cell_in(x, y));
        around.all(|c| was_free(c) || !self.is_obstacle(c)) && was_free(cell)
    }

    /// Takes in what a scan shows. [`Costmap::inflate`] makes it count.
    pub fn observe(&mut self, ring: &RangeRing) {
        self.observe_but(ring, |_| false);
    }

    /// The same without the points of which `moves` says that they do not stay.
    pub fn observe_but(&mut self, ring: &RangeRing, moves: impl Fn(MapPoint) -> bool) {
        self.scans += 1;
        for (degrees, &beam) in ring.beams.iter().enumerate() {
            self.mark_clear(ring, beam, (degrees as f64 + 0.5).to_radians());
        }
        for &(point, height) in &ring.obstacles {
            let Some(cell) = self.grid.cell_at(point).filter(|_| !moves(point)) else { continue };
            let before = if self.evidence[cell] > 0 { self.top[cell] } else { 0 };
            self.top[cell] = before.max((height * 100.0) as u8);
            if self.hit_in[cell] != self.scans {
                self.evidence[cell] = (self.evidence[cell].max(0) + HIT).min(EVIDENCE.1);
                self.hit_in[cell] = self.scans;
            }
        }
    }

    /// Computes the distances to obstacles anew, and forgets obstacles that were not seen for a minute: they may have moved, and the
    /// robot's idea of where it was then has drifted from its idea of now.
    pub fn inflate(&mut self) {
        for cell in 0..self.grid.len() {
            if self.evidence[cell] > 0 && self.scans - self.hit_in[cell] > MEMORY {
                self.evidence[cell] = 0;
            }
        }
        let blocked: Vec<bool> = (0..self.grid.len()).map(|c| self.is_obstacle(c)).collect();
        self.clearance = squared_distances(&blocked, self.grid.width, self.grid.height);
    }

    /// Whether something solid is believed to be in a cell.
    pub fn is_obstacle(&self, cell: usize) -> bool {
        self.evidence[cell] > 0 || (self.mapped[cell] && self.evidence[cell] > FREE)
    }

    /// Distance from a cell to the nearest obstacle, metres, as of the last inflation.
    pub fn clearance(&self, cell: usize) -> f64 {
        f64::from(self.clearance[cell]).sqrt() * self.grid.cell
    }

    /// Distance from `point` to the nearest obstacle, metres; zero outside the map.
    pub fn clearance_at(&self, point: MapPoint) -> f64 {
        self.grid.cell_at(point).map_or(0.0, |c| self.clearance(c))
    }

    /// Cost of driving one cell's side through a cell: 1 far from obstacles, more beside them, `None` where the robot
    /// does not fit.
    pub fn cost(&self, cell: usize) -> Option<f64> {
        let clearance = self.clearance(cell);
        if clearance < self.keep {
            return None;
        }
        let near = ((COMFORT - clearance) / (COMFORT - self.keep)).max(0.0);
        Some(1.0 + DISCOMFORT * near * near)
    }

    /// Distance that the robot's middle keeps from obstacles, metres.
    pub fn keep(&self) -> f64 {
        self.keep
    }

    /// Whether the robot fits along the segment `from`–`to` by the newest evidence; cheap enough for every scan. Lenient by the diagonal
    /// of a cell, since a way is planned between the middles of cells.
    pub fn is_clear(&self, from: MapPoint, to: MapPoint) -> bool {
        let steps = (from.distance(to) / self.grid.cell).ceil().max(1.0) as usize;
        (0..=steps).all(|i| {
            let t = i as f64 / steps as f64;
            let p = MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            self.nearest_obstacle_within(p, self.keep - 0.75 * self.grid.cell).is_none()
        })
    }

    /// Distance from `point` to the nearest obstacle by the newest evidence, if it is within `reach` metres.
    pub fn nearest_obstacle_within(&self, point: MapPoint, reach: f64) -> Option<f64> {
        let low = MapPoint::new(point.x - reach, point.y - reach);
        let high = MapPoint::new(point.x + reach, point.y + reach);
        let (columns, rows) = self.grid.window(low, high)?;
        let cells = (rows.0..=rows.1).flat_map(|r| (columns.0..=columns.1).map(move |c| (c, r)));
        cells
            .filter_map(|(c, r)| self.grid.cell_in(c, r))
            .filter(|&c| self.is_obstacle(c))
            .map(|c| self.grid.center(c).distance(point))
            .filter(|&d| d < reach)
            .reduce(f64::min)
    }

    /// Forgets what is believed to be where the robot stands: it cannot be.
    pub fn clear_below(&mut self, footprint: &Footprint, pose: Pose2) {
        let (placed, reach) = (footprint.at(pose), footprint.circumscribed());
        let low = MapPoint::new(pose.x - reach, pose.y - reach);
        let high = MapPoint::new(pose.x + reach, pose.y + reach);
        let Some((columns, rows)) = self.grid.window(low, high) else { return };
        for row in rows.0..=rows.1 {
            for cell in (columns.0..=columns.1).filter_map(|column| self.grid.cell_in(column, row)) {
                if self.is_obstacle(cell) && placed.holds(self.grid.center(cell)) {
                    self.evidence[cell] = EVIDENCE.0;
                }
            }
        }
    }

    /// What stands within `reach` metres of a point, by the newest evidence: the borders of what is blocked, as walls as thick as a cell, none longer than a metre.
    pub fn obstacles_near(&self, point: MapPoint, reach: f64) -> Vec<Obstacle> {
        let low = MapPoint::new(point.x - reach, point.y - reach);
        let high = MapPoint::new(point.x + reach, point.y + reach);
        let Some((columns, rows)) = self.grid.window(low, high) else { return Vec::new() };
        let width = (columns.1 - columns.0 + 1) as usize;
        let index = |column: i64, row: i64| (row - rows.0) as usize * width + (column - columns.0) as usize;
        let mut border = vec![false; width * (rows.1 - rows.0 + 1) as usize];
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                border[index(column, row)] = self.is_border(column, row);
            }
        }
        let longest = (1.0 / self.grid.cell) as i64;
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

    /// Whether a cell is blocked and one of the four beside it is not.
    fn is_border(&self, column: i64, row: i64) -> bool {
        let blocked = |dx: i64, dy: i64| {
            self.grid.cell_in(column + dx, row + dy).is_some_and(|cell| self.is_obstacle(cell))
        };
        blocked(0, 0) && !(blocked(1, 0) && blocked(-1, 0) && blocked(0, 1) && blocked(0, -1))
    }

    fn wall(&self, from: (i64, i64), to: (i64, i64)) -> Option<Obstacle> {
        let center = |at: (i64, i64)| self.grid.cell_in(at.0, at.1).map(|cell| self.grid.center(cell));
        let ends = [center(from)?, center(to)?];
        let corners = if from == to { &ends[..1] } else { &ends[..] };
        Obstacle::new(corners, self.grid.cell / 2.0, [0.0; 2]).ok()
    }

    fn draw_buildings(&mut self, map: &OsmMap) {
        for building in &map.buildings {
            let ring = &building.polygon.outer;
            let Some(first) = ring.first() else { continue };
            let low = ring.iter().fold(*first, |a, p| MapPoint::new(a.x.min(p.x), a.y.min(p.y)));
            let high = ring.iter().fold(*first, |a, p| MapPoint::new(a.x.max(p.x), a.y.max(p.y)));
            let Some((columns, rows)) = self.grid.window(low, high) else { continue };
            for row in rows.0..=rows.1 {
                for cell in (columns.0..=columns.1).filter_map(|column| self.grid.cell_in(column, row)) {
                    self.mapped[cell] =
                        self.mapped[cell] || building.polygon.contains(self.grid.center(cell));
                }
            }
        }
    }

    fn draw_map(&mut self, map: &OsmMap) {
        let (kerbs, walls): (Vec<_>, Vec<_>) =
            map.barriers.iter().partition(|b| b.tags.is("barrier", "kerb"));
        // First of all, since what opens them would open walls too.
        self.draw_barriers(&kerbs);
        if !kerbs.is_empty() {
            self.open_crossings(map);
        }
        self.draw_buildings(map);
        self.draw_barriers(&walls);
    }

    fn draw_barriers(&mut self, barriers: &[&Barrier]) {
        for barrier in barriers {
            for pair in barrier.points.windows(2) {
                self.draw_line(pair[0], pair[1]);
            }
            for gate in &barrier.gates {
                self.open_gate(*gate);
            }
        }
    }

    /// Where a road or path leads over a kerb it is lowered, whether or not the map says so.
    fn open_crossings(&mut self, map: &OsmMap) {
        for pair in map.roads.iter().flat_map(|road| road.points.windows(2)) {
            let low = MapPoint::new(pair[0].x.min(pair[1].x), pair[0].y.min(pair[1].y));
            let high = MapPoint::new(pair[0].x.max(pair[1].x), pair[0].y.max(pair[1].y));
            if self.grid.window(low, high).is_none() {
                continue;
            }
            let steps = (pair[0].distance(pair[1]) / GATE).ceil().clamp(1.0, 1e5) as usize;
            for i in 0..=steps {
                let t = i as f64 / steps as f64;
                let at = |a: f64, b: f64| a + t * (b - a);
                self.open_gate(MapPoint::new(at(pair[0].x, pair[1].x), at(pair[0].y, pair[1].y)));
            }
        }
    }

    /// Leaves the map's opinion out around a gate: the LiDAR will see whether it is open.
    fn open_gate(&mut self, gate: MapPoint) {
        let low = MapPoint::new(gate.x - GATE, gate.y - GATE);
        let high = MapPoint::new(gate.x + GATE, gate.y + GATE);
        let Some((columns, rows)) = self.grid.window(low, high) else { return };
        for row in rows.0..=rows.1 {
            for cell in (columns.0..=columns.1).filter_map(|column| self.grid.cell_in(column, row)) {
                self.mapped[cell] = false;
            }
        }
    }

    fn draw_line(&mut self, from: MapPoint, to: MapPoint) {
        let steps = (from.distance(to) / self.grid.cell * 2.0).ceil().clamp(1.0, 1e6) as usize;
        for i in 0..=steps {
            let t = i as f64 / steps as f64;
            let p = MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
            if let Some(cell) = self.grid.cell_at(p) {
                self.mapped[cell] = true;
            }
        }
    }

    /// Counts against every obstacle that is high enough for `beam` to have hit it on its way.
    fn mark_clear(&mut self, ring: &RangeRing, beam: Beam, bearing: f64) {
        let (sin, cos) = libm::sincos(bearing);
        // Stop short of what was hit, by a cell's diagonal.
        let steps = ((beam.reach - 1.5 * self.grid.cell) / self.grid.cell).max(0.0) as usize;
        for i in 0..steps {
            let along = i as f64 * self.grid.cell;
            let at = MapPoint::new(ring.center.x + along * cos, ring.center.y + along * sin);
            let Some(cell) = self.grid.cell_at(at).filter(|&c| self.cleared_in[c] != self.scans) else {
                continue;
            };
            let passes_over =
                self.evidence[cell] > 0 && f64::from(self.top[cell]) < 100.0 * ring.height_at(beam, along);
            if !passes_over {
                self.cleared_in[cell] = self.scans;
                self.evidence[cell] = (self.evidence[cell] - 1).max(EVIDENCE.0);
                if self.evidence[cell] <= FREE {
                    self.free_in[cell] = self.scans;
                }
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use openbench_core::{Georeference, LonLat};
    use openbench_osm::OsmData;

    pub(crate) fn empty_map() -> OsmMap {
        OsmMap::new(&OsmData::default(), Georeference::TangentPlane(LonLat::new(8.0, 50.0)))
    }

    pub(crate) fn open_ground() -> Costmap {
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        Costmap::new(&empty_map(), low, high, &RobotDescription::sentry()).unwrap()
    }

    pub(crate) fn see_wall(costmap: &mut Costmap, from: MapPoint, to: MapPoint) {
        let points = (0..=200).map(|i| {
            let t = f64::from(i) / 200.0;
            (MapPoint::new(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)), 0.3)
        });
        costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, points));
        costmap.inflate();
    }

    #[test]
    fn kerbs_are_closed_but_where_a_road_leads_over_them() {
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
        map.roads.push(openbench_osm::Road { way: 2, nodes: vec![1, 2], points, tags: path });
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        let costmap = Costmap::new(&map, low, high, &RobotDescription::sentry()).unwrap();
        let closed = |x: f64| costmap.mapped[costmap.grid.cell_at(MapPoint::new(x, 0.0)).unwrap()];
        assert!(closed(-5.0) && closed(6.0) && !closed(2.0) && !closed(1.3));
    }

    #[test]
    fn what_was_seen_blocks_and_can_be_cleared_again() {
        let mut costmap = open_ground();
        see_wall(&mut costmap, MapPoint::new(2.0, -1.0), MapPoint::new(2.0, 1.0));
        let beside = costmap.grid().cell_at(MapPoint::new(1.9, 0.0)).unwrap();
        assert_eq!(costmap.cost(beside), None);
        assert!(!costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
        // The wall has gone: beams reach the ground behind it.
        let ground = |i: i32| (MapPoint::new(5.0, f64::from(i) / 20.0), 0.0);
        for _ in 0..12 {
            costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, (-60..60).map(ground)));
        }
        assert!(costmap.is_clear(MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)));
    }

    #[test]
    fn a_low_obstacle_stays_though_beams_pass_over_it() {
        let mut costmap = open_ground();
        // A kerb of 12 cm, seen from afar; then the robot stands before it, and its lowest beam reaches the ground behind.
        let kerb = (0..=40).map(|i| (MapPoint::new(2.0, f64::from(i) * 0.05 - 1.0), 0.12));
        costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, kerb));
        let behind = |i: i32| (MapPoint::new(3.7, f64::from(i) / 30.0), 0.0);
        for _ in 0..30 {
            costmap.observe(&RangeRing::new(MapPoint::new(1.4, 0.0), 0.25, (-60..60).map(behind)));
        }
        assert!(!costmap.is_clear(MapPoint::new(1.4, 0.0), MapPoint::new(3.0, 0.0)));
    }

    #[test]
    fn absurd_areas_are_refused() {
        let robot = RobotDescription::sentry();
        for (low, high) in [((0.0, 0.0), (0.0, 5.0)), ((f64::NAN, 0.0), (1.0, 1.0)), ((5.0, 0.0), (0.0, 5.0))]
        {
            let corner = |c: (f64, f64)| MapPoint::new(c.0, c.1);
            assert!(Costmap::new(&empty_map(), corner(low), corner(high), &robot).is_err());
        }
    }

    #[test]
    fn clearance_is_euclidean() {
        let mut costmap = open_ground();
        see_wall(&mut costmap, MapPoint::new(3.05, 0.05), MapPoint::new(3.05, 0.05));
        let clearance = costmap.clearance_at(MapPoint::new(0.05, 4.05));
        assert!((clearance - 5.0).abs() < 1e-6, "{clearance}");
    }
}
