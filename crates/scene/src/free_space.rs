//! Where a footprint fits, and how far it is from one place to another.
//!
//! The solid triangles between ankle and roof of the robot are drawn into a grid of 0.1 m; a cell is free when a disc
//! about the footprint fits there, by the exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012).
//! Shortest ways are any-angle (Theta*, Nash et al. 2007, then pulled taut): a grid's octile ways are up to 8 % too
//! long. One ground level a world; ramps are not regarded.

use openbench_core::MapPoint;
use openbench_grid::{Frontier, GridGeometry, in_sight, squared_distances};

use crate::raycast::RayCaster;
use crate::scene::Door;

/// Side of a grid cell, metres, unless the world is so large that cells must be larger.
const CELL: f64 = 0.1;
/// Solid surfaces between these heights above the ground stop a robot, metres.
const BODY: (f64, f64) = (0.06, 0.36);
/// Free ground beyond the outermost thing that stops a robot that is still looked at, metres; where all ends, the ground ends too.
const MARGIN: f64 = 3.0;
/// Ground around the start and all doors that is looked at, metres: what lies further off, such as a stray box, lengthens no way.
const SURROUNDINGS: f64 = 100.0;
/// Largest number of cells on one side of the grid.
const MAX_CELLS: usize = 8_000;
/// How far a plate is pushed out in search of its approach point, metres.
const MAX_APPROACH: f64 = 6.0;

/// Where a footprint fits and can get to from the start.
#[derive(Debug, Clone)]
pub struct FreeSpace {
    grid: GridGeometry,
    /// Free and connected to the start.
    reachable: Vec<bool>,
    ground: f64,
}

impl FreeSpace {
    /// The free space of a scene for a disc of `radius` metres, as far as it hangs together with `start`. The ground's
    /// height is what lies under `start`.
    pub fn new(caster: &RayCaster, start: MapPoint, radius: f64) -> Self {
        let ground = ground_height(caster, start);
        let solid = &caster.scene().solid;
        let slices = solid.triangles.iter().filter_map(|t| {
            let corners = t.map(|i| solid.positions[i as usize].map(f64::from));
            slice(corners, ground + BODY.0, ground + BODY.1)
        });
        let polygons: Vec<Vec<MapPoint>> = slices.collect();
        let doors: Vec<MapPoint> = caster.scene().doors.iter().map(Door::point).collect();
        let everything = solid
            .positions
            .iter()
            .map(|p| MapPoint::new(f64::from(p[0]), f64::from(p[1])));
        let world = match caster.scene().extent {
            Some(corners) => bounds(start, corners.into_iter()),
            None => bounds(start, everything),
        };
        let grid = covering(&polygons, world, start, &doors);
        let mut blocked = vec![false; grid.len()];
        for polygon in &polygons {
            draw(&grid, polygon, &mut blocked);
        }
        let clearance = squared_distances(&blocked, grid.width, grid.height);
        let limit = (radius / grid.cell) * (radius / grid.cell);
        let free: Vec<bool> = clearance.iter().map(|&d| f64::from(d) > limit).collect();
        Self {
            reachable: flood(&grid, &free, start),
            grid,
            ground,
        }
    }

    /// Height of the ground under the start, metres.
    pub fn ground(&self) -> f64 {
        self.ground
    }

    /// Whether the footprint fits at `point` and gets there from the start.
    pub fn is_reachable(&self, point: MapPoint) -> bool {
        self.grid.cell_at(point).is_some_and(|c| self.reachable[c])
    }

    /// The reachable place nearest to `point` within `limit` metres.
    pub fn nearest_reachable(&self, point: MapPoint, limit: f64) -> Option<MapPoint> {
        if self.is_reachable(point) {
            return Some(point);
        }
        let steps = (limit / CELL) as i64;
        let offsets = (-steps..=steps).flat_map(|dy| (-steps..=steps).map(move |dx| (dx, dy)));
        let places = offsets
            .map(|(dx, dy)| MapPoint::new(point.x + dx as f64 * CELL, point.y + dy as f64 * CELL));
        places
            .filter(|p| point.distance(*p) <= limit && self.is_reachable(*p))
            .min_by(|a, b| point.distance(*a).total_cmp(&point.distance(*b)))
    }

    /// Where one stands at a door: its plate pushed out along its normal until the footprint is free and reachable.
    pub fn approach_point(&self, door: &Door) -> Option<MapPoint> {
        let steps = (MAX_APPROACH / (CELL / 2.0)) as usize;
        (0..=steps)
            .map(|i| door.point().offset(door.facing, i as f64 * CELL / 2.0))
            .find(|p| self.is_reachable(*p))
    }

