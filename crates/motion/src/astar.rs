//! The cheapest path over a costmap by [`crate::search`], then shortened wherever a straight line
//! in any direction costs no more.

use openbench_core::MapPoint;
use openbench_geometry::grid::{Frontier, in_sight, passes_all};

use crate::costmap::Costmap;
use crate::search::Search;

/// How far from a blocked start or goal a free cell is searched, metres.
const ESCAPE_M: f64 = 1.5;
/// Free cells that may replace a blocked place, at most.
const MOST_ESCAPES: usize = 4096;
/// Closed areas that a blocked start may lie between, at most.
const CLOSED_AREAS: usize = 4;
/// Costs that differ by less are equal, in sides of cells.
const ROUNDING: f64 = 1e-6;

/// Why there is no path.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The start is outside the costmap.
    #[error("the start {0} is outside the costmap")]
    StartOutside(MapPoint),
    /// The goal is outside the costmap.
    #[error("the goal {0} is outside the costmap")]
    GoalOutside(MapPoint),
    /// No free cell is near the start.
    #[error("no free ground within {ESCAPE_M} m of the start {0}")]
    StartBlocked(MapPoint),
    /// No free cell is near the goal.
    #[error("no free ground within {ESCAPE_M} m of the goal {0}")]
    GoalBlocked(MapPoint),
    /// Start and goal are not connected.
    #[error("no path from {0} to {1}")]
    NoPath(MapPoint, MapPoint),
}

/// The cheapest path from `start` to `goal`, in `map`.
///
/// A blocked end is replaced by the nearest free cell within 1.5 m from which the other end can be
/// reached. No obstacle may lie in between, unless the place is deep inside one. The path begins at
/// `start` all the same. `search` holds buffers that are used again.
///
/// ```
/// use openbench_core::{Georeference, LonLat, MapPoint, RobotDescription};
/// use openbench_motion::{Costmap, RangeRing, ScanPoint, Search, plan};
/// use openbench_osm::{OsmData, OsmMap};
///
/// // An empty map near Heidelberg, and a wall of 6 m that the LiDAR sees between two places.
/// let heidelberg = Georeference::tangent_plane(LonLat::new(8.69, 49.41));
/// let map = OsmMap::new(&OsmData::default(), heidelberg);
/// let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
/// let mut costmap = Costmap::new(&map, low, high, &RobotDescription::sentry())?;
/// let wall = (-60..=60).map(|i| ScanPoint::new(MapPoint::new(2.0, f64::from(i) / 20.0), 0.3));
/// costmap.observe(&RangeRing::new(MapPoint::default(), 0.25, wall));
/// costmap.inflate();
///
/// let (start, goal) = (MapPoint::default(), MapPoint::new(4.0, 0.0));
/// let path = plan(&mut Search::default(), &costmap, start, goal)?;
/// let length: f64 = path.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
/// assert!(length > 7.0, "around the wall, instead of 4 m");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn plan(
    search: &mut Search,
    costmap: &Costmap,
    start: MapPoint,
    goal: MapPoint,
) -> Result<Vec<MapPoint>, PlanError> {
    let (from, to) = (free_cells(costmap, start), free_cells(costmap, goal));
    let from = from.ok_or(PlanError::StartOutside(start))?;
    let to = to.ok_or(PlanError::GoalOutside(goal))?;
    if from.is_empty() {
        return Err(PlanError::StartBlocked(start));
    }
    if to.is_empty() {
        return Err(PlanError::GoalBlocked(goal));
    }
    let cells = connect(search, costmap, from, &to).ok_or(PlanError::NoPath(start, goal))?;
    let mut points: Vec<MapPoint> = shorten(costmap, &cells)
        .iter()
        .map(|c| costmap.grid().center(*c))
        .collect();
    // The goal itself replaces the middle of its cell. Where it is blocked, the path ends at a free
    // cell near it.
    if costmap.grid().cell_at(goal) == cells.last().copied() {
        points.pop();
        points.push(goal);
    }
    // The middle of the first cell stays: the lines that were checked run between middles.
    points.insert(0, start);
    Ok(points)
}

