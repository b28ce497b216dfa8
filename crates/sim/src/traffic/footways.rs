//! The network that people walk on: footways, paths and crossings of the map, and pavements beside its streets.
//!
//! Ways are cut into places about 2 m apart. Places that one can walk straight between are linked along a way, across a
//! gap in it (a street's mouth), and from way to way where they come near each other.

use openbench_core::MapPoint;
use openbench_grid::Frontier;
use openbench_osm::{OsmMap, Road};

use super::ground::Ground;
use super::neighbours::Neighbours;
use super::ways::{carriageway, walkway};
use crate::noise::Noise;

/// Distance between places along a way, metres.
const SPACING: f64 = 2.0;
/// Ways that come this near to each other hang together, metres.
const JOIN: f64 = 2.5;
/// A pavement goes on beyond a gap of this length: a street's mouth, metres.
const MOUTH: f64 = 16.0;
/// A place needs this much room beyond that of a person, metres.
const ROOM: f64 = 0.1;
/// Networks with fewer places are too small to walk in.
const SMALLEST: usize = 15;
/// Lengths of journeys, metres.
const JOURNEY: (f64, f64) = (40.0, 160.0);

/// Places and the links between them.
#[derive(Debug)]
pub(super) struct Footways {
    places: Vec<Place>,
    first_link: Vec<u32>,
    links: Vec<(u32, f64)>,
    /// Places of networks that are large enough.
    usable: Vec<u32>,
    search: Search,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    point: MapPoint,
    /// Half the width of the way there, metres.
    half_width: f64,
}

/// Buffers of a search; what an older search wrote is known by its number.
#[derive(Debug, Default)]
struct Search {
    number: u32,
    seen: Vec<(u32, f64, u32)>,
    frontier: Frontier,
    settled: Vec<u32>,
}

/// A line to walk along.
struct Line {
    points: Vec<MapPoint>,
    half_width: f64,
    /// Whether it is a pavement, which does not lead over carriageways.
    beside: bool,
}

impl Footways {
    pub fn new(map: &OsmMap, ground: &Ground) -> Self {
        let mut places = Vec::new();
        let mut pairs = Vec::new();
        for road in &map.roads {
            let ends: Vec<_> = lines(road)
                .iter()
                .map(|l| lay(l, ground, &mut places, &mut pairs))
                .collect();
            // A street's pavements meet at its ends: one crosses there.
            if let [Some(left), Some(right)] = ends[..] {
                for (a, b) in [(left.0, right.0), (left.1, right.1)] {
                    link_across(&places, ground, &mut pairs, (a, b));
                }
            }
        }
        join(&places, ground, &mut pairs);
        Self::of_links(places, pairs)
    }

    fn of_links(places: Vec<Place>, mut pairs: Vec<(u32, u32)>) -> Self {
        let mirrored: Vec<(u32, u32)> = pairs.iter().map(|(a, b)| (*b, *a)).collect();
        pairs.extend(mirrored);
        pairs.sort_unstable();
        pairs.dedup();
        let mut first_link = vec![0_u32; places.len() + 1];
        pairs
            .iter()
            .for_each(|(a, _)| first_link[*a as usize + 1] += 1);
        (1..first_link.len()).for_each(|i| first_link[i] += first_link[i - 1]);
        let length = |(a, b): &(u32, u32)| {
            places[*a as usize]
                .point
                .distance(places[*b as usize].point)
        };
        let links = pairs.iter().map(|pair| (pair.1, length(pair))).collect();
        let search = Search {
            seen: vec![(0, 0.0, 0); places.len()],
            ..Search::default()
        };
        let mut ways = Self {
            places,
            first_link,
            links,
            usable: Vec::new(),
            search,
        };
        ways.usable = ways.large_networks();
        ways
    }

    /// Whether there is nowhere to walk.
    pub fn is_empty(&self) -> bool {
        self.usable.is_empty()
    }

    pub fn point(&self, place: u32) -> MapPoint {
        self.places[place as usize].point
    }

    pub fn half_width(&self, place: u32) -> f64 {
        self.places[place as usize].half_width
    }

    /// A place drawn from all that are of use.
    ///
    /// # Panics
    /// If the network [is empty](Self::is_empty).
    pub fn draw(&self, noise: &mut Noise) -> u32 {
        self.usable[(noise.uniform() * self.usable.len() as f64) as usize]
    }

    /// Writes a shortest way (Dijkstra) from `from` to a goal drawn from the places one journey away.
    pub fn journey(&mut self, from: u32, noise: &mut Noise, way: &mut Vec<u32>) {
        let length = JOURNEY.0 + (JOURNEY.1 - JOURNEY.0) * noise.uniform();
        self.settle(from, length);
        let search = &self.search;
        // Places are settled in order of distance: those far enough come last.
        let cost = |place: u32| search.seen[place as usize].1;
        let reached = cost(search.settled[search.settled.len() - 1]);
        let far = search.settled.partition_point(|p| cost(*p) < 0.7 * reached);
        let choice = far + (noise.uniform() * (search.settled.len() - far) as f64) as usize;
        let goal = search.settled[choice.min(search.settled.len() - 1)];
        self.trace(from, goal, way);
    }

    fn trace(&self, from: u32, goal: u32, way: &mut Vec<u32>) {
        let mut place = goal;
        way.clear();
        way.push(place);
        while place != from {
            place = self.search.seen[place as usize].2;
            way.push(place);
        }
        way.reverse();
    }

