//! Facades on walls of the map, beside them, and far from all.
//!
//! Where the pose is right, nearly all facades beside a wall are on it. Facades far from all walls
//! say little: a map lacks sheds and garden walls wherever the robot is.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2};
use openbench_geometry::grid::GridGeometry;
use openbench_geometry::{Bounds, Polygon, Segment};

use super::chart::{Chart, Wall};
use super::matching::FACING_RAD;
use super::refine::Refined;
use super::submap::{REACH_M, Submap};

/// A facade this far from a wall is on it, metres, if it faces the same way.
const ON_WALL_M: f64 = 1.0;
/// A facade on no wall is near one at this distance, metres,
const NEAR_M: f64 = 3.0;
/// and around it at this one.
const AROUND_M: f64 = 6.0;
/// Walls are looked up in cells of this side, metres,
const CELL_M: f64 = 8.0;
/// of which there are so many along each side at most.
const MOST_CELLS: usize = 64;

/// How many facades are where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Nearness {
    /// Facades on a wall.
    pub on_wall: usize,
    /// Facades on no wall, but within 3 m of one or inside a building.
    pub near: usize,
    /// Facades on no wall, but within 6 m of one or inside a building.
    pub around: usize,
}

impl Nearness {
    /// Of the facades of a submap at a refined pose, with the estimated offsets of buildings.
    pub fn of(chart: &Chart, submap: &Submap, refined: &Refined) -> Self {
        let facades = submap.facades.iter().map(|facade| {
            let at = refined.pose.transform(facade.at.x, facade.at.y);
            Pose2::new(at.x, at.y, facade.facing + refined.pose.yaw)
        });
        let facades: Vec<Pose2> = facades.collect();
        let around = facades
            .iter()
            .map(|facade| Bounds::of_point(facade.point()));
        let Some(around) = around.reduce(Bounds::union) else {
            return Self::default();
        };
        let surroundings = Surroundings::within(around, chart, refined);
        let mut nearness = Self::default();
        for facade in facades {
            nearness.count(&surroundings, facade);
        }
        nearness
    }

    /// Counts a facade, whose pose has the direction in which it faces.
    fn count(&mut self, surroundings: &Surroundings<'_>, facade: Pose2) {
        let at = facade.point();
        let mut nearest = AROUND_M;
        for wall in surroundings.walls_at(at) {
            let away = wall.segment.distance_to_point(at);
            if away < ON_WALL_M && wrap_angle(wall.facing - facade.yaw).abs() < FACING_RAD {
                self.on_wall += 1;
                return;
            }
            nearest = nearest.min(away);
        }
        let is_near = nearest < NEAR_M || surroundings.is_inside(at);
        self.near += usize::from(is_near);
        self.around += usize::from(is_near || nearest < AROUND_M);
    }

    /// Logarithm of the facades on walls over those that are near walls and on none.
    pub fn on_over_near(&self) -> f64 {
        log_ratio(self.on_wall, self.near)
    }

    /// The same with those around walls.
    pub fn on_over_around(&self) -> f64 {
        log_ratio(self.on_wall, self.around)
    }
}

/// Walls and outlines in cells, each in those from which it is at most [`AROUND_M`] away.
struct Surroundings<'a> {
    grid: GridGeometry,
    cells: Vec<Cell<'a>>,
}

#[derive(Clone, Default)]
struct Cell<'a> {
    walls: Vec<Facing>,
    outlines: Vec<&'a Polygon>,
}

/// A wall where its building is estimated to be.
#[derive(Clone, Copy)]
struct Facing {
    segment: Segment,
    /// Direction in which it faces, radians.
    facing: f64,
}

impl<'a> Surroundings<'a> {
    /// Within bounds in the chart's coordinates.
    fn within(bounds: Bounds, chart: &'a Chart, refined: &Refined) -> Self {
        let mut surroundings = Self::empty(bounds);
        let offsets = refined.offsets(chart.outlines.len());
        let here = refined.pose.point();
        let near = |wall: &&Wall| wall.segment.distance_to_point(here) < REACH_M + AROUND_M;
        for wall in chart.walls.iter().filter(near) {
            let by = offsets[wall.building];
            let moved = |at: MapPoint| MapPoint::new(at.x + by.x, at.y + by.y);
            let Segment { start, end } = wall.segment;
            surroundings.add_wall(Segment::new(moved(start), moved(end)));
        }
        // Outlines are not moved: those that are inside by a metre or two are near a wall.
        for outline in &chart.outlines {
            surroundings.add_outline(outline);
        }
        surroundings
    }

    fn empty(bounds: Bounds) -> Self {
        // A point on the upper border is in no cell.
        let Bounds { low, high } = bounds.grown(0.01);
        let grid = GridGeometry::covering(low, high, CELL_M, MOST_CELLS);
        Self {
            grid,
            cells: vec![Cell::default(); grid.len()],
        }
    }

