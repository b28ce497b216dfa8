//! The ground between the robot and a goal: fine cells that follow the robot nearby, and a corridor
//! beyond.
//!
//! The corridor comes from the map: the cheapest path over its ground, or over its roads where they
//! make a wider detour than the search covers. Nearby the costmap's own search decides, so that
//! seen obstacles count. Where it finds no path, these are remembered, the road is closed, and the
//! next corridor is taken, until there is none.

use openbench_core::{MapPoint, RobotDescription};
use openbench_geometry::Segment;
use openbench_motion::costmap::Preferences;
use openbench_motion::costmap::{Obstruction, Overview};
use openbench_motion::{Costmap, CostmapError, Guide, PlanError, Search, costs, plan};
use openbench_osm::OsmMap;
use openbench_routing::{MapRouter, Router};

/// How far the fine costmap reaches to each side.
const HALF_WIDTH_M: f64 = 50.0;
/// The costmap follows once the robot is this far from its middle.
const SLACK_M: f64 = 20.0;
/// No goal is set this near to the rim of the costmap: it moves.
const RIM_M: f64 = 3.0;
/// Largest distance between points of a corridor.
const STRIDE_M: f64 = 1.0;
/// Most corridors that are tried before a goal counts as unreachable.
const CORRIDORS: usize = 4;
/// A corridor farther than this from the robot is outdated.
const STRAYED_M: f64 = 25.0;
/// Paths to places beyond this distance are compared by the map alone.
const COMPARED_M: f64 = 60.0;
/// A partial path must lead at least this far.
const HERE_M: f64 = 2.0;
/// Roads within this distance of a blocked point are closed.
const ON_ROAD_M: f64 = 3.0;
/// How far ahead of the robot the path is checked against every scan.
const CHECK_AHEAD_M: f64 = 3.0;
/// The robot's own hull is within this distance of its middle.
const OWN_HULL_M: f64 = 0.4;

/// A coarse path to a goal.
#[derive(Debug, Clone)]
struct Corridor {
    goal: MapPoint,
    /// No farther apart than [`STRIDE_M`].
    points: Vec<MapPoint>,
}

/// The ground as known so far.
pub struct Terrain {
    map: OsmMap,
    roads: Option<MapRouter>,
    near: Costmap,
    overview: Overview,
    corridor: Option<Corridor>,
    /// Whether the last path ends before its goal.
    partial: bool,
    search: Search,
    /// Paths that were searched and not yet counted.
    searches: u32,
}

impl Terrain {
    /// The ground of a map around `start`. Without `roads`, corridors lead over the map's open
    /// ground alone.
    pub fn new(
        map: OsmMap,
        roads: Option<MapRouter>,
        start: MapPoint,
        robot: &RobotDescription,
        preferences: Preferences,
    ) -> Result<Self, CostmapError> {
        let low = MapPoint::new(start.x - HALF_WIDTH_M, start.y - HALF_WIDTH_M);
        let high = MapPoint::new(start.x + HALF_WIDTH_M, start.y + HALF_WIDTH_M);
        Ok(Self {
            near: Costmap::with_preferences(&map, low, high, robot, preferences)?,
            overview: Overview::new(robot)?,
            map,
            roads,
            corridor: None,
            partial: false,
            search: Search::default(),
            searches: 0,
        })
    }

    /// The fine costmap around the robot.
    pub fn near(&self) -> &Costmap {
        &self.near
    }

    /// The fine costmap, to add scans.
    pub fn near_mut(&mut self) -> &mut Costmap {
        &mut self.near
    }

    /// Forgets all obstacles that were seen.
    pub fn forget_seen(&mut self) {
        self.near.forget_seen();
        self.overview.forget_all();
        self.corridor = None;
    }

    /// Takes a map on which some buildings are elsewhere. What was seen is kept.
    pub fn set_map(&mut self, map: OsmMap) {
        self.map = map;
        let middle = self.near.grid().middle();
        self.near.cover(&self.map, middle, HALF_WIDTH_M);
        self.corridor = None;
    }

    /// The map's roads.
    pub fn roads(&self) -> Option<&MapRouter> {
        self.roads.as_ref()
    }

    /// The number of path searches since this was last asked.
    pub fn take_searches(&mut self) -> u32 {
        std::mem::take(&mut self.searches)
    }

    /// Whether the last path leads only to a place from which more can be seen.
    pub fn is_partial(&self) -> bool {
        self.partial
    }