/// The cheapest path between the first of some cells and the first of others that are connected.
fn connect(
    search: &mut Search,
    costmap: &Costmap,
    from: Vec<usize>,
    to: &[usize],
) -> Option<Vec<usize>> {
    let (costs, mut from) = (costmap.costs(), from);
    for _ in 0..CLOSED_AREAS {
        let start = *from.first()?;
        let found = search.cheapest(&costs, start, to[0]).or_else(|| {
            // The nearest goal cell is not connected with the start, but another one may be.
            let reached = to.iter().copied().find(|cell| search.reached(*cell))?;
            search.cheapest(&costs, start, reached)
        });
        if let Some(found) = found {
            return Some(found.cells);
        }
        // The search has reached the whole area of its start, and none of `to` is in it. So no
        // other start in that area needs to be tried.
        from.retain(|cell| !search.reached(*cell));
    }
    None
}

/// Cost of the cheapest path from `start` to each of `goals`, in metres of open ground; `None`
/// beyond `limit` metres or where there is no path. One search for all of them (Dijkstra).
pub fn costs(
    costmap: &Costmap,
    start: MapPoint,
    goals: &[MapPoint],
    limit: f64,
) -> Vec<Option<f64>> {
    let grid = costmap.grid();
    let cells: Vec<Option<usize>> = goals.iter().map(|g| free_cell(costmap, *g)).collect();
    let Some(from) = free_cell(costmap, start) else {
        return vec![None; goals.len()];
    };
    let mut best = vec![f64::INFINITY; grid.len()];
    let mut closed = vec![false; grid.len()];
    let mut queue = Frontier::default();
    queue.push(0.0, from);
    let mut open: Vec<usize> = cells.iter().flatten().copied().collect();
    best[from] = 0.0;
    while let Some((estimate, cell)) = queue.pop() {
        if open.is_empty() || estimate * grid.cell > limit {
            break;
        }
        // A cell that became cheaper is in the queue again; its first entry to come out is the
        // cheapest.
        if std::mem::replace(&mut closed[cell], true) {
            continue;
        }
        open.retain(|&goal| goal != cell);
        for Neighbour { cell: next, length } in neighbours(costmap, cell) {
            if closed[next] {
                continue;
            }
            let total =
                best[cell] + length * 0.5 * (cost_of(costmap, cell) + cost_of(costmap, next));
            if total < best[next] {
                best[next] = total;
                queue.push(total, next);
            }
        }
    }
    cells
        .iter()
        // Only a closed cell has its final cost.
        .map(|cell| cell.filter(|&c| closed[c]).map(|c| best[c] * grid.cell))
        .collect()
}

/// A free cell near a blocked place.
struct Escape {
    cell: usize,
    /// Metres.
    distance: f64,
}

/// The cell of a place or the nearest free one.
fn free_cell(costmap: &Costmap, point: MapPoint) -> Option<usize> {
    free_cells(costmap, point)?.first().copied()
}

/// The cell of a place or, if it is blocked, the free cells within 1.5 m, the nearest first; `None`
/// outside the costmap.
///
/// Cells behind an obstacle are left out, unless there are no others.
fn free_cells(costmap: &Costmap, point: MapPoint) -> Option<Vec<usize>> {
    let grid = costmap.grid();
    let here = grid.cell_at(point)?;
    if costmap.cost(here).is_some() {
        return Some(vec![here]);
    }
    let low = MapPoint::new(point.x - ESCAPE_M, point.y - ESCAPE_M);
    let high = MapPoint::new(point.x + ESCAPE_M, point.y + ESCAPE_M);
    let free = grid
        .cells_between(low, high)
        .filter(|&cell| costmap.cost(cell).is_some());
    let mut near: Vec<Escape> = free
        .map(|cell| Escape {
            cell,
            distance: grid.center(cell).distance(point),
        })
        .collect();
    near.retain(|escape| escape.distance <= ESCAPE_M);
    near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    near.truncate(MOST_ESCAPES);
    let near: Vec<usize> = near.into_iter().map(|escape| escape.cell).collect();
    // The place itself is blocked; every line of sight begins in it.
    let is_open = |cell: usize| cell == here || !costmap.is_obstacle(cell);
    // Free cells behind a wall do not count; deep inside an obstacle any free cell does.
    let open: Vec<usize> = near
        .iter()
        .copied()
        .filter(|cell| in_sight(grid, is_open, here, *cell))
        .collect();
    Some(if open.is_empty() { near } else { open })
}

/// A free cell beside another.
struct Neighbour {
    cell: usize,
    /// Distance of their middles, sides of cells.
    length: f64,
}

