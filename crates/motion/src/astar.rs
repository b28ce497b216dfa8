//! The cheapest way over a costmap, by [`crate::search`]; then shortened wherever a straight line costs no more.

use openbench_core::MapPoint;
use openbench_grid::{Frontier, in_sight};

use crate::costmap::Costmap;
use crate::search::Search;

/// How far from a blocked start or goal a free cell is looked for, metres.
const ESCAPE: f64 = 1.5;

/// Why there is no way.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The start is outside the costmap or hemmed in.
    #[error("no free ground near the start {0}")]
    StartBlocked(MapPoint),
    /// The goal is outside the costmap or hemmed in.
    #[error("no free ground near the goal {0}")]
    GoalBlocked(MapPoint),
    /// Start and goal do not hang together.
    #[error("no way from {0} to {1}")]
    NoWay(MapPoint, MapPoint),
}

/// The cheapest way from `start` to `goal`. Where one of them is blocked, the nearest free cell within 1.5 m stands for
/// it; the way then begins or ends there. `search` holds buffers that are used again.
pub fn plan(
    search: &mut Search,
    costmap: &Costmap,
    start: MapPoint,
    goal: MapPoint,
) -> Result<Vec<MapPoint>, PlanError> {
    let from = free_cell(costmap, start).ok_or(PlanError::StartBlocked(start))?;
    let to = free_cell(costmap, goal).ok_or(PlanError::GoalBlocked(goal))?;
    let (_, cells) = search.cheapest(&costmap.costs(), from, to).ok_or(PlanError::NoWay(start, goal))?;
    let mut points: Vec<MapPoint> =
        shorten(costmap, &cells).iter().map(|c| costmap.grid().center(*c)).collect();
    if costmap.grid().cell_at(goal) == Some(to) {
        points.pop();
        points.push(goal);
    }
    points.insert(0, start);
    Ok(points)
}

/// Cost of the cheapest way from `start` to each of `goals`, in metres of open ground; `None` beyond `limit` or where there is no
/// way. One search for all of them (Dijkstra).
pub fn costs(costmap: &Costmap, start: MapPoint, goals: &[MapPoint], limit: f64) -> Vec<Option<f64>> {
    let grid = costmap.grid();
    let cells: Vec<Option<usize>> = goals.iter().map(|g| free_cell(costmap, *g)).collect();
    let Some(from) = free_cell(costmap, start) else { return vec![None; goals.len()] };
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
        if std::mem::replace(&mut closed[cell], true) {
            continue;
        }
        open.retain(|&goal| goal != cell);
        for (next, length) in neighbours(costmap, cell) {
            if closed[next] {
                continue;
            }
            let total = best[cell] + length * 0.5 * (cost_of(costmap, cell) + cost_of(costmap, next));
            if total < best[next] {
                best[next] = total;
                queue.push(total, next);
            }
        }
    }
    cells.iter().map(|cell| cell.filter(|&c| closed[c]).map(|c| best[c] * grid.cell)).collect()
}

fn free_cell(costmap: &Costmap, point: MapPoint) -> Option<usize> {
    let grid = costmap.grid();
    let here = grid.cell_at(point)?;
    if costmap.cost(here).is_some() {
        return Some(here);
    }
    let low = MapPoint::new(point.x - ESCAPE, point.y - ESCAPE);
    let high = MapPoint::new(point.x + ESCAPE, point.y + ESCAPE);
    let (columns, rows) = grid.window(low, high)?;
    let cells = (rows.0..=rows.1).flat_map(|r| (columns.0..=columns.1).map(move |c| (c, r)));
    cells
        .filter_map(|(c, r)| grid.cell_in(c, r))
        .filter(|&c| costmap.cost(c).is_some() && grid.center(c).distance(point) <= ESCAPE)
        .min_by(|&a, &b| grid.center(a).distance(point).total_cmp(&grid.center(b).distance(point)))
}