    /// Length of the shortest way of the footprint, metres; `None` if there is none.
    pub fn distance(&self, from: MapPoint, to: MapPoint) -> Option<f64> {
        let path = self.path(from, to)?;
        Some(path.windows(2).map(|w| w[0].distance(w[1])).sum())
    }

    /// The shortest way of the footprint, both ends included; `None` if there is none.
    pub fn path(&self, from: MapPoint, to: MapPoint) -> Option<Vec<MapPoint>> {
        let start = self.grid.cell_at(from).filter(|c| self.reachable[*c])?;
        let goal = self.grid.cell_at(to).filter(|c| self.reachable[*c])?;
        let cells = self.theta_star(start, goal)?;
        let mut points: Vec<MapPoint> = self
            .pull_taut(cells)
            .iter()
            .map(|c| self.grid.center(*c))
            .collect();
        let last = points.len() - 1;
        if last == 0 {
            return Some(vec![from, to]);
        }
        (points[0], points[last]) = (from, to);
        Some(points)
    }

    fn theta_star(&self, start: usize, goal: usize) -> Option<Vec<usize>> {
        let mut search = Search::new(self.reachable.len());
        search.open(start, start, 0.0, self.grid.cells_apart(start, goal));
        while let Some((_, cell)) = search.queue.pop() {
            if cell == goal {
                return Some(search.trace(start, goal));
            }
            if std::mem::replace(&mut search.closed[cell], true) {
                continue;
            }
            self.expand(cell, goal, &mut search);
        }
        None
    }

    fn expand(&self, cell: usize, goal: usize, search: &mut Search) {
        let parent = search.parent[cell] as usize;
        let (x, y) = self.grid.column_row(cell);
        for (dx, dy) in [
            (-1, -1),
            (0, -1),
            (1, -1),
            (-1, 0),
            (1, 0),
            (-1, 1),
            (0, 1),
            (1, 1),
        ] {
            let Some(next) = self.grid.cell_in(x + dx, y + dy) else {
                continue;
            };
            if !self.reachable[next] || search.closed[next] {
                continue;
            }
            // No way through `cell` is shorter than the straight line from its parent; most sights need not be looked along.
            if search.cost[parent] + self.grid.cells_apart(parent, next) >= search.cost[next] {
                continue;
            }
            let from = if self.in_sight(parent, next) {
                parent
            } else if self.in_sight(cell, next) {
                cell
            } else {
                continue;
            };
            let cost = search.cost[from] + self.grid.cells_apart(from, next);
            if cost < search.cost[next] {
                search.open(next, from, cost, cost + self.grid.cells_apart(next, goal));
            }
        }
    }

    /// Leaves out every corner that a straight line spares, until none is left to spare.
    fn pull_taut(&self, mut cells: Vec<usize>) -> Vec<usize> {
        loop {
            let before = cells.len();
            let mut i = 1;
            while i + 1 < cells.len() {
                if self.in_sight(cells[i - 1], cells[i + 1]) {
                    cells.remove(i);
                } else {
                    i += 1;
                }
            }
            if cells.len() == before {
                return cells;
            }
        }
    }

    fn in_sight(&self, a: usize, b: usize) -> bool {
        in_sight(&self.grid, |c| self.reachable[c], a, b)
    }
}

struct Search {
    cost: Vec<f64>,
    parent: Vec<u32>,
    closed: Vec<bool>,
    queue: Frontier,
}

impl Search {
    fn new(cells: usize) -> Self {
        Self {
            cost: vec![f64::INFINITY; cells],
            parent: vec![0; cells],
            closed: vec![false; cells],
            queue: Frontier::default(),
        }
    }

    fn open(&mut self, cell: usize, parent: usize, cost: f64, estimate: f64) {
        self.cost[cell] = cost;
        self.parent[cell] = parent as u32;
        self.queue.push(estimate, cell);
    }

    fn trace(&self, start: usize, goal: usize) -> Vec<usize> {
        let mut cells = vec![goal];
        let mut at = goal;
        while at != start {
            at = self.parent[at] as usize;
            cells.push(at);
        }
        cells.reverse();
        cells
    }
}

/// Height of the highest solid surface at most 2 m above the world's origin level under `at`; 0 if there is none.
pub fn ground_height(caster: &RayCaster, at: MapPoint) -> f64 {
    let origin = [at.x as f32, at.y as f32, 2.0];
    caster
        .solid()
        .cast(origin, [0.0, 0.0, -1.0], 1000.0)
        .map_or(0.0, |hit| 2.0 - f64::from(hit.distance))
}

