//! Homotopy classes: ways that cannot be bent into each other without passing through an obstacle.
//!
//! Obstacles too near each other for the robot to pass between are one. From each such clump a ray goes north; how often a way crosses the rays, eastwards less westwards, is its [`Signature`]. Ways with the same ends
//! and different signatures are of different classes (the invariant is that of S. Bhattacharya et al., *Topological constraints in search-based robot path planning*, 2012; C. Roesmann et al.,
//! *Integrated online trajectory planning and optimization in distinctive topologies*, 2017, tell bands apart by it). A* over cells *and* signatures finds the cheapest way of each of the cheapest classes in one search.

use openbench_core::MapPoint;
use openbench_grid::{Frontier, GridGeometry, in_sight};
use openbench_osm::polygon::Segment;

use crate::shape::Obstacle;
use crate::teb::settings::{SettingsError, at_least, not_negative, positive};

/// Clumps that are told apart, those nearest to the straight line; further ones are not.
const MOST_CLUMPS: usize = 24;
/// Moving obstacles that are told apart, the nearest.
const MOST_MOVING: usize = 8;
/// Bits of a signature for each clump.
const BITS: usize = 4;
/// Most cells along one side of the window.
const MOST_CELLS: usize = 320;

/// What a metre aside of the straight line adds to the cost of a cell.
const LEAN: f64 = 0.01;

/// How ways are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exploring {
    /// Side of a cell, metres.
    pub cell: f64,
    /// Ground beyond start and goal that ways may use, metres.
    pub around: f64,
    /// Distance of the robot's middle from obstacles below which it does not fit, metres.
    pub keep: f64,
    /// Distance above which nearness costs nothing, metres.
    pub comfort: f64,
    /// Most classes.
    pub most: usize,
    /// Ways that cost more than this many times the cheapest are left.
    pub longest: f64,
}

impl Default for Exploring {
    fn default() -> Self {
        Self { cell: 0.1, around: 1.5, keep: 0.16, comfort: 0.4, most: 5, longest: 1.6 }
    }
}

impl Exploring {
    /// Whether classes can be looked for like that.
    pub fn check(&self) -> Result<(), SettingsError> {
        positive("the side of a cell", self.cell)?;
        not_negative("the ground around start and goal", self.around)?;
        not_negative("the distance below which the robot does not fit", self.keep)?;
        let more = "it must be more than the distance below which the robot does not fit";
        let (least, one) = (self.keep + self.cell, "it must be one or more");
        at_least("the distance above which nearness costs nothing", self.comfort, least, more)?;
        at_least("the number of classes", self.most as f64, 1.0, one)?;
        at_least("the cost of the dearest way, by that of the cheapest", self.longest, 1.0, one)
    }
}

/// How a way winds about the clumps of one [`Clumps`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Signature(u128);

/// A way and its class.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// From start to goal.
    pub corners: Vec<MapPoint>,
    /// Its class.
    pub signature: Signature,
    /// What it costs, metres of open ground.
    pub cost: f64,
}

/// What ways wind about: a point in each clump of what stands, and what moves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clumps {
    standing: Vec<MapPoint>,
    moving: Vec<(MapPoint, [f64; 2])>,
}

impl Clumps {
    /// Tells ways apart by those who move, too: who passes before somebody winds otherwise about them than who passes behind.
    pub fn set_moving(&mut self, obstacles: &[Obstacle], robot: MapPoint) {
        let moving = obstacles.iter().filter(|o| o.is_moving()).map(|o| (o.middle(), o.velocity()));
        self.moving.clear();
        self.moving.extend(moving);
        keep_nearest(&mut self.moving, MOST_MOVING, |(middle, _)| middle.distance(robot));
    }

    /// The signature of a way through points at times, seconds from now.
    pub fn signature(&self, points: impl Iterator<Item = (MapPoint, f64)>) -> Signature {
        let mut signature = Signature::default();
        let mut before: Option<(MapPoint, f64)> = None;
        for (point, time) in points {
            if let Some((from, left)) = before {
                signature = self.after(signature, from, point);
                for (i, (middle, v)) in self.moving.iter().enumerate() {
                    let as_seen = |p: MapPoint, t: f64| MapPoint::new(p.x - v[0] * t, p.y - v[1] * t);
                    let (a, b) = (as_seen(from, left), as_seen(point, time));
                    signature = signature.wound(MOST_CLUMPS + i, *middle, a, b);
                }
            }
            before = Some((point, time));
        }
        signature
    }

