//! The cheapest path of each class around what stands.

use openbench_core::MapPoint;
use openbench_geometry::Segment;
use openbench_geometry::grid::{GridGeometry, NEIGHBOURS, in_sight};

use super::search::{ClassSearch, Field, Found};
use super::signature::{Clusters, MOST_CLUSTERS, Passing, Signature, keep_nearest};
use crate::checks::{SettingsError, at_least, not_negative, positive};
use crate::near_cells::each_cell_near;
use crate::shape::Obstacle;

/// Most cells along one side of the window.
const MOST_CELLS: usize = 320;
/// Cost that a metre aside of the straight line adds to a cell.
const LEAN: f64 = 0.01;
/// How far from a blocked start or goal a free cell is looked for, metres.
const ESCAPE_M: f64 = 0.5;
/// Cost by which a cell on a straight line may exceed the dearest that the line replaces.
const NO_DEARER: f64 = 0.3;

/// How paths are searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exploring {
    /// Side of a cell, metres.
    pub cell: f64,
    /// Ground beyond start and goal that paths may use, metres.
    pub around: f64,
    /// Distance of the robot's middle from obstacles below which it does not fit, metres.
    pub keep: f64,
    /// Distance above which nearness costs nothing, metres.
    pub comfort: f64,
    /// Most classes.
    pub most: usize,
    /// Paths that cost more than this many times the cheapest are left out.
    pub longest: f64,
}

impl Default for Exploring {
    fn default() -> Self {
        Self {
            cell: 0.1,
            around: 1.5,
            keep: 0.16,
            comfort: 0.4,
            most: 5,
            longest: 1.6,
        }
    }
}

impl Exploring {
    /// Whether classes can be searched like that.
    pub fn check(&self) -> Result<(), SettingsError> {
        positive("the side of a cell", self.cell)?;
        not_negative("the ground around start and goal", self.around)?;
        not_negative("the distance below which the robot does not fit", self.keep)?;
        let more = "it must be more than the distance below which the robot does not fit";
        let (least, one) = (self.keep + self.cell, "it must be one or more");
        at_least(
            "the distance above which nearness costs nothing",
            self.comfort,
            least,
            more,
        )?;
        at_least("the number of classes", self.most as f64, 1.0, one)?;
        at_least(
            "the cost of the dearest path by that of the cheapest",
            self.longest,
            1.0,
            one,
        )
    }
}

/// A path and its class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassPath {
    /// From start to goal, in `map`.
    pub corners: Vec<MapPoint>,
    /// Its class.
    pub signature: Signature,
    /// What it costs, metres of open ground.
    pub cost: f64,
}

/// Searches paths; its buffers are used again.
#[derive(Debug, Default)]
pub struct Explorer {
    clusters: Clusters,
    /// Cost of a cell, infinite where the robot does not fit.
    costs: Vec<f64>,
    search: ClassSearch,
}

impl Explorer {
    /// The clusters of the last [`Explorer::explore`].
    pub fn clusters(&self) -> &Clusters {
        &self.clusters
    }

    /// The same, to be kept.
    pub(crate) fn take_clusters(&mut self) -> Clusters {
        std::mem::take(&mut self.clusters)
    }

    /// The cheapest paths from `start` to `goal`, each of a class of its own, the cheapest first.
    /// Obstacles count where they are now.
    pub fn explore(
        &mut self,
        start: MapPoint,
        goal: MapPoint,
        obstacles: &[Obstacle],
        how: &Exploring,
    ) -> Vec<ClassPath> {
        let grid = window(start, goal, how);
        self.lay_costs(&grid, obstacles, how);
        self.lean(&grid, start, goal);
        // From the costs: obstacles with no gap for the robot between them are one cluster.
        self.clusters.standing = clusters(&grid, &self.costs);
        keep_nearest(&mut self.clusters.standing, MOST_CLUSTERS, |cluster| {
            Segment::new(start, goal)
                .nearest_point(*cluster)
                .point
                .distance(*cluster)
        });
        let ends = (self.free_near(&grid, start), self.free_near(&grid, goal));
        let (Some(from), Some(to)) = ends else {
            return Vec::new();
        };
        let field = Field {
            grid: &grid,
            costs: &self.costs,
            clusters: &self.clusters.standing,
            most: how.most,
            longest: how.longest,
        };
        let found = self.search.run(&field, from, to);
        found
            .into_iter()
            .map(|found| self.class_path(&grid, &found, start, goal))
            .collect()
    }

