//! Where a footprint fits, and how far it is from one place to another.
//!
//! The solid triangles between ankle and roof of the robot are drawn into a grid of 0.1 m. A cell
//! is free when a disc about the footprint fits there, by the exact Euclidean distance transform
//! (Felzenszwalb and Huttenlocher, *Distance Transforms of Sampled Functions*, 2012). Shortest
//! paths are any-angle: the octile paths of a grid are up to 8 % too long. A world has one ground
//! level; ramps are ignored. Places without ground are blocked.

mod any_angle;
mod slices;

use openbench_core::MapPoint;
use openbench_geometry::Bounds;
use openbench_geometry::grid::{GridGeometry, squared_distances};
use openbench_geometry::line::length;

use crate::raycast::RayCaster;
use crate::scene::Door;
use any_angle::Terrain;
use slices::{draw, slice};

/// Side of a grid cell, metres, unless the world is so large that cells must be larger.
const CELL_M: f64 = 0.1;
/// Solid surfaces below this height above the ground do not stop a robot, metres: the radius of its
/// wheels.
const BODY_LOW_M: f64 = 0.06;
/// Solid surfaces above this height do not stop it either, metres: 6 cm above its roof.
const BODY_HIGH_M: f64 = 0.36;
/// Free ground beyond the outermost solid surface that belongs to the grid, metres. The ground ends
/// where the world does.
const MARGIN_M: f64 = 3.0;
/// Ground around the start and all doors that belongs to the grid, metres: farther things, such as
/// a stray box, lengthen no path.
const SURROUNDINGS_M: f64 = 100.0;
/// Largest number of cells on one side of the grid.
const MAX_CELLS: usize = 8_000;
/// Farthest approach point from its plate, metres.
const MAX_APPROACH_M: f64 = 6.0;
/// Height from which the ground is searched downwards, metres.
const ABOVE_GROUND_M: f64 = 2.0;

/// Where a footprint fits and can get to from the start.
///
/// # Example
///
/// Distances in the built-in world `small` for a disc of 0.25 m:
///
/// ```
/// use std::sync::Arc;
///
/// use openbench_scene::generate::builtin;
/// use openbench_scene::{FreeSpace, RayCaster};
///
/// let world = builtin("small", 1).ok_or("there is a world `small`")??;
/// let caster = RayCaster::new(Arc::new(world.scene));
/// let start = world.start.point();
/// let space = FreeSpace::new(&caster, start, 0.25);
/// for door in &caster.scene().doors {
///     let approach = space.approach_point(door).ok_or("every door can be reached")?;
///     let path = space.path(start, approach).ok_or("there is a path")?;
///     assert_eq!((path[0], path[path.len() - 1]), (start, approach));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FreeSpace {
    grid: GridGeometry,
    /// Free and connected to the start.
    reachable: Vec<bool>,
    ground: f64,
}