    /// Finds the shortest ways from `from` to all places within `length` metres.
    fn settle(&mut self, from: u32, length: f64) {
        let search = &mut self.search;
        search.number += 1;
        search.settled.clear();
        while search.frontier.pop().is_some() {}
        search.seen[from as usize] = (search.number, 0.0, from);
        search.frontier.push(0.0, from as usize);
        while let Some((cost, place)) = search.frontier.pop() {
            if cost > length {
                break;
            }
            if cost > search.seen[place].1 {
                continue;
            }
            search.settled.push(place as u32);
            let links = self.first_link[place] as usize..self.first_link[place + 1] as usize;
            for (next, step) in &self.links[links] {
                let known = &mut search.seen[*next as usize];
                if known.0 != search.number || cost + step < known.1 {
                    *known = (search.number, cost + step, place as u32);
                    search.frontier.push(cost + step, *next as usize);
                }
            }
        }
    }

    fn large_networks(&self) -> Vec<u32> {
        let mut network = vec![u32::MAX; self.places.len()];
        let mut usable = Vec::new();
        for start in 0..self.places.len() as u32 {
            if network[start as usize] != u32::MAX {
                continue;
            }
            let mut members = vec![start];
            network[start as usize] = start;
            let mut next = 0;
            while let Some(&place) = members.get(next) {
                next += 1;
                let links = self.first_link[place as usize] as usize
                    ..self.first_link[place as usize + 1] as usize;
                for (to, _) in &self.links[links] {
                    if network[*to as usize] == u32::MAX {
                        network[*to as usize] = start;
                        members.push(*to);
                    }
                }
            }
            if members.len() >= SMALLEST {
                usable.extend(members);
            }
        }
        usable.sort_unstable();
        usable
    }
}

/// The lines of a way that people walk along: its middle, or left and right of it.
fn lines(road: &Road) -> Vec<Line> {
    if let Some(half_width) = walkway(&road.tags) {
        return vec![Line {
            points: road.points.clone(),
            half_width,
            beside: false,
        }];
    }
    let Some(way) = carriageway(&road.tags) else {
        return Vec::new();
    };
    let sides = [(1.0, way.walkers[0]), (-1.0, way.walkers[1])];
    let side = |(sign, offset): (f64, Option<f64>)| {
        offset.map(|o| Line {
            points: shifted(&road.points, sign * o),
            half_width: 0.7,
            beside: true,
        })
    };
    sides.into_iter().filter_map(side).collect()
}

/// The line moved `offset` metres to its left, mitred.
pub(super) fn shifted(line: &[MapPoint], offset: f64) -> Vec<MapPoint> {
    let normal = |i: usize| {
        let (a, b) = (line[i], line[i + 1]);
        let length = a.distance(b).max(1e-9);
        [-(b.y - a.y) / length, (b.x - a.x) / length]
    };
    let last = line.len() - 1;
    (0..line.len())
        .map(|i| {
            let (a, b) = (normal(i.max(1) - 1), normal(i.min(last - 1)));
            let scale = offset / (1.0 + a[0] * b[0] + a[1] * b[1]).max(0.5);
            MapPoint::new(
                line[i].x + (a[0] + b[0]) * scale,
                line[i].y + (a[1] + b[1]) * scale,
            )
        })
        .collect()
}

/// Puts places along a line and links them; the first and the last are returned.
fn lay(
    line: &Line,
    ground: &Ground,
    places: &mut Vec<Place>,
    pairs: &mut Vec<(u32, u32)>,
) -> Option<(u32, u32)> {
    let from = places.len() as u32;
    for w in line.points.windows(2) {
        let steps = (w[0].distance(w[1]) / SPACING).ceil().clamp(1.0, 2_000.0) as usize;
        for i in 0..=steps {
            let share = i as f64 / steps as f64;
            let point = MapPoint::new(
                w[0].x + (w[1].x - w[0].x) * share,
                w[0].y + (w[1].y - w[0].y) * share,
            );
            let repeated = places.len() as u32 > from && places[places.len() - 1].point == point;
            if !repeated
                && ground.clearance(point).0 >= ROOM
                && !(line.beside && ground.is_road(point))
            {
                places.push(Place {
                    point,
                    half_width: line.half_width,
                });
            }
        }
    }
    let to = places.len() as u32;
    (from + 1..to).for_each(|i| link_across(places, ground, pairs, (i - 1, i)));
    (to > from).then(|| (from, to - 1))
}

fn link_across(places: &[Place], ground: &Ground, pairs: &mut Vec<(u32, u32)>, (a, b): (u32, u32)) {
    let (p, q) = (places[a as usize].point, places[b as usize].point);
    if a != b && p.distance(q) <= MOUTH && ground.sees(p, q) {
        pairs.push((a, b));
    }
}

/// Links places of different ways that are near each other.
fn join(places: &[Place], ground: &Ground, pairs: &mut Vec<(u32, u32)>) {
    let mut neighbours = Neighbours::new(JOIN);
    neighbours.fill(places.iter().map(|p| Some(p.point)));
    for (i, place) in places.iter().enumerate() {
        neighbours.near(place.point, |j| {
            let other = places[j].point;
            if j > i && place.point.distance(other) <= JOIN && ground.sees(place.point, other) {
                pairs.push((i as u32, j as u32));
            }
        });
    }
}

#[cfg(test)]
impl Footways {
    pub fn nearest(&self, point: MapPoint) -> u32 {
        let away = |i: &u32| self.point(*i).distance(point);
        (0..self.places.len() as u32)
            .min_by(|a, b| away(a).total_cmp(&away(b)))
            .unwrap()
    }

    pub fn way_to(&mut self, from: u32, goal: u32, way: &mut Vec<u32>) {
        self.settle(from, f64::INFINITY);
        self.trace(from, goal, way);
    }
}