    fn lay_costs(&mut self, grid: &GridGeometry, obstacles: &[Obstacle], how: &Exploring) {
        self.costs.clear();
        // Distances at first, up to the comfortable one; below they become costs.
        self.costs.resize(grid.len(), how.comfort);
        for obstacle in obstacles {
            each_cell_near(grid, obstacle, how.comfort, |cell, distance| {
                self.costs[cell] = self.costs[cell].min(distance);
            });
        }
        // A path between the middles of cells may miss the middle of a gap by half a cell.
        let keep = how.keep - 0.5 * grid.cell;
        for value in &mut self.costs {
            let near = (how.comfort - *value) / (how.comfort - keep);
            *value = if *value < keep {
                f64::INFINITY
            } else {
                1.0 + 2.0 * near * near
            };
        }
    }

    /// Makes cells a little dearer the further they are from the straight line: of the many paths
    /// over a grid that cost the same, one is left, and its mirror image in the mirrored scene.
    fn lean(&mut self, grid: &GridGeometry, start: MapPoint, goal: MapPoint) {
        let length = start.distance(goal).max(grid.cell);
        let (east, north) = ((goal.x - start.x) / length, (goal.y - start.y) / length);
        for (cell, cost) in self.costs.iter_mut().enumerate() {
            let at = grid.center(cell);
            *cost += LEAN * ((at.x - start.x) * north - (at.y - start.y) * east).abs();
        }
    }

    /// The cell of a point, or the nearest free one around it.
    fn free_near(&self, grid: &GridGeometry, point: MapPoint) -> Option<usize> {
        let here = grid.cell_at(point)?;
        if self.costs[here].is_finite() {
            return Some(here);
        }
        let low = MapPoint::new(point.x - ESCAPE_M, point.y - ESCAPE_M);
        let high = MapPoint::new(point.x + ESCAPE_M, point.y + ESCAPE_M);
        let free = grid
            .cells_between(low, high)
            .filter(|&cell| self.costs[cell].is_finite());
        free.min_by(|&a, &b| {
            let [a, b] = [a, b].map(|cell| grid.center(cell).distance(point));
            a.total_cmp(&b)
        })
    }

    fn class_path(
        &self,
        grid: &GridGeometry,
        found: &Found,
        start: MapPoint,
        goal: MapPoint,
    ) -> ClassPath {
        let corners = self.straighten(grid, &found.cells);
        // Start and goal themselves replace the middles of their cells. A path may be a single
        // cell.
        let inner = corners[1..corners.len().max(2) - 1]
            .iter()
            .map(|&cell| grid.center(cell));
        let corners = std::iter::once(start).chain(inner).chain([goal]).collect();
        ClassPath {
            corners,
            signature: found.signature,
            cost: found.cost * grid.cell,
        }
    }

    /// Leaves out cells where a straight line is of the same class and costs no more.
    fn straighten(&self, grid: &GridGeometry, cells: &[usize]) -> Vec<usize> {
        let mut kept = vec![cells[0]];
        let mut at = 0;
        while at + 1 < cells.len() {
            let mut next = at + 1;
            let mut dearest = self.costs[cells[next]];
            for candidate in at + 2..cells.len() {
                // The dearest cell among those that the line would leave out.
                dearest = dearest.max(self.costs[cells[candidate]]);
                let no_dearer = |cell: usize| self.costs[cell] <= dearest + NO_DEARER;
                if !in_sight(grid, no_dearer, cells[at], cells[candidate])
                    || !self.is_of_one_class(grid, &cells[at..=candidate])
                {
                    break;
                }
                next = candidate;
            }
            kept.push(cells[next]);
            at = next;
        }
        kept
    }

    /// Whether the straight line between the ends of a path is of the path's class.
    fn is_of_one_class(&self, grid: &GridGeometry, cells: &[usize]) -> bool {
        let passing = |&cell: &usize| Passing {
            point: grid.center(cell),
            time: 0.0,
        };
        let ends = [cells[0], cells[cells.len() - 1]];
        self.clusters.signature(cells.iter().map(passing))
            == self.clusters.signature(ends.iter().map(passing))
    }
}