    fn add_wall(&mut self, segment: Segment) {
        let ends = Bounds::of_point(segment.start).union(Bounds::of_point(segment.end));
        let wall = Facing {
            segment,
            facing: segment.outward(),
        };
        let around = ends.grown(AROUND_M);
        for cell in self.grid.cells_between(around.low, around.high) {
            self.cells[cell].walls.push(wall);
        }
    }

    fn add_outline(&mut self, outline: &'a Polygon) {
        let bounds = outline.bounds();
        for cell in self.grid.cells_between(bounds.low, bounds.high) {
            self.cells[cell].outlines.push(outline);
        }
    }

    fn walls_at(&self, at: MapPoint) -> &[Facing] {
        let cell = self.grid.cell_at(at);
        cell.map_or(&[], |cell| &self.cells[cell].walls)
    }

    fn is_inside(&self, at: MapPoint) -> bool {
        let cell = self.grid.cell_at(at).map(|cell| &self.cells[cell]);
        cell.is_some_and(|cell| cell.outlines.iter().any(|outline| outline.contains(at)))
    }
}

/// Finite if there are none of one kind.
fn log_ratio(on: usize, off: usize) -> f64 {
    libm::log((on as f64 + 1.0) / (off as f64 + 1.0))
}

#[cfg(test)]
mod tests {
    use super::super::refine::{Assumptions, refine};
    use super::super::town::{block, chart, stretch_at, town};
    use super::*;

    /// What is seen among houses from the middle of them.
    fn seen(houses: &[Polygon]) -> Submap {
        Submap::of(&[stretch_at(houses, Pose2::default())])
    }

    /// Of that, with a map, at a pose.
    fn nearness(houses: &[Polygon], mapped: &[Polygon], at: Pose2) -> Nearness {
        let seen = seen(houses);
        let chart = chart(mapped);
        let refined = refine(&chart, &seen, at, &Assumptions::default()).unwrap();
        let found = Nearness::of(&chart, &seen, &refined);
        assert!(found.on_wall + found.around <= seen.facades.len());
        found
    }

    #[test]
    fn where_the_pose_is_right_facades_near_walls_are_on_them() {
        let right = nearness(&town(), &town(), Pose2::default());
        assert!(right.on_over_near() > 3.0, "{right:?}");
        let wrong = nearness(&town(), &town(), Pose2::new(6.0, 1.0, 1.6));
        assert!(
            wrong.on_over_near() < right.on_over_near() - 2.0,
            "{wrong:?}"
        );
    }

    #[test]
    fn what_the_map_lacks_far_from_its_walls_changes_nothing() {
        let mapped = town();
        // Its north side is 7 m behind the houses of the south.
        let walled = [mapped.clone(), vec![block(0.0, -32.0, 90.0, 6.0)]].concat();
        assert!(seen(&walled).facades.len() > seen(&mapped).facades.len());
        let (with, without) = (
            nearness(&walled, &mapped, Pose2::default()),
            nearness(&mapped, &mapped, Pose2::default()),
        );
        assert_eq!((with.on_wall, with.near), (without.on_wall, without.near));
    }

    /// On walls, near them and around them.
    fn counts(surroundings: &Surroundings<'_>, facade: Pose2) -> [usize; 3] {
        let mut found = Nearness::default();
        found.count(surroundings, facade);
        [found.on_wall, found.near, found.around]
    }

    fn empty() -> Surroundings<'static> {
        let corner = |at: f64| MapPoint::new(at, at);
        Surroundings::empty(Bounds {
            low: corner(-50.0),
            high: corner(50.0),
        })
    }

    #[test]
    fn a_facade_inside_a_building_is_near_its_walls_however_large_it_is() {
        let hall = block(0.0, 0.0, 60.0, 60.0);
        let mut surroundings = empty();
        surroundings.add_outline(&hall);
        assert_eq!(counts(&surroundings, Pose2::default()), [0, 1, 1]);
        let outside = Pose2::new(40.0, 0.0, 0.0);
        assert_eq!(counts(&surroundings, outside), [0, 0, 0]);
    }

    #[test]
    fn a_facade_on_a_wall_faces_the_same_way() {
        let mut surroundings = empty();
        let wall = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(10.0, 0.0));
        surroundings.add_wall(wall);
        let at = |y: f64, facing: f64| counts(&surroundings, Pose2::new(5.0, y, facing));
        let out = wall.outward();
        assert_eq!(at(-0.5, out + 0.3), [1, 0, 0]);
        assert_eq!(at(-0.5, out + 3.0), [0, 1, 1]);
        assert_eq!(at(-2.0, out), [0, 1, 1]);
        assert_eq!(at(-5.0, out), [0, 0, 1]);
        assert_eq!(at(-8.0, out), [0, 0, 0]);
        // Beyond all cells.
        assert_eq!(at(-1000.0, out), [0, 0, 0]);
    }

    #[test]
    fn ratios_are_finite() {
        let none = Nearness::default();
        assert_eq!((none.on_over_near(), none.on_over_around()), (0.0, 0.0));
    }
}