    /// Costs of the paths to places, in metres of open ground; `None` where no path is known.
    pub fn costs(&self, from: MapPoint, places: &[MapPoint]) -> Vec<Option<f64>> {
        // One place with a path nearby suffices: it is among the nearest. The costs are not mixed,
        // since those of the overview are in metres of mapped roads, not of open ground.
        let near = costs(&self.near, from, places, COMPARED_M);
        if places.is_empty() || near.iter().any(Option::is_some) {
            return near;
        }
        self.overview.costs(&self.map, from, places)
    }

    /// Describes what blocks the path to a place that cannot be reached.
    pub fn obstacle(&self, from: MapPoint, to: MapPoint) -> String {
        match self.overview.obstruction(&self.map, from, to) {
            Some(Obstruction { kind, at }) => format!("no path leads to {to} past {kind} at {at}"),
            None => format!("no path leads to {to}"),
        }
    }

    /// Moves the fine costmap along with the robot.
    pub fn follow(&mut self, here: MapPoint) {
        let middle = self.near.grid().middle();
        // A pose that is no number moves nothing.
        let off = (here.x - middle.x).abs().max((here.y - middle.y).abs());
        if off.is_finite() && off > SLACK_M {
            // Obstacles beyond the new window would be lost with the old one.
            self.overview.note(&self.near);
            self.near.cover(&self.map, here, HALF_WIDTH_M);
        }
    }

    /// A corridor to a goal by all that is known: over the ground, or over roads.
    fn lay(&self, from: MapPoint, goal: MapPoint) -> Result<Corridor, PlanError> {
        // The overview covers only the ground around both ends. A wider detour is found on the road
        // graph.
        let ground = self.overview.path(&self.map, from, goal);
        let points = ground.or_else(|error| self.over_roads(from, goal).ok_or(error))?;
        Ok(Corridor {
            goal,
            points: dense(&points),
        })
    }

    fn over_roads(&self, from: MapPoint, goal: MapPoint) -> Option<Vec<MapPoint>> {
        let route = self.roads.as_ref()?.route(from, goal).ok()?;
        let (first, last) = (*route.points.first()?, *route.points.last()?);
        // Between the roads and both ends the map's ground has to be open.
        let mut points = self.overview.path(&self.map, from, first).ok()?;
        // Each part begins with the last point of the part before it, which is skipped.
        points.extend(route.points.into_iter().skip(1));
        points.extend(
            self.overview
                .path(&self.map, last, goal)
                .ok()?
                .into_iter()
                .skip(1),
        );
        Some(points)
    }

    /// The path along the corridor: searched as far as the fine costmap reaches, the corridor
    /// itself from there.
    fn along(&mut self, from: MapPoint) -> Result<Vec<MapPoint>, Blocked> {
        let Some(corridor) = &self.corridor else {
            return Err(Blocked {
                reached: None,
                beyond: from,
            });
        };
        // The corridor was laid from an earlier pose; what lies behind the robot is done.
        let ahead = &corridor.points[nearest(&corridor.points, from)..];
        let inside = |point: &&MapPoint| is_within(&self.near, **point, RIM_M);
        // Up to its first exit: what lies behind it cannot be reached within the costmap alone.
        let covered = ahead.iter().take_while(inside).count();
        let is_free = |i: &usize| {
            let cell = self.near.grid().cell_at(ahead[*i]);
            cell.is_some_and(|cell| self.near.cost(cell).is_some())
        };
        let goal = ahead.last().copied().unwrap_or(corridor.goal);
        // The goal itself may lie in an obstacle; `plan` handles that.
        let end = if covered == ahead.len() {
            covered.checked_sub(1)
        } else {
            (0..covered).rfind(is_free)
        };
        let Some(end) = end else {
            return Err(Blocked {
                reached: None,
                beyond: goal,
            });
        };
        match plan(&mut self.search, &self.near, from, ahead[end]) {
            Ok(mut way) => {
                // Beyond the costmap the corridor is not searched again until the costmap covers
                // it.
                way.extend_from_slice(&ahead[end + 1..]);
                Ok(way)
            }
            Err(_) => {
                // The failed search has visited all that can be reached. Its last corridor point is
                // the place to drive to, and the next one is where the corridor is blocked.
                let reached = |point: &MapPoint| {
                    let cell = self.near.grid().cell_at(*point);
                    cell.is_some_and(|cell| self.search.reached(cell))
                };
                let last = ahead[..=end].iter().rposition(reached);
                let beyond = ahead[last.map_or(0, |last| (last + 1).min(end))];
                Err(Blocked {
                    reached: last.map(|last| ahead[last]),
                    beyond,
                })
            }
        }
    }
}