/// Start and goal and the ground around them, in the middle of the cells: mirrored scenes have
/// mirrored cells.
fn window(start: MapPoint, goal: MapPoint, how: &Exploring) -> GridGeometry {
    let (width, height) = ((goal.x - start.x).abs(), (goal.y - start.y).abs());
    // Places far apart get coarser cells, so that a search takes no longer.
    let side = width.max(height) + 2.0 * how.around;
    let cell = how.cell.max(side / MOST_CELLS as f64);
    let columns = cells_over(width + 2.0 * how.around, cell);
    let rows = cells_over(height + 2.0 * how.around, cell);
    let middle = MapPoint::new((start.x + goal.x) / 2.0, (start.y + goal.y) / 2.0);
    let origin = MapPoint::new(
        middle.x - columns as f64 * cell / 2.0,
        middle.y - rows as f64 * cell / 2.0,
    );
    GridGeometry {
        origin,
        width: columns,
        height: rows,
        cell,
    }
}

/// How many cells cover a length, metres.
fn cells_over(length: f64, cell: f64) -> usize {
    ((length / cell).ceil() as usize).clamp(1, MOST_CELLS + 1)
}

/// One point in each connected set of cells where the robot does not fit; a little off the middles
/// of cells, so that no step begins or ends on a ray.
fn clusters(grid: &GridGeometry, costs: &[f64]) -> Vec<MapPoint> {
    let mut found = Vec::new();
    let mut visited = vec![false; grid.len()];
    for first in 0..grid.len() {
        if costs[first].is_infinite() && !visited[first] {
            let members = connected(grid, costs, first, &mut visited);
            let at = grid.center(central(grid, &members));
            found.push(MapPoint::new(at.x + 0.1 * grid.cell, at.y));
        }
    }
    found
}

/// The cells where the robot does not fit that are connected with one of them.
fn connected(grid: &GridGeometry, costs: &[f64], first: usize, visited: &mut [bool]) -> Vec<usize> {
    let mut members = Vec::new();
    let mut open = vec![first];
    visited[first] = true;
    while let Some(cell) = open.pop() {
        let (x, y) = grid.column_row(cell);
        members.push(cell);
        for next in NEIGHBOURS
            .iter()
            .filter_map(|(dx, dy)| grid.cell_in(x + dx, y + dy))
        {
            if costs[next].is_infinite() && !visited[next] {
                visited[next] = true;
                open.push(next);
            }
        }
    }
    members
}