    fn after(&self, signature: Signature, a: MapPoint, b: MapPoint) -> Signature {
        let clumps = self.standing.iter().enumerate();
        clumps.fold(signature, |signature, (i, clump)| signature.wound(i, *clump, a, b))
    }
}

/// Leaves the nearest, in their order from there; few enough stay as they are.
fn keep_nearest<T>(all: &mut Vec<T>, most: usize, off: impl Fn(&T) -> f64) {
    if all.len() > most {
        all.sort_by(|a, b| off(a).total_cmp(&off(b)));
        all.truncate(most);
    }
}

impl Signature {
    /// Counts a step from `a` to `b` if it crosses the ray north from `clump`.
    fn wound(self, i: usize, clump: MapPoint, a: MapPoint, b: MapPoint) -> Self {
        if (a.x < clump.x) == (b.x < clump.x) {
            return self;
        }
        let share = (clump.x - a.x) / (b.x - a.x);
        if a.y + share * (b.y - a.y) <= clump.y {
            return self;
        }
        let one = 1u128 << (BITS * i);
        let field = 0xf_u128 << (BITS * i);
        let turned = if a.x < b.x { self.0.wrapping_add(one) } else { self.0.wrapping_sub(one) };
        Self((self.0 & !field) | (turned & field))
    }
}

/// A cell that was reached, with the class of the way to it.
#[derive(Debug, Clone, Copy)]
struct Reached {
    cell: usize,
    signature: Signature,
    cost: f64,
    from: u32,
}

const NOWHERE: u32 = u32::MAX;

/// Looks for ways; its buffers are used again.
#[derive(Debug, Default)]
pub struct Explorer {
    clumps: Clumps,
    /// Cost of a cell, infinite where the robot does not fit.
    costs: Vec<f64>,
    reached: Vec<Reached>,
    /// For each cell the last entry of `reached` that was closed there, and for each entry the one before.
    closed: Vec<u32>,
    closed_before: Vec<u32>,
    /// The same of those that were opened.
    opened: Vec<u32>,
    opened_before: Vec<u32>,
    crossings: Crossings,
}

/// Which rays a step from each column to the next one east crosses, if it is north of their clumps.
#[derive(Debug, Default)]
struct Crossings {
    /// Numbers of clumps, column by column.
    clumps: Vec<usize>,
    /// For each column where its own begin.
    first: Vec<usize>,
}

impl Crossings {
    fn lay(&mut self, grid: &GridGeometry, standing: &[MapPoint]) {
        self.clumps.clear();
        self.first.clear();
        let east = |column: usize, clump: &MapPoint| grid.center(column).x < clump.x;
        for column in 0..grid.width {
            self.first.push(self.clumps.len());
            let crossed = |(_, clump): &(usize, &MapPoint)| {
                column + 1 < grid.width && east(column, clump) != east(column + 1, clump)
            };
            self.clumps.extend(standing.iter().enumerate().filter(crossed).map(|(i, _)| i));
        }
        self.first.push(self.clumps.len());
    }

    /// Those between two columns that are the same or neighbours.
    fn between(&self, a: i64, b: i64) -> &[usize] {
        let column = a.min(b) as usize;
        if a == b { &[] } else { &self.clumps[self.first[column]..self.first[column + 1]] }
    }
}

impl Explorer {
    /// The clumps of the last [`Explorer::explore`].
    pub fn clumps(&self) -> &Clumps {
        &self.clumps
    }

    /// The same, to be kept.
    pub fn take_clumps(&mut self) -> Clumps {
        std::mem::take(&mut self.clumps)
    }