/// Where a corridor is blocked.
#[derive(Debug, Clone, Copy)]
struct Blocked {
    /// Its last point that can be reached.
    reached: Option<MapPoint>,
    /// Its first point that cannot.
    beyond: MapPoint,
}

impl Guide for Terrain {
    fn path(&mut self, from: MapPoint, to: MapPoint) -> Result<Vec<MapPoint>, PlanError> {
        self.follow(from);
        self.searches += 1;
        self.partial = false;
        // Scans since the last call count only from here on.
        self.near.inflate();
        if is_within(&self.near, to, 0.0) {
            match plan(&mut self.search, &self.near, from, to) {
                // Only here a path that leaves the costmap can help. Blocked ends stay blocked.
                Err(PlanError::NoPath(..)) => {}
                found => return found,
            }
        }
        // A corridor is kept while it serves: a new one costs a search over the map.
        let is_current = |corridor: &Corridor| {
            let at = corridor.points[nearest(&corridor.points, from)];
            corridor.goal == to && at.distance(from) < STRAYED_M
        };
        self.corridor = self.corridor.take().filter(is_current);
        let mut blocked = None;
        for _ in 0..CORRIDORS {
            if self.corridor.is_none() {
                let laid = match self.lay(from, to) {
                    // Obstacles that were seen may have gone by now.
                    Err(_) if self.overview.forget() => self.lay(from, to),
                    laid => laid,
                };
                match laid {
                    Ok(corridor) => self.corridor = Some(corridor),
                    Err(error) => return Err(error),
                }
            }
            match self.along(from) {
                Ok(way) => return Ok(way),
                Err(at) => {
                    // What blocks it must count in the next attempt: as obstacles for a path over
                    // the ground, as a closed road for a route. Otherwise the same corridor would
                    // be laid again.
                    self.overview.note(&self.near);
                    if let Some(roads) = &mut self.roads {
                        roads.close(at.beyond, ON_ROAD_M);
                    }
                    (self.corridor, blocked) = (None, Some(at));
                }
            }
        }
        // More may be seen from nearer.
        let near = blocked
            .and_then(|blocked| blocked.reached)
            .filter(|at| at.distance(from) > HERE_M);
        let near = near.ok_or(PlanError::NoPath(from, to))?;
        self.partial = true;
        plan(&mut self.search, &self.near, from, near)
    }

    /// Checks the newest scans.
    fn is_blocked(&self, path: &[MapPoint], from: MapPoint) -> bool {
        let Some((at, start)) = nearest_on_path(path, from) else {
            return false;
        };
        let mut left = CHECK_AHEAD_M;
        let mut begin = start;
        for &corner in &path[at + 1..] {
            let length = begin.distance(corner);
            // Equal points have a length of zero and a share that is infinite, or NaN; `along` then
            // ends at the corner.
            let end = along(begin, corner, left / length);
            // Only obstacles ahead of the robot's own hull count.
            let hull = (OWN_HULL_M - begin.distance(from)).max(0.0) / begin.distance(end);
            if hull < 1.0 && !self.near.is_clear(along(begin, end, hull), end) {
                return true;
            }
            left -= length;
            if left <= 0.0 {
                break;
            }
            begin = corner;
        }
        false
    }
}

/// Whether a point lies on a costmap, at least `rim` metres from its edge.
fn is_within(costmap: &Costmap, point: MapPoint, rim: f64) -> bool {
    let grid = costmap.grid();
    let inside = |at: f64, origin: f64, cells: usize| {
        at - origin >= rim && origin + cells as f64 * grid.cell - at > rim
    };
    inside(point.x, grid.origin.x, grid.width) && inside(point.y, grid.origin.y, grid.height)
}

/// Index of the point nearest to a place, the last of equals.
fn nearest(points: &[MapPoint], place: MapPoint) -> usize {
    let away = |i: usize| points[i].distance(place);
    (0..points.len())
        .rev()
        .min_by(|a, b| away(*a).total_cmp(&away(*b)))
        .unwrap_or(0)
}

/// The same line with points no farther apart than [`STRIDE_M`].
fn dense(points: &[MapPoint]) -> Vec<MapPoint> {
    let mut line = points.first().map_or(Vec::new(), |first| vec![*first]);
    for pair in points.windows(2) {
        let count = (pair[0].distance(pair[1]) / STRIDE_M).ceil().max(1.0) as usize;
        line.extend((1..=count).map(|i| along(pair[0], pair[1], i as f64 / count as f64)));
    }
    line
}