/// The member of a set of cells, one at least, that is nearest to their mean: far from where paths
/// pass.
fn central(grid: &GridGeometry, members: &[usize]) -> usize {
    let count = members.len() as f64;
    let (mut sum_x, mut sum_y) = (0.0, 0.0);
    for &cell in members {
        let (x, y) = grid.column_row(cell);
        (sum_x, sum_y) = (sum_x + x as f64, sum_y + y as f64);
    }
    let mut nearest = members[0];
    let mut least = f64::INFINITY;
    for &cell in members {
        let (x, y) = grid.column_row(cell);
        let (dx, dy) = (x as f64 - sum_x / count, y as f64 - sum_y / count);
        let square = dx * dx + dy * dy;
        // Of several as near, the first: the choice must not depend on anything else.
        if square < least {
            (nearest, least) = (cell, square);
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    /// The least distance of a path from obstacles.
    fn least_distance(obstacles: &[Obstacle], corners: &[MapPoint]) -> f64 {
        let at = |pair: &[MapPoint], k: i32| {
            let t = f64::from(k) / 20.0;
            let (a, b) = (pair[0], pair[1]);
            point(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y))
        };
        let points = corners
            .windows(2)
            .flat_map(|pair| (0..=20).map(move |k| at(pair, k)));
        let distances = points.flat_map(|p| obstacles.iter().map(move |o| o.distance_to(p)));
        distances.fold(f64::INFINITY, f64::min)
    }

    fn discs(at: &[(f64, f64)]) -> Vec<Obstacle> {
        at.iter()
            .map(|(x, y)| Obstacle::disc(point(*x, *y), 0.2).unwrap())
            .collect()
    }

    #[test]
    fn one_disc_has_two_classes_and_two_apart_have_four() {
        let mut explorer = Explorer::default();
        let how = Exploring::default();
        let paths = explorer.explore(
            point(0.0, 0.0),
            point(4.0, 0.0),
            &discs(&[(2.0, 0.1)]),
            &how,
        );
        assert_eq!(paths.len(), 2);
        let side = |path: &ClassPath| {
            path.corners
                .iter()
                .map(|c| c.y)
                .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
        };
        assert!(side(&paths[0]) < -0.1 && side(&paths[1]) > 0.1, "{paths:?}");
        let paths = explorer.explore(
            point(0.0, 0.0),
            point(4.0, 0.0),
            &discs(&[(1.3, 0.0), (2.7, 0.0)]),
            &how,
        );
        assert_eq!(paths.len(), 4);
        assert!(paths.windows(2).all(|w| w[0].cost <= w[1].cost));
    }

    #[test]
    fn of_many_discs_those_near_the_line_are_distinguished() {
        let aside = (0..14).flat_map(|i| {
            (0..4).map(move |k| (0.6 * f64::from(i) - 3.0, 0.5 * f64::from(k) - 2.9))
        });
        let at: Vec<(f64, f64)> = aside.chain([(2.0, 0.1)]).collect();
        let (start, goal) = (point(0.0, 0.0), point(4.0, 0.0));
        let how = Exploring {
            around: 3.0,
            most: 2,
            ..Exploring::default()
        };
        let small: Vec<Obstacle> = at
            .iter()
            .map(|(x, y)| Obstacle::disc(point(*x, *y), 0.02).unwrap())
            .collect();
        let paths = Explorer::default().explore(start, goal, &small, &how);
        let highest = |path: &ClassPath| path.corners.iter().map(|c| c.y).fold(-9.0, f64::max);
        let heights: Vec<f64> = paths.iter().map(highest).collect();
        assert!(
            heights.iter().any(|y| *y > 0.2) && heights.iter().any(|y| *y < 0.1),
            "{heights:?}"
        );
        assert!(
            heights.len() == 2 && paths[1].cost < 1.3 * paths[0].cost,
            "{paths:?}"
        );
    }

    #[test]
    fn discs_too_near_each_other_are_one_cluster() {
        let near = discs(&[(2.0, 0.0), (2.0, 0.5), (2.0, -0.5)]);
        let paths = Explorer::default().explore(
            point(0.0, 0.0),
            point(4.0, 0.0),
            &near,
            &Exploring::default(),
        );
        assert_eq!(paths.len(), 2);
    }

    #[test]
    fn no_path_leads_through_a_closed_wall() {
        let wall = [Obstacle::wall(point(2.0, -20.0), point(2.0, 20.0)).unwrap()];
        let paths = Explorer::default().explore(
            point(0.0, 0.0),
            point(4.0, 0.0),
            &wall,
            &Exploring::default(),
        );
        assert!(paths.is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        // As far from the line as leaves a path along the edge of the window: further out, a row of
        // them can close it.
        #[test]
        fn paths_have_ends_signatures_of_their_own_and_keep_off_discs(
            at in prop::collection::vec((0.8..3.2_f64, -1.1..1.1_f64), 0..12),
        ) {
            let (start, goal) = (point(0.0, 0.0), point(4.0, 0.0));
            let (discs, how) = (discs(&at), Exploring::default());
            let mut explorer = Explorer::default();
            let paths = explorer.explore(start, goal, &discs, &how);
            prop_assert!(!paths.is_empty() && paths.len() <= how.most);
            for (i, path) in paths.iter().enumerate() {
                prop_assert_eq!((path.corners[0], path.corners.last()), (start, Some(&goal)));
                let passing = path.corners.iter().map(|c| Passing { point: *c, time: 0.0 });
                prop_assert_eq!(explorer.clusters().signature(passing), path.signature);
                prop_assert!(paths[..i].iter().all(|other| other.signature != path.signature));
                let least = least_distance(&discs, &path.corners);
                prop_assert!(least > how.keep - 0.15, "{least}");
            }
        }
    }
}