    /// The cheapest ways from `start` to `goal`, each of a class of its own, the cheapest first. Obstacles count where they are now.
    pub fn explore(
        &mut self,
        start: MapPoint,
        goal: MapPoint,
        obstacles: &[Obstacle],
        how: &Exploring,
    ) -> Vec<Way> {
        let grid = window(start, goal, how);
        self.lay_costs(&grid, obstacles, how);
        self.lean(&grid, start, goal);
        self.find_clumps(&grid);
        let line = Segment::new(start, goal);
        let off = |clump: &MapPoint| line.nearest_point(*clump).point.distance(*clump);
        keep_nearest(&mut self.clumps.standing, MOST_CLUMPS, off);
        let (Some(from), Some(to)) = (self.free_near(&grid, start), self.free_near(&grid, goal)) else {
            return Vec::new();
        };
        let found = self.search(&grid, from, to, how);
        found.into_iter().map(|end| self.way(&grid, end, start, goal)).collect()
    }

    fn lay_costs(&mut self, grid: &GridGeometry, obstacles: &[Obstacle], how: &Exploring) {
        self.costs.clear();
        self.costs.resize(grid.len(), how.comfort);
        for obstacle in obstacles {
            let (middle, reach) = (obstacle.middle(), obstacle.radius() + how.comfort);
            let low = MapPoint::new(middle.x - reach, middle.y - reach);
            let high = MapPoint::new(middle.x + reach, middle.y + reach);
            let Some((columns, rows)) = grid.window(low, high) else { continue };
            for row in rows.0..=rows.1 {
                for cell in (columns.0..=columns.1).filter_map(|column| grid.cell_in(column, row)) {
                    let distance = obstacle.distance_to(grid.center(cell));
                    self.costs[cell] = self.costs[cell].min(distance);
                }
            }
        }
        // A way between the middles of cells may miss the middle of a gap by half a cell.
        let keep = how.keep - 0.5 * grid.cell;
        for value in &mut self.costs {
            let near = (how.comfort - *value) / (how.comfort - keep);
            *value = if *value < keep { f64::INFINITY } else { 1.0 + 2.0 * near * near };
        }
    }

    /// Makes cells a little dearer the further they are from the straight line: of the many ways over a grid that cost the same, one is left, and its mirror image in the mirrored scene.
    fn lean(&mut self, grid: &GridGeometry, start: MapPoint, goal: MapPoint) {
        let length = start.distance(goal).max(grid.cell);
        let (east, north) = ((goal.x - start.x) / length, (goal.y - start.y) / length);
        for (cell, cost) in self.costs.iter_mut().enumerate() {
            let at = grid.center(cell);
            *cost += LEAN * ((at.x - start.x) * north - (at.y - start.y) * east).abs();
        }
    }

    /// One point in each connected set of cells where the robot does not fit; a little off the middles of cells, so that no step begins or ends on a ray.
    fn find_clumps(&mut self, grid: &GridGeometry) {
        self.clumps.standing.clear();
        self.closed.clear();
        self.closed.resize(grid.len(), NOWHERE);
        let mut open = Vec::new();
        for first in 0..grid.len() {
            if self.costs[first].is_finite() || self.closed[first] != NOWHERE {
                continue;
            }
            let mut members = 0;
            let mut middle = (0.0, 0.0);
            self.closed[first] = 0;
            open.push(first);
            let seen = self.reached.len();
            while let Some(cell) = open.pop() {
                let (x, y) = grid.column_row(cell);
                members += 1;
                middle = (middle.0 + x as f64, middle.1 + y as f64);
                self.reached.push(Reached {
                    cell,
                    signature: Signature::default(),
                    cost: 0.0,
                    from: NOWHERE,
                });
                for next in NEIGHBOURS.iter().filter_map(|(dx, dy)| grid.cell_in(x + dx, y + dy)) {
                    if self.costs[next].is_infinite() && self.closed[next] == NOWHERE {
                        self.closed[next] = 0;
                        open.push(next);
                    }
                }
            }
            // The member nearest to the middle: far from where ways pass.
            let middle = (middle.0 / f64::from(members), middle.1 / f64::from(members));
            let away = |r: &Reached| {
                let (x, y) = grid.column_row(r.cell);
                let (dx, dy) = (x as f64 - middle.0, y as f64 - middle.1);
                dx * dx + dy * dy
            };
            let nearest = self.reached[seen..].iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let at = grid.center(nearest.map_or(first, |r| r.cell));
            self.clumps.standing.push(MapPoint::new(at.x + 0.1 * grid.cell, at.y));
        }
        self.reached.clear();
    }