/// A grid over the solid surfaces that are not too far from the start and every door, no larger than the `world`.
fn covering(
    polygons: &[Vec<MapPoint>],
    world: (MapPoint, MapPoint),
    start: MapPoint,
    doors: &[MapPoint],
) -> GridGeometry {
    let solid = bounds(start, polygons.iter().flatten().copied());
    let served = bounds(start, doors.iter().copied());
    let low = MapPoint::new(
        (solid.0.x - MARGIN)
            .max(served.0.x - SURROUNDINGS)
            .max(world.0.x),
        (solid.0.y - MARGIN)
            .max(served.0.y - SURROUNDINGS)
            .max(world.0.y),
    );
    let high = MapPoint::new(
        (solid.1.x + MARGIN)
            .min(served.1.x + SURROUNDINGS)
            .min(world.1.x),
        (solid.1.y + MARGIN)
            .min(served.1.y + SURROUNDINGS)
            .min(world.1.y),
    );
    let cell = CELL.max((high.x - low.x).max(high.y - low.y) / (MAX_CELLS - 1) as f64);
    GridGeometry::covering(low, high, cell, MAX_CELLS)
}

/// Lower and upper corner of what holds `start` and all `points`.
fn bounds(start: MapPoint, points: impl Iterator<Item = MapPoint>) -> (MapPoint, MapPoint) {
    points.fold((start, start), |(low, high), p| {
        (
            MapPoint::new(low.x.min(p.x), low.y.min(p.y)),
            MapPoint::new(high.x.max(p.x), high.y.max(p.y)),
        )
    })
}

/// Marks every cell that the convex `polygon` comes near to; a degenerate one is a line.
fn draw(grid: &GridGeometry, polygon: &[MapPoint], blocked: &mut [bool]) {
    let Some(first) = polygon.first() else { return };
    let low = polygon
        .iter()
        .fold(*first, |a, p| MapPoint::new(a.x.min(p.x), a.y.min(p.y)));
    let high = polygon
        .iter()
        .fold(*first, |a, p| MapPoint::new(a.x.max(p.x), a.y.max(p.y)));
    let Some((columns, rows)) = grid.window(low, high) else {
        return;
    };
    for row in rows.0..=rows.1 {
        for cell in (columns.0..=columns.1).filter_map(|column| grid.cell_in(column, row)) {
            blocked[cell] = blocked[cell] || touches(polygon, grid.center(cell), 0.71 * grid.cell);
        }
    }
}

/// Marks what hangs together with the start, or with the free cell nearest to it.
fn flood(grid: &GridGeometry, free: &[bool], start: MapPoint) -> Vec<bool> {
    let mut reached = vec![false; free.len()];
    let away = |c: usize| grid.center(c).distance(start);
    // Of a town's 60 million cells the nearest is looked for only if the start itself is not free.
    let here = grid.cell_at(start).filter(|&c| free[c]);
    let nearest = || {
        (0..free.len())
            .filter(|&c| free[c])
            .min_by(|&a, &b| away(a).total_cmp(&away(b)))
    };
    let mut stack: Vec<usize> = here.or_else(nearest).into_iter().collect();
    while let Some(cell) = stack.pop() {
        if std::mem::replace(&mut reached[cell], true) {
            continue;
        }
        let (x, y) = grid.column_row(cell);
        let beside =
            [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| grid.cell_in(x + dx, y + dy));
        stack.extend(
            beside
                .into_iter()
                .flatten()
                .filter(|&n| free[n] && !reached[n]),
        );
    }
    reached
}

/// The part of a triangle between two heights, seen from above.
fn slice(corners: [[f64; 3]; 3], low: f64, high: f64) -> Option<Vec<MapPoint>> {
    let above = clip(&corners, |p| p[2] - low);
    let within = clip(&above, |p| high - p[2]);
    (!within.is_empty()).then(|| within.iter().map(|p| MapPoint::new(p[0], p[1])).collect())
}

/// The part of a convex polygon where `side` is not negative (Sutherland and Hodgman 1974).
fn clip(polygon: &[[f64; 3]], side: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (sa, sb) = (side(a), side(b));
        if sa >= 0.0 {
            kept.push(*a);
        }
        if (sa < 0.0) != (sb < 0.0) {
            let t = sa / (sa - sb);
            kept.push([0, 1, 2].map(|i| a[i] + t * (b[i] - a[i])));
        }
    }
    kept
}