/// Free neighbours of a cell; diagonals only between two free cells.
fn neighbours(costmap: &Costmap, cell: usize) -> impl Iterator<Item = Neighbour> {
    let (x, y) = costmap.grid().column_row(cell);
    let straight = [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter();
    let straight = straight.filter_map(move |(dx, dy)| {
        Some(Neighbour {
            cell: free_in(costmap, x + dx, y + dy)?,
            length: 1.0,
        })
    });
    let diagonal = [(-1, -1), (1, -1), (-1, 1), (1, 1)].into_iter();
    let diagonal = diagonal.filter_map(move |(dx, dy)| {
        free_in(costmap, x + dx, y)?;
        free_in(costmap, x, y + dy)?;
        Some(Neighbour {
            cell: free_in(costmap, x + dx, y + dy)?,
            length: std::f64::consts::SQRT_2,
        })
    });
    straight.chain(diagonal)
}

/// The cell in a column and row, if it is free.
fn free_in(costmap: &Costmap, column: i64, row: i64) -> Option<usize> {
    let cell = costmap.grid().cell_in(column, row);
    cell.filter(|&cell| costmap.cost(cell).is_some())
}

/// Replaces stretches by straight lines that cost no more than the stretch.
fn shorten(costmap: &Costmap, cells: &[usize]) -> Vec<usize> {
    let mut kept = vec![cells[0]];
    let mut at = 0;
    while at + 1 < cells.len() {
        let mut next = at + 1;
        let mut stretch = line_cost(costmap, cells[at], cells[next]);
        // A path over a grid runs straight for long and turns by 45 degrees: only a line over all
        // of it saves the detour.
        let mut seen = next;
        for candidate in lengths()
            .map(|length| at + length)
            .take_while(|end| *end < cells.len())
        {
            let steps = cells[seen..=candidate].windows(2);
            stretch += steps
                .map(|pair| line_cost(costmap, pair[0], pair[1]))
                .sum::<f64>();
            seen = candidate;
            if line_cost(costmap, cells[at], cells[candidate]) > stretch + ROUNDING {
                break;
            }
            next = candidate;
        }
        kept.push(cells[next]);
        at = next;
    }
    kept
}

/// Numbers of cells after which a straight line is tried, from two on: each up to 32, then each
/// longer by a sixteenth, so that long lines take no longer to try than short ones.
fn lengths() -> impl Iterator<Item = usize> {
    std::iter::successors(Some(2), |length: &usize| {
        Some(length + (length / 16).max(1))
    })
}

/// Cost of the straight line between the middles of two cells, in sides of cells: of each cell that
/// it passes, by its length there.
fn line_cost(costmap: &Costmap, from: usize, to: usize) -> f64 {
    let (mut mean, costs) = (0.0, costmap.costs());
    let is_free = passes_all(costmap.grid(), from, to, |cell, share| {
        let cost = costs.of(cell);
        let is_free = cost < f32::INFINITY;
        mean += if is_free {
            share * f64::from(cost)
        } else {
            0.0
        };
        is_free
    });
    let ((x, y), (u, v)) = (
        costmap.grid().column_row(from),
        costmap.grid().column_row(to),
    );
    if is_free {
        mean * libm::hypot((u - x) as f64, (v - y) as f64)
    } else {
        f64::INFINITY
    }
}

/// Cost of a cell, infinite where the robot does not fit.
fn cost_of(costmap: &Costmap, cell: usize) -> f64 {
    costmap.cost(cell).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::Preferences;
    use crate::costmap::map_server::Occupancy;
    use crate::costmap::tests::{empty_map, open_ground, see_wall};
    use crate::search::GridPath;
    use openbench_core::RobotDescription;
    use openbench_geometry::Polygon;
    use openbench_geometry::grid::GridGeometry;
    use openbench_osm::{Area, ElementId, ElementKind, Road};
    use proptest::prelude::*;

    fn length(path: &[MapPoint]) -> f64 {
        path.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    #[test]
    fn open_ground_is_crossed_straight() {
        let (a, b) = (MapPoint::new(-8.0, -3.0), MapPoint::new(7.0, 2.0));
        let path = plan(&mut Search::default(), &open_ground(), a, b).unwrap();
        assert_eq!((path[0], *path.last().unwrap()), (a, b));
        assert!(length(&path) < a.distance(b) * 1.005, "{}", length(&path));
    }

    #[test]
    fn a_wall_is_passed_at_a_distance() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -5.0),
            MapPoint::new(2.0, 1.0),
        );
        let path = plan(
            &mut Search::default(),
            &costmap,
            MapPoint::new(0.0, -2.0),
            MapPoint::new(4.0, -2.0),
        )
        .unwrap();
        for pair in path.windows(2) {
            for i in 0..=20 {
                let t = f64::from(i) / 20.0;
                let p = MapPoint::new(
                    pair[0].x + t * (pair[1].x - pair[0].x),
                    pair[0].y + t * (pair[1].y - pair[0].y),
                );
                assert!(costmap.clearance_at(p) >= costmap.keep() - 0.08, "{p}");
            }
        }
    }

    #[test]
    fn a_blocked_goal_is_approached_and_one_outside_refused() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -5.0),
            MapPoint::new(2.0, 5.0),
        );
        let path = plan(
            &mut Search::default(),
            &costmap,
            MapPoint::new(0.0, 0.0),
            MapPoint::new(2.0, 0.0),
        )
        .unwrap();
        assert!(path.last().unwrap().distance(MapPoint::new(2.0, 0.0)) < 0.4);
        let outside = MapPoint::new(50.0, 0.0);
        assert_eq!(
            plan(
                &mut Search::default(),
                &costmap,
                MapPoint::default(),
                outside
            ),
            Err(PlanError::GoalOutside(outside))
        );
    }

    #[test]
    fn pavements_are_preferred_to_grass_on_request() {
        let mut map = empty_map();
        let corners =
            [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| MapPoint::new(x, y));
        map.areas.push(Area {
            element: ElementId {
                kind: ElementKind::Way,
                id: 1,
            },
            polygon: Polygon::new(corners.to_vec(), vec![]).unwrap(),
            tags: [("landuse", "grass")].into_iter().collect(),
        });
        let bend =
            [(-6.0, 0.0), (-6.0, 2.5), (6.0, 2.5), (6.0, 0.0)].map(|(x, y)| MapPoint::new(x, y));
        let tags = [("highway", "footway")].into_iter().collect();
        map.roads.push(Road {
            way: 2,
            nodes: vec![1, 2, 3, 4],
            points: bend.to_vec(),
            tags,
        });
        let (low, high) = (MapPoint::new(-10.0, -10.0), MapPoint::new(10.0, 10.0));
        let furthest = |preferences: Preferences| {
            let robot = RobotDescription::sentry();
            let costmap = Costmap::with_preferences(&map, low, high, &robot, preferences).unwrap();
            let path = plan(&mut Search::default(), &costmap, bend[0], bend[3]).unwrap();
            path.iter().map(|p| p.y).fold(0.0, f64::max)
        };
        assert!(furthest(Preferences::NONE) < 0.1);
        assert!(furthest(Preferences::default()) > 1.5);
    }

    #[test]
    fn no_path_leads_from_or_to_a_place_deep_inside_an_obstacle() {
        let grid = GridGeometry {
            origin: MapPoint::default(),
            width: 100,
            height: 100,
            cell: 0.1,
        };
        let is_open = |cell: usize| grid.center(cell).x < 4.0;
        let cells = (0..grid.len())
            .map(|cell| if is_open(cell) { 0 } else { 100 })
            .collect();
        let occupancy = Occupancy {
            grid,
            yaw: 0.0,
            cells,
        };
        let costmap = Costmap::from_occupancy(&occupancy, &RobotDescription::sentry()).unwrap();
        let (open, buried) = (MapPoint::new(2.0, 5.0), MapPoint::new(8.0, 5.0));
        let path_of = |from, to| plan(&mut Search::default(), &costmap, from, to);
        assert_eq!(path_of(buried, open), Err(PlanError::StartBlocked(buried)));
        assert_eq!(path_of(open, buried), Err(PlanError::GoalBlocked(buried)));
    }

    #[test]
    fn costs_to_many_places_are_those_of_the_paths_to_each() {
        let mut costmap = open_ground();
        see_wall(
            &mut costmap,
            MapPoint::new(2.0, -5.0),
            MapPoint::new(2.0, 5.0),
        );
        let goals = [
            MapPoint::new(-4.0, 0.0),
            MapPoint::new(4.0, 0.0),
            MapPoint::new(99.0, 0.0),
        ];
        let costs = costs(&costmap, MapPoint::default(), &goals, 50.0);
        assert!((costs[0].unwrap() - 4.0).abs() < 0.5, "{costs:?}");
        assert!(costs[1].unwrap() > 10.0 && costs[2].is_none(), "{costs:?}");
    }

    #[test]
    fn no_path_leads_from_or_to_a_place_that_is_not_finite() {
        let (here, lost) = (MapPoint::default(), MapPoint::new(f64::NAN, 0.0));
        let path_of = |from, to| plan(&mut Search::default(), &open_ground(), from, to);
        assert!(matches!(
            path_of(lost, here),
            Err(PlanError::StartOutside(_))
        ));
        assert!(matches!(
            path_of(here, lost),
            Err(PlanError::GoalOutside(_))
        ));
        assert!(matches!(
            path_of(MapPoint::new(1e300, 0.0), here),
            Err(PlanError::StartOutside(_))
        ));
    }

    /// Ground with a walled yard of 1.4 m by 1.4 m around a place.
    fn yard(middle: MapPoint) -> Costmap {
        let mut costmap = open_ground();
        let corners = [
            (-0.7, -0.7),
            (0.7, -0.7),
            (0.7, 0.7),
            (-0.7, 0.7),
            (-0.7, -0.7),
        ];
        let corners = corners.map(|(x, y)| MapPoint::new(middle.x + x, middle.y + y));
        for pair in corners.windows(2) {
            see_wall(&mut costmap, pair[0], pair[1]);
        }
        costmap
    }

    #[test]
    fn the_replacement_of_a_blocked_place_can_be_reached() {
        let costmap = yard(MapPoint::new(3.0, 0.0));
        // On the yard's wall, a little nearer to the inside.
        let (wall, away) = (MapPoint::new(2.33, 0.0), MapPoint::new(-4.0, 0.0));
        let there = plan(&mut Search::default(), &costmap, away, wall).unwrap();
        assert!(
            there.last().unwrap().x < 2.2 && there.last().unwrap().distance(wall) < 1.0,
            "{there:?}"
        );
        let back = plan(&mut Search::default(), &costmap, wall, away).unwrap();
        assert_eq!((back[0], *back.last().unwrap()), (wall, away));
        assert!(back[1].x < 2.2, "{back:?}");
    }

    proptest! {
        #[test]
        fn straight_lines_cost_no_more_than_the_stretch_that_they_replace(
            walls in prop::collection::vec(
                (-8.0..8.0_f64, -8.0..8.0_f64, -2.0..2.0_f64, -2.0..2.0_f64),
                1..8,
            ),
            (x, y) in (-9.0..9.0_f64, -9.0..9.0_f64),
        ) {
            let mut costmap = open_ground();
            for (x, y, dx, dy) in walls {
                see_wall(&mut costmap, MapPoint::new(x, y), MapPoint::new(x + dx, y + dy));
            }
            let cell = |x: f64, y: f64| costmap.grid().cell_at(MapPoint::new(x, y)).unwrap();
            let (from, to) = (cell(-9.0, -9.0), cell(x, y));
            let found = Search::default().cheapest(&costmap.costs(), from, to);
            let Some(GridPath { cost, cells }) = found else { return Ok(()) };
            let kept = shorten(&costmap, &cells);
            prop_assert_eq!((kept[0], kept.last()), (cells[0], cells.last()));
            let shorter: f64 = kept.windows(2).map(|w| line_cost(&costmap, w[0], w[1])).sum();
            prop_assert!(shorter <= cost + 1e-4 * cells.len() as f64, "{shorter} for {cost}");
            for pair in kept.windows(2) {
                let is_free = |cell: usize| costmap.cost(cell).is_some();
                prop_assert!(in_sight(costmap.grid(), is_free, pair[0], pair[1]));
            }
        }
    }

    #[test]
    fn no_path_leads_out_of_a_closed_yard() {
        let mut costmap = open_ground();
        let corners = [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
        ]
        .map(|(x, y)| MapPoint::new(x, y));
        for pair in corners.windows(2) {
            see_wall(&mut costmap, pair[0], pair[1]);
        }
        let result = plan(
            &mut Search::default(),
            &costmap,
            MapPoint::default(),
            MapPoint::new(5.0, 5.0),
        );
        assert!(matches!(result, Err(PlanError::NoPath(..))), "{result:?}");
    }
}