    fn free_near(&self, grid: &GridGeometry, point: MapPoint) -> Option<usize> {
        const ESCAPE: f64 = 0.5;
        let here = grid.cell_at(point)?;
        if self.costs[here].is_finite() {
            return Some(here);
        }
        let low = MapPoint::new(point.x - ESCAPE, point.y - ESCAPE);
        let high = MapPoint::new(point.x + ESCAPE, point.y + ESCAPE);
        let (columns, rows) = grid.window(low, high)?;
        let cells = (rows.0..=rows.1).flat_map(|r| (columns.0..=columns.1).map(move |c| (c, r)));
        let free = cells.filter_map(|(c, r)| grid.cell_in(c, r)).filter(|&c| self.costs[c].is_finite());
        free.min_by(|&a, &b| grid.center(a).distance(point).total_cmp(&grid.center(b).distance(point)))
    }

    /// Entries of `reached` at the goal, of a class of its own each.
    fn search(&mut self, grid: &GridGeometry, from: usize, to: usize, how: &Exploring) -> Vec<u32> {
        self.closed.fill(NOWHERE);
        self.closed_before.clear();
        self.opened.clear();
        self.opened.resize(grid.len(), NOWHERE);
        self.opened_before.clear();
        self.crossings.lay(grid, &self.clumps.standing);
        let estimate = |cell: usize| {
            let ((x, y), (u, v)) = (grid.column_row(cell), grid.column_row(to));
            let (dx, dy) = ((x - u).abs() as f64, (y - v).abs() as f64);
            dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
        };
        let mut queue = Frontier::default();
        self.reached.push(Reached { cell: from, signature: Signature::default(), cost: 0.0, from: NOWHERE });
        self.closed_before.push(NOWHERE);
        self.opened_before.push(NOWHERE);
        queue.push(estimate(from), 0);
        let mut found = Vec::new();
        let mut limit = f64::INFINITY;
        while let Some((total, entry)) = queue.pop() {
            if total > limit || found.len() == how.most {
                break;
            }
            let here = self.reached[entry];
            if !self.close(entry, how.most) {
                continue;
            }
            if here.cell == to {
                found.push(entry as u32);
                limit = limit.min(how.longest * here.cost + 1.0 / grid.cell);
                continue;
            }
            self.expand(grid, entry, |cost, cell, entry| queue.push(cost + estimate(cell), entry));
        }
        found
    }

    /// Whether the entry is the first of its class at its cell, and not one of too many.
    fn close(&mut self, entry: usize, most: usize) -> bool {
        let here = self.reached[entry];
        let mut other = self.closed[here.cell];
        let mut classes = 0;
        while other != NOWHERE {
            classes += 1;
            if self.reached[other as usize].signature == here.signature || classes == most {
                return false;
            }
            other = self.closed_before[other as usize];
        }
        self.closed_before[entry] = self.closed[here.cell];
        self.closed[here.cell] = entry as u32;
        true
    }

    fn expand(&mut self, grid: &GridGeometry, entry: usize, mut open: impl FnMut(f64, usize, usize)) {
        let here = self.reached[entry];
        let (x, y) = grid.column_row(here.cell);
        let at = grid.center(here.cell);
        let mut free = [false; 4];
        for (k, (dx, dy)) in NEIGHBOURS.iter().enumerate() {
            // A diagonal runs between two cells, which must both be free.
            if k >= 4 && !(free[k - 4] && free[(k - 3) % 4]) {
                continue;
            }
            let Some(cell) = grid.cell_in(x + dx, y + dy).filter(|&c| self.costs[c].is_finite()) else {
                continue;
            };
            let length = if k < 4 { 1.0 } else { std::f64::consts::SQRT_2 };
            if k < 4 {
                free[k] = true;
            }
            let crossed = self.crossings.between(x, x + dx).iter();
            let signature = crossed.fold(here.signature, |signature, &i| {
                signature.wound(i, self.clumps.standing[i], at, grid.center(cell))
            });
            if self.is_closed(cell, signature) {
                continue;
            }
            let cost = here.cost + length * 0.5 * (self.costs[here.cell] + self.costs[cell]);
            if self.is_open(cell, signature, cost) {
                continue;
            }
            self.reached.push(Reached { cell, signature, cost, from: entry as u32 });
            self.closed_before.push(NOWHERE);
            let new = self.reached.len() - 1;
            self.opened_before.push(std::mem::replace(&mut self.opened[cell], new as u32));
            open(cost, cell, new);
        }
    }