/// Whether `p` lies in the convex polygon (either sense) or within half a cell's diagonal of its edges.
fn touches(polygon: &[MapPoint], p: MapPoint, reach: f64) -> bool {
    let edges = || (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
    if edges().any(|(a, b)| segment_distance(p, a, b) <= reach) {
        return true;
    }
    let turn = |(a, b): (MapPoint, MapPoint)| (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    edges().map(turn).all(|t| t > 0.0) || edges().map(turn).all(|t| t < 0.0)
}

fn segment_distance(p: MapPoint, a: MapPoint, b: MapPoint) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length = dx * dx + dy * dy;
    let t = if length > 0.0 {
        (((p.x - a.x) * dx + (p.y - a.y) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(MapPoint::new(a.x + t * dx, a.y + t * dy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use nalgebra::{Point3, Vector3};
    use openbench_core::Address;

    use crate::material::{Material, SemanticClass};
    use crate::scene::{Layer, SceneBuilder};

    /// Ground of 40 m x 40 m with a wall along y = 0 from x = -5 to x = 5.
    fn walled() -> FreeSpace {
        let mut builder = SceneBuilder::new();
        let grey = builder.material(Material::plain(SemanticClass::Ground, [0.5; 3]));
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-20.0, -20.0, 0.1),
            (x * 40.0, y * 40.0),
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-5.0, 0.0, 0.1),
            (x * 10.0, z * 2.0),
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-20.0, -20.0, 0.1),
            (x * 40.0, z),
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-20.0, 20.0, 0.1),
            (x * 40.0, z),
            [1.0; 2],
        );
        FreeSpace::new(
            &RayCaster::new(Arc::new(builder.build())),
            MapPoint::new(0.0, -5.0),
            0.2,
        )
    }

    #[test]
    fn open_ground_is_as_far_as_the_crow_flies_at_any_angle() {
        let space = walled();
        assert!((space.ground() - 0.1).abs() < 1e-6);
        for to in [
            MapPoint::new(7.3, -9.0),
            MapPoint::new(-3.0, -17.0),
            MapPoint::new(11.0, -4.0),
        ] {
            let from = MapPoint::new(0.0, -5.0);
            let error = space.distance(from, to).unwrap() / from.distance(to);
            assert!((1.0..1.003).contains(&error), "{error}");
        }
    }

    #[test]
    fn a_wall_is_walked_round_tightly() {
        let space = walled();
        let (from, to) = (MapPoint::new(0.0, -3.0), MapPoint::new(0.0, 3.0));
        // Past the wall's end at (5, 0) with 0.2 m to spare: within a cell or two of the taut string.
        let shortest = 2.0 * (5.0_f64 * 5.0 + 3.0 * 3.0).sqrt();
        let found = space.distance(from, to).unwrap();
        assert!(
            (shortest..shortest + 0.6).contains(&found),
            "{found} against {shortest}"
        );
    }

    #[test]
    fn a_wall_blocks_as_far_as_the_footprint_reaches() {
        let space = walled();
        assert!(!space.is_reachable(MapPoint::new(0.0, 0.15)));
        assert!(space.is_reachable(MapPoint::new(0.0, 0.4)));
        assert_eq!(
            space.distance(MapPoint::new(0.0, -3.0), MapPoint::new(0.0, 0.0)),
            None
        );
    }

    #[test]
    fn who_starts_in_a_wall_starts_beside_it() {
        let grid =
            GridGeometry::covering(MapPoint::default(), MapPoint::new(10.0, 1.0), 0.1, 1_000);
        let free: Vec<bool> = (0..grid.len())
            .map(|c| !(3.0..5.0).contains(&grid.center(c).x))
            .collect();
        let reached = |x: f64, at: f64| {
            let cell = grid.cell_at(MapPoint::new(at, 0.55)).unwrap();
            flood(&grid, &free, MapPoint::new(x, 0.55))[cell]
        };
        assert!(reached(1.0, 2.0) && !reached(1.0, 7.0));
        assert!(
            reached(3.4, 2.0) && !reached(3.4, 7.0),
            "nearer to the left"
        );
        assert!(
            !reached(4.8, 2.0) && reached(4.8, 7.0),
            "nearer to the right"
        );
    }

    #[test]
    fn an_approach_point_lies_in_front_of_the_plate() {
        let space = walled();
        let door = Door {
            address: Address::new("building1", "unit1"),
            text: "UNIT 1".into(),
            plate: [1.0, 0.0, 1.5],
            facing: -std::f64::consts::FRAC_PI_2,
        };
        let point = space.approach_point(&door).unwrap();
        assert!(
            (point.x - 1.0).abs() < 1e-9 && (-0.45..-0.2).contains(&point.y),
            "{point}"
        );
    }
}