impl FreeSpace {
    /// The free space of a scene for a disc of `radius` metres, as far as it is connected to
    /// `start`. The height of the ground is that under `start`.
    pub fn new(caster: &RayCaster, start: MapPoint, radius: f64) -> Self {
        let ground = ground_height(caster, start);
        let scene = caster.scene();
        let solid = &scene.solid;
        let slices = solid.triangles.iter().filter_map(|t| {
            let corners = t.map(|i| solid.positions[i as usize].map(f64::from));
            slice(corners, ground + BODY_LOW_M, ground + BODY_HIGH_M)
        });
        let polygons: Vec<Vec<MapPoint>> = slices.chain(scene.pits.iter().cloned()).collect();
        let doors: Vec<MapPoint> = scene.doors.iter().map(Door::point).collect();
        let point = |p: &[f32; 3]| MapPoint::new(f64::from(p[0]), f64::from(p[1]));
        // A generated scene has solid ground far beyond what is drawn; its extent leaves that out.
        let world = match scene.extent {
            Some(extent) => Bounds::of_point(start).union(extent),
            None => around(start, solid.positions.iter().map(point)),
        };
        let grid = covering(&polygons, world, start, &doors);
        let mut blocked = vec![false; grid.len()];
        for polygon in &polygons {
            draw(&grid, polygon, &mut blocked);
        }
        // Distances are between the middles of cells. `draw` marks every cell that a surface comes
        // near to, so the footprint keeps at least its radius from all of them.
        let clearance = squared_distances(&blocked, grid.width, grid.height);
        // Squares are compared, so no cell needs a root.
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

    /// The grid in which places are distinguished.
    pub fn grid(&self) -> &GridGeometry {
        &self.grid
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
        let steps = (limit / CELL_M) as i64;
        let moved = |v: f64, step: i64| v + step as f64 * CELL_M;
        (-steps..=steps)
            .flat_map(|dy| (-steps..=steps).map(move |dx| [dx, dy]))
            .map(|[dx, dy]| MapPoint::new(moved(point.x, dx), moved(point.y, dy)))
            .filter(|p| point.distance(*p) <= limit && self.is_reachable(*p))
            .min_by(|a, b| point.distance(*a).total_cmp(&point.distance(*b)))
    }

    /// The place of a robot at a door: its entrance moved straight out until the footprint is free
    /// and reachable; `None` if there is no such place within 6 m. In imported worlds, where doors
    /// are plates, it is the place in front of the plate.
    pub fn approach_point(&self, door: &Door) -> Option<MapPoint> {
        // Half a cell at a time, so that no free cell on the way out is skipped.
        let steps = (MAX_APPROACH_M / (CELL_M / 2.0)) as usize;
        let entrance = door.entrance();
        (0..=steps)
            .map(|i| {
                entrance
                    .point()
                    .offset(entrance.yaw, i as f64 * CELL_M / 2.0)
            })
            .find(|p| self.is_reachable(*p))
    }

    /// Length of the shortest path of the footprint, metres; `None` if there is none.
    pub fn distance(&self, from: MapPoint, to: MapPoint) -> Option<f64> {
        let path = self.path(from, to)?;
        Some(length(&path))
    }

    /// The shortest path of the footprint, both ends included; `None` if there is none.
    pub fn path(&self, from: MapPoint, to: MapPoint) -> Option<Vec<MapPoint>> {
        let start = self.grid.cell_at(from).filter(|c| self.reachable[*c])?;
        let goal = self.grid.cell_at(to).filter(|c| self.reachable[*c])?;
        let terrain = Terrain {
            grid: &self.grid,
            free: &self.reachable,
        };
        let cells = terrain.shortest_path(start, goal)?;
        let mut points: Vec<MapPoint> = cells.iter().map(|c| self.grid.center(*c)).collect();
        let last = points.len() - 1;
        // Both in one cell: the path has two ends all the same.
        if last == 0 {
            return Some(vec![from, to]);
        }
        // The ends are exact, not the middles of their cells.
        (points[0], points[last]) = (from, to);
        Some(points)
    }
}

/// Height in metres of the highest solid surface under `at` that is at most 2 m above the origin; 0
/// if there is none.
pub fn ground_height(caster: &RayCaster, at: MapPoint) -> f64 {
    let origin = [at.x as f32, at.y as f32, ABOVE_GROUND_M as f32];
    let hit = caster.solid().cast(origin, [0.0, 0.0, -1.0], 1000.0);
    hit.map_or(0.0, |hit| ABOVE_GROUND_M - f64::from(hit.distance))
}

/// The bounds of `start` and all `points`.
fn around(start: MapPoint, points: impl Iterator<Item = MapPoint>) -> Bounds {
    points
        .map(Bounds::of_point)
        .fold(Bounds::of_point(start), Bounds::union)
}

/// A grid over the solid surfaces that are not too far from the start and every door, no larger
/// than the `world`.
fn covering(
    polygons: &[Vec<MapPoint>],
    world: Bounds,
    start: MapPoint,
    doors: &[MapPoint],
) -> GridGeometry {
    let solid = around(start, polygons.iter().flatten().copied()).grown(MARGIN_M);
    let served = around(start, doors.iter().copied()).grown(SURROUNDINGS_M);
    let Bounds { low, high } = solid.intersection(served).intersection(world);
    let longer_side = (high.x - low.x).max(high.y - low.y);
    // Larger cells rather than more of them: a world of some kilometres must fit into memory.
    let cell = CELL_M.max(longer_side / (MAX_CELLS - 1) as f64);
    GridGeometry::covering(low, high, cell, MAX_CELLS)
}

/// Marks what is connected to the start, or to the free cell nearest to it.
fn flood(grid: &GridGeometry, free: &[bool], start: MapPoint) -> Vec<bool> {
    let mut reached = vec![false; free.len()];
    // Of a town's 60 million cells the nearest is searched for only if the start itself is not
    // free.
    let here = grid.cell_at(start).filter(|&c| free[c]);
    let first = here.or_else(|| nearest_free(grid, free, start));
    let mut stack: Vec<usize> = first.into_iter().collect();
    while let Some(cell) = stack.pop() {
        if std::mem::replace(&mut reached[cell], true) {
            continue;
        }
        let (x, y) = grid.column_row(cell);
        // Across sides only: through a corner between two blocked cells no footprint fits.
        for [dx, dy] in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
            let next = grid.cell_in(x + dx, y + dy);
            stack.extend(next.filter(|&n| free[n] && !reached[n]));
        }
    }
    reached
}

fn nearest_free(grid: &GridGeometry, free: &[bool], point: MapPoint) -> Option<usize> {
    let away = |c: usize| grid.center(c).distance(point);
    let cells = (0..free.len()).filter(|&c| free[c]);
    cells.min_by(|&a, &b| away(a).total_cmp(&away(b)))
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
            x * 40.0,
            y * 40.0,
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-5.0, 0.0, 0.1),
            x * 10.0,
            z * 2.0,
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-20.0, -20.0, 0.1),
            x * 40.0,
            z,
            [1.0; 2],
        );
        builder.rectangle(
            Layer::Both,
            grey,
            Point3::new(-20.0, 20.0, 0.1),
            x * 40.0,
            z,
            [1.0; 2],
        );
        FreeSpace::new(
            &RayCaster::new(Arc::new(builder.build())),
            MapPoint::new(0.0, -5.0),
            0.2,
        )
    }

    #[test]
    fn distances_on_open_ground_are_straight_lines_at_any_angle() {
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
    fn a_path_around_a_wall_is_tight() {
        let space = walled();
        let (from, to) = (MapPoint::new(0.0, -3.0), MapPoint::new(0.0, 3.0));
        // Past the wall's end at (5, 0) with 0.2 m to spare: within a cell or two of the taut
        // string.
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
    fn a_start_in_a_wall_is_moved_beside_it() {
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
            lettering: crate::plate::USUAL_LETTERING,
            doorway: None,
        };
        let point = space.approach_point(&door).unwrap();
        assert!(
            (point.x - 1.0).abs() < 1e-9 && (-0.45..-0.2).contains(&point.y),
            "{point}"
        );
    }
}