    /// Whether a way of the class to the cell is open that is no dearer: it will be closed first.
    fn is_open(&self, cell: usize, signature: Signature, cost: f64) -> bool {
        let mut other = self.opened[cell];
        while other != NOWHERE {
            let Reached { signature: its, cost: its_cost, .. } = self.reached[other as usize];
            // The last of a class is the cheapest of it.
            if its == signature {
                return its_cost <= cost;
            }
            other = self.opened_before[other as usize];
        }
        false
    }

    fn is_closed(&self, cell: usize, signature: Signature) -> bool {
        let mut other = self.closed[cell];
        while other != NOWHERE {
            if self.reached[other as usize].signature == signature {
                return true;
            }
            other = self.closed_before[other as usize];
        }
        false
    }

    fn way(&self, grid: &GridGeometry, end: u32, start: MapPoint, goal: MapPoint) -> Way {
        let mut cells = Vec::new();
        let mut at = end;
        while at != NOWHERE {
            cells.push(self.reached[at as usize].cell);
            at = self.reached[at as usize].from;
        }
        cells.reverse();
        let end = self.reached[end as usize];
        let corners = self.straighten(grid, &cells);
        let inner = corners[1..corners.len().max(2) - 1].iter().map(|&c| grid.center(c));
        let corners = std::iter::once(start).chain(inner).chain([goal]).collect();
        Way { corners, signature: end.signature, cost: end.cost * grid.cell }
    }

    /// Leaves out cells where a straight line is of the same class and no dearer.
    fn straighten(&self, grid: &GridGeometry, cells: &[usize]) -> Vec<usize> {
        let mut kept = vec![cells[0]];
        let mut at = 0;
        while at + 1 < cells.len() {
            let mut next = at + 1;
            let mut dearest = self.costs[cells[next]];
            for candidate in at + 2..cells.len() {
                dearest = dearest.max(self.costs[cells[candidate]]);
                let no_dearer = |c: usize| self.costs[c] <= dearest + 0.3;
                let same_class = || {
                    let along =
                        self.clumps.signature(cells[at..=candidate].iter().map(|&c| (grid.center(c), 0.0)));
                    let ends = [cells[at], cells[candidate]].map(|c| (grid.center(c), 0.0));
                    along == self.clumps.signature(ends.into_iter())
                };
                if !in_sight(grid, no_dearer, cells[at], cells[candidate]) || !same_class() {
                    break;
                }
                next = candidate;
            }
            kept.push(cells[next]);
            at = next;
        }
        kept
    }
}

