//! A rolling window: the ground around the robot in finer cells, moving along with it.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::grid::GridGeometry;

use crate::costmap::Costmap;
use crate::costmap::ground::{Ground, MappedObstacle, Preferences};
use crate::obstacles::RangeRing;
use crate::shape::{Footprint, Obstacle};

/// Side of a cell, metres.
const CELL_M: f64 = 0.05;
/// From the middle to each side, metres: what a scan shows and a little more.
const HALF_M: f64 = 9.0;
/// Distance of the robot from the middle at which the window moves, metres.
const SLACK_M: f64 = 1.0;
/// A move by more cells is an error of the pose: coordinates would lose their cells to rounding.
const MOST_MOVED: f64 = 1e9;

/// A costmap that moves with the robot (a rolling window). What leaves it is forgotten; the layer
/// of the map comes from a larger costmap.
#[derive(Debug, Clone)]
pub struct RollingWindow {
    costmap: Costmap,
}

impl RollingWindow {
    /// The window around a place.
    pub fn new(whole: &Costmap, place: MapPoint) -> Self {
        let side = (2.0 * HALF_M / CELL_M) as usize;
        // On whole cells, so that cells keep their places when the window moves.
        let origin = MapPoint::new(corner_about(place.x), corner_about(place.y));
        let grid = GridGeometry {
            origin,
            width: side,
            height: side,
            cell: CELL_M,
        };
        let ground = Ground::unknown(grid.len());
        let mut window = Self {
            costmap: Costmap::over(grid, ground, whole.room, Preferences::NONE),
        };
        window.take_ground(whole);
        window
    }

    /// Moves along with a robot that got to `place`.
    pub fn follow(&mut self, whole: &Costmap, place: MapPoint) {
        let before = self.costmap.grid;
        let grid = &mut self.costmap.grid;
        let columns = cells_to_move(place.x, grid.origin.x);
        let rows = cells_to_move(place.y, grid.origin.y);
        let is_possible = columns.abs() < MOST_MOVED && rows.abs() < MOST_MOVED;
        let is_far = columns.abs() * CELL_M > SLACK_M || rows.abs() * CELL_M > SLACK_M;
        // With NaN both are false: a robot that does not know its pose moves nothing.
        if !(is_possible && is_far) {
            return;
        }
        grid.origin = MapPoint::new(
            moved_by_cells(grid.origin.x, columns),
            moved_by_cells(grid.origin.y, rows),
        );
        self.costmap.seen.carry(&before, &self.costmap.grid);
        self.take_ground(whole);
    }

    /// Takes over the layer of the map, after it has changed. What was seen is kept.
    pub fn take_ground(&mut self, whole: &Costmap) {
        // Kinds of ground are left out: by `Preferences::NONE` they all cost the same.
        for cell in 0..self.costmap.grid.len() {
            let from = whole.grid.cell_at(self.costmap.grid.center(cell));
            self.costmap.ground.obstacles[cell] =
                from.map_or(MappedObstacle::No, |from| whole.ground.obstacles[from]);
        }
    }

    /// The cells.
    pub fn grid(&self) -> &GridGeometry {
        self.costmap.grid()
    }

    /// See [`Costmap::observe_static`].
    pub fn observe_static(&mut self, ring: &RangeRing, moves: impl Fn(MapPoint) -> bool) {
        self.costmap.observe_static(ring, moves);
        self.costmap.seen.forget();
    }

    /// See [`Costmap::forget_seen`].
    pub fn forget_seen(&mut self) {
        self.costmap.forget_seen();
    }

    /// Forgets obstacles where the robot is, water too: it has to drive out of there.
    pub fn clear_below(&mut self, footprint: &Footprint, pose: Pose2) {
        for cell in self.costmap.obstacles_below(footprint, pose) {
            self.costmap.seen.clear(cell);
            self.costmap.ground.obstacles[cell] = MappedObstacle::No;
        }
    }

    /// See [`Costmap::obstacles_near`].
    pub fn obstacles_near(&self, point: MapPoint, reach: f64) -> Vec<Obstacle> {
        self.costmap.obstacles_near(point, reach)
    }
}

/// A coordinate of the corner of a window around `at`, metres.
fn corner_about(at: f64) -> f64 {
    ((at - HALF_M) / CELL_M).round() * CELL_M
}

/// By how many cells a window whose corner is at `origin` moves to be around `at`.
fn cells_to_move(at: f64, origin: f64) -> f64 {
    ((at - HALF_M - origin) / CELL_M).round()
}

/// A coordinate moved by whole cells: counted in cells, so that rounding does not accumulate.
fn moved_by_cells(at: f64, cells: f64) -> f64 {
    ((at / CELL_M).round() + cells) * CELL_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::tests::open_ground;
    use crate::obstacles::ScanPoint;
    use openbench_core::RobotDescription;

    #[test]
    fn seen_obstacles_keep_their_places_until_the_window_has_left_them() {
        let whole = open_ground();
        let mut window = RollingWindow::new(&whole, MapPoint::default());
        let post = MapPoint::new(2.03, 1.03);
        window.observe_static(
            &RangeRing::new(
                MapPoint::default(),
                0.25,
                std::iter::once(ScanPoint::new(post, 0.3)),
            ),
            |_| false,
        );
        let near = |window: &RollingWindow| window.obstacles_near(post, 0.5);
        assert_eq!(near(&window).len(), 1);
        let place = near(&window)[0].middle();
        assert!(place.distance(post) < 0.04);
        window.follow(&whole, MapPoint::new(5.3, -4.2));
        assert_eq!(
            near(&window)
                .iter()
                .map(Obstacle::middle)
                .collect::<Vec<_>>(),
            [place]
        );
        // A robot that does not know its pose has not left.
        for lost in [
            (f64::NAN, 30.0),
            (30.0, f64::NAN),
            (f64::INFINITY, 0.0),
            (1e300, 0.0),
        ] {
            window.follow(&whole, MapPoint::new(lost.0, lost.1));
            assert_eq!(
                near(&window)
                    .iter()
                    .map(Obstacle::middle)
                    .collect::<Vec<_>>(),
                [place]
            );
        }
        window.follow(&whole, MapPoint::new(30.0, 0.0));
        assert!(
            window
                .obstacles_near(MapPoint::new(30.0, 0.0), 9.0)
                .is_empty()
        );
        window.follow(&whole, MapPoint::default());
        assert!(near(&window).is_empty());
    }

    #[test]
    fn the_ground_below_the_robot_is_free() {
        let mut window = RollingWindow::new(&open_ground(), MapPoint::default());
        window.costmap.ground.obstacles.fill(MappedObstacle::Water);
        let is_obstacle = |window: &RollingWindow, x: f64| {
            window
                .costmap
                .is_obstacle(window.grid().cell_at(MapPoint::new(x, 0.0)).unwrap())
        };
        assert!(is_obstacle(&window, 0.0) && is_obstacle(&window, 1.0));
        window.clear_below(
            &Footprint::of(&RobotDescription::sentry()).unwrap(),
            Pose2::default(),
        );
        assert!(!is_obstacle(&window, 0.0) && is_obstacle(&window, 1.0));
    }
}