/// Neighbours of a cell with their distances in cells; diagonals only between two free sides.
fn neighbours(costmap: &Costmap, cell: usize) -> impl Iterator<Item = (usize, f64)> {
    let grid = *costmap.grid();
    let (x, y) = grid.column_row(cell);
    let free = move |dx: i64, dy: i64| grid.cell_in(x + dx, y + dy).filter(|&c| costmap.cost(c).is_some());
    let straight = [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter();
    let diagonal = [(-1, -1), (1, -1), (-1, 1), (1, 1)].into_iter();
    let straight = straight.filter_map(move |(dx, dy)| Some((free(dx, dy)?, 1.0)));
    let diagonal = diagonal.filter_map(move |(dx, dy)| {
        free(dx, 0)?;
        free(0, dy)?;
        Some((free(dx, dy)?, std::f64::consts::SQRT_2))
    });
    straight.chain(diagonal)
}

/// Replaces stretches by straight lines that stay where it costs no more than on the stretch.
fn shorten(costmap: &Costmap, cells: &[usize]) -> Vec<usize> {
    let mut kept = vec![cells[0]];
    let mut at = 0;
    while at + 1 < cells.len() {
        let mut next = at + 1;
        let mut dearest = cost_of(costmap, cells[next]);
        // Straight lines longer than 60 cells gain nothing worth their checking.
        for candidate in at + 2..cells.len().min(at + 60) {
            dearest = dearest.max(cost_of(costmap, cells[candidate]));
            let no_dearer = |c: usize| cost_of(costmap, c) <= dearest + 0.2;
            if !in_sight(costmap.grid(), no_dearer, cells[at], cells[candidate]) {
                break;
            }
            next = candidate;
        }
        kept.push(cells[next]);
        at = next;
    }
    kept
}

fn cost_of(costmap: &Costmap, cell: usize) -> f64 {
    costmap.cost(cell).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::costmap::tests::{open_ground, see_wall};

    fn length(path: &[MapPoint]) -> f64 {
        path.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    #[test]
    fn open_ground_is_crossed_straight() {
        let (a, b) = (MapPoint::new(-8.0, -3.0), MapPoint::new(7.0, 2.0));
        let path = plan(&mut Search::default(), &open_ground(), a, b).unwrap();
        assert_eq!((path[0], *path.last().unwrap()), (a, b));
        assert!(length(&path) < a.distance(b) * 1.05, "{}", length(&path));
    }

    #[test]
    fn a_wall_is_passed_with_room_to_spare() {
        let mut costmap = open_ground();
        see_wall(&mut costmap, MapPoint::new(2.0, -5.0), MapPoint::new(2.0, 1.0));
        let path = plan(&mut Search::default(), &costmap, MapPoint::new(0.0, -2.0), MapPoint::new(4.0, -2.0))
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
    fn a_blocked_goal_is_approached_and_a_buried_one_refused() {
        let mut costmap = open_ground();
        see_wall(&mut costmap, MapPoint::new(2.0, -5.0), MapPoint::new(2.0, 5.0));
        let path =
            plan(&mut Search::default(), &costmap, MapPoint::new(0.0, 0.0), MapPoint::new(2.0, 0.0)).unwrap();
        assert!(path.last().unwrap().distance(MapPoint::new(2.0, 0.0)) < 0.4);
        let outside = MapPoint::new(50.0, 0.0);
        assert_eq!(
            plan(&mut Search::default(), &costmap, MapPoint::default(), outside),
            Err(PlanError::GoalBlocked(outside))
        );
    }

    #[test]
    fn costs_to_many_places_are_those_of_the_ways_to_each() {
        let mut costmap = open_ground();
        see_wall(&mut costmap, MapPoint::new(2.0, -5.0), MapPoint::new(2.0, 5.0));
        let goals = [MapPoint::new(-4.0, 0.0), MapPoint::new(4.0, 0.0), MapPoint::new(99.0, 0.0)];
        let costs = costs(&costmap, MapPoint::default(), &goals, 50.0);
        assert!((costs[0].unwrap() - 4.0).abs() < 0.5, "{costs:?}");
        assert!(costs[1].unwrap() > 10.0 && costs[2].is_none(), "{costs:?}");
    }

    #[test]
    fn a_closed_yard_has_no_way_out() {
        let mut costmap = open_ground();
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(x, y)| MapPoint::new(x, y));
        for pair in corners.windows(2) {
            see_wall(&mut costmap, pair[0], pair[1]);
        }
        let result = plan(&mut Search::default(), &costmap, MapPoint::default(), MapPoint::new(5.0, 5.0));
        assert!(matches!(result, Err(PlanError::NoWay(..))), "{result:?}");
    }
}