/// Columns and rows to the neighbours of a cell; each diagonal lies between two of the first four.
const NEIGHBOURS: [(i64, i64); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Start and goal and the ground around them, in the middle of the cells: mirrored scenes have mirrored cells.
fn window(start: MapPoint, goal: MapPoint, how: &Exploring) -> GridGeometry {
    let (width, height) = ((goal.x - start.x).abs(), (goal.y - start.y).abs());
    let side = width.max(height) + 2.0 * how.around;
    let cell = how.cell.max(side / MOST_CELLS as f64);
    let count = |length: f64| (((length + 2.0 * how.around) / cell).ceil() as usize).clamp(1, MOST_CELLS + 1);
    let (columns, rows) = (count(width), count(height));
    let middle = MapPoint::new((start.x + goal.x) / 2.0, (start.y + goal.y) / 2.0);
    let origin = MapPoint::new(middle.x - columns as f64 * cell / 2.0, middle.y - rows as f64 * cell / 2.0);
    GridGeometry { origin, width: columns, height: rows, cell }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64) -> MapPoint {
        MapPoint::new(x, y)
    }

    fn stones(at: &[(f64, f64)]) -> Vec<Obstacle> {
        at.iter().map(|(x, y)| Obstacle::disc(point(*x, *y), 0.2).unwrap()).collect()
    }

    #[test]
    fn one_stone_has_two_sides_and_two_apart_have_four() {
        let mut explorer = Explorer::default();
        let how = Exploring::default();
        let ways = explorer.explore(point(0.0, 0.0), point(4.0, 0.0), &stones(&[(2.0, 0.1)]), &how);
        assert_eq!(ways.len(), 2);
        let side = |way: &Way| {
            way.corners.iter().map(|c| c.y).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
        };
        assert!(side(&ways[0]) < -0.1 && side(&ways[1]) > 0.1, "{ways:?}");
        let ways =
            explorer.explore(point(0.0, 0.0), point(4.0, 0.0), &stones(&[(1.3, 0.0), (2.7, 0.0)]), &how);
        assert_eq!(ways.len(), 4);
        assert!(ways.windows(2).all(|w| w[0].cost <= w[1].cost));
    }

    #[test]
    fn of_many_stones_those_near_the_line_are_told_apart() {
        let aside =
            (0..14).flat_map(|i| (0..4).map(move |k| (0.6 * f64::from(i) - 3.0, 0.5 * f64::from(k) - 2.9)));
        let at: Vec<(f64, f64)> = aside.chain([(2.0, 0.1)]).collect();
        let (start, goal) = (point(0.0, 0.0), point(4.0, 0.0));
        let how = Exploring { around: 3.0, most: 2, ..Exploring::default() };
        let small: Vec<Obstacle> =
            at.iter().map(|(x, y)| Obstacle::disc(point(*x, *y), 0.02).unwrap()).collect();
        let ways = Explorer::default().explore(start, goal, &small, &how);
        let highest = |way: &Way| way.corners.iter().map(|c| c.y).fold(-9.0, f64::max);
        let heights: Vec<f64> = ways.iter().map(highest).collect();
        assert!(heights.iter().any(|y| *y > 0.2) && heights.iter().any(|y| *y < 0.1), "{heights:?}");
        assert!(heights.len() == 2 && ways[1].cost < 1.3 * ways[0].cost, "{ways:?}");
    }

    #[test]
    fn stones_too_near_each_other_are_one() {
        let near = stones(&[(2.0, 0.0), (2.0, 0.5), (2.0, -0.5)]);
        let ways =
            Explorer::default().explore(point(0.0, 0.0), point(4.0, 0.0), &near, &Exploring::default());
        assert_eq!(ways.len(), 2);
    }

    #[test]
    fn behind_a_closed_wall_there_is_no_way() {
        let wall = [Obstacle::wall(point(2.0, -20.0), point(2.0, 20.0)).unwrap()];
        let ways =
            Explorer::default().explore(point(0.0, 0.0), point(4.0, 0.0), &wall, &Exploring::default());
        assert!(ways.is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        // As far from the line as leaves a way along the edge of the window: further out, a row of them can close it.
        #[test]
        fn ways_have_ends_signatures_of_their_own_and_keep_off_stones(at in prop::collection::vec((0.8..3.2_f64, -1.1..1.1_f64), 0..12)) {
            let (start, goal) = (point(0.0, 0.0), point(4.0, 0.0));
            let (stones, how) = (stones(&at), Exploring::default());
            let mut explorer = Explorer::default();
            let ways = explorer.explore(start, goal, &stones, &how);
            prop_assert!(!ways.is_empty() && ways.len() <= how.most);
            for (i, way) in ways.iter().enumerate() {
                prop_assert_eq!((way.corners[0], way.corners[way.corners.len() - 1]), (start, goal));
                prop_assert_eq!(explorer.clumps().signature(way.corners.iter().map(|c| (*c, 0.0))), way.signature);
                prop_assert!(ways[..i].iter().all(|other| other.signature != way.signature));
                for pair in way.corners.windows(2) {
                    for k in 0..=20 {
                        let t = f64::from(k) / 20.0;
                        let p = point(pair[0].x + t * (pair[1].x - pair[0].x), pair[0].y + t * (pair[1].y - pair[0].y));
                        let clear = stones.iter().map(|s| s.distance_to(p)).fold(f64::INFINITY, f64::min);
                        prop_assert!(clear > how.keep - 0.15, "{clear} at {p}");
                    }
                }
            }
        }
    }
}