/// The point of a path nearest to `from`, and the index of its segment.
fn nearest_on_path(path: &[MapPoint], from: MapPoint) -> Option<(usize, MapPoint)> {
    let on = |i: usize| {
        (
            i,
            Segment::new(path[i], path[i + 1]).nearest_point(from).point,
        )
    };
    let stretches = (0..path.len().saturating_sub(1)).map(on);
    stretches.min_by(|a, b| a.1.distance(from).total_cmp(&b.1.distance(from)))
}

/// The point at the share `t` between `a` and `b`, `b` at most.
fn along(a: MapPoint, b: MapPoint, t: f64) -> MapPoint {
    // Not `min`: this sends NaN to the end as well.
    Segment::new(a, b).at(if t < 1.0 { t } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::{Georeference, LonLat};
    use openbench_motion::{RangeRing, ScanPoint};
    use openbench_osm::{Barrier, OsmData};

    const MIDDLE: LonLat = LonLat {
        lon: 8.0,
        lat: 50.0,
    };

    /// Open ground with walls along lines.
    fn walled(walls: &[&[(f64, f64)]]) -> Terrain {
        let mut map = OsmMap::new(&OsmData::default(), Georeference::tangent_plane(MIDDLE));
        map.barriers = walls
            .iter()
            .enumerate()
            .map(|(way, points)| Barrier {
                way: way as i64,
                points: points.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect(),
                gates: vec![],
                tags: [("barrier", "wall")].into_iter().collect(),
            })
            .collect();
        let robot = RobotDescription::sentry();
        Terrain::new(map, None, MapPoint::default(), &robot, Preferences::NONE).unwrap()
    }

    fn length(way: &[MapPoint]) -> f64 {
        way.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    #[test]
    fn a_goal_far_off_is_led_to_round_walls_that_the_fine_costmap_does_not_cover() {
        let mut terrain = walled(&[&[(200.0, -30.0), (200.0, 120.0)]]);
        let (start, goal) = (MapPoint::default(), MapPoint::new(400.0, 0.0));
        let shortest = 2.0 * start.distance(MapPoint::new(200.0, -30.0));
        let way = terrain.path(start, goal).unwrap();
        assert!(
            (shortest..1.03 * shortest).contains(&length(&way)),
            "{} for {shortest}",
            length(&way)
        );
        assert!(!terrain.is_partial() && way.last().unwrap().distance(goal) < 1.0);
        // The same from further on, once the costmap has followed.
        let later = MapPoint::new(120.0, -18.0);
        let rest = terrain.path(later, goal).unwrap();
        assert!(length(&rest) < length(&way) - 110.0);
        assert!(terrain.near().grid().cell_at(later).is_some());
    }

    #[test]
    fn what_was_seen_is_gone_round_beyond_what_is_seen() {
        let mut terrain = walled(&[]);
        let (start, goal) = (MapPoint::default(), MapPoint::new(150.0, 0.0));
        let straight = length(&terrain.path(start, goal).unwrap());
        // A hedge that no map has, from rim to rim but for its northern end.
        for north in -24..23 {
            let from = MapPoint::new(8.0, 2.0 * f64::from(north));
            let hedge = (-20..20)
                .map(|i| ScanPoint::new(MapPoint::new(10.0, from.y + f64::from(i) / 10.0), 0.3));
            terrain
                .near_mut()
                .observe(&RangeRing::new(from, 0.25, hedge));
        }
        let round = length(&terrain.path(start, goal).unwrap());
        assert!(straight < 151.0 && round > 165.0, "{straight} {round}");
        terrain.forget_seen();
        assert!(length(&terrain.path(start, goal).unwrap()) < 151.0);
    }

    #[test]
    fn where_there_is_no_way_it_is_said_what_is_in_it() {
        let yard = [
            (60.0, -20.0),
            (100.0, -20.0),
            (100.0, 20.0),
            (60.0, 20.0),
            (60.0, -20.0),
        ];
        let mut terrain = walled(&[&yard]);
        let (start, goal) = (MapPoint::default(), MapPoint::new(80.0, 0.0));
        assert!(matches!(
            terrain.path(start, goal),
            Err(PlanError::NoPath(..))
        ));
        let words = terrain.obstacle(start, goal);
        assert!(
            words.contains("wall") && words.contains("59.9") || words.contains("60."),
            "{words}"
        );
        let outside = MapPoint::new(120.0, 0.0);
        let costs = terrain.costs(start, &[goal, outside]);
        assert!(
            costs[0].is_none() && costs[1].is_some_and(|cost| cost > 125.0),
            "{costs:?}"
        );
    }
}
