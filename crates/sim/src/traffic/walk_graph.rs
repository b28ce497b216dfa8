//! The network of places that people walk between, and shortest paths in it.

use std::ops::Range;

use openbench_core::MapPoint;
use openbench_geometry::grid::Frontier;

use crate::noise::Noise;

/// Networks with fewer places are too small to walk in.
const SMALLEST_NETWORK: usize = 15;
/// Shortest and longest journey, metres.
const SHORTEST_JOURNEY_M: f64 = 40.0;
const LONGEST_JOURNEY_M: f64 = 160.0;
/// A journey ends at a place farther than this share of the farthest place within its length.
const FAR_SHARE: f64 = 0.7;

/// A place on a footway or pavement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub point: MapPoint,
    /// Half the width of the way there, metres.
    pub half_width: f64,
}

/// Two places between which one can walk straight, by their numbers.
pub(super) type Pair = [u32; 2];

/// A link from a place to another.
#[derive(Debug, Clone, Copy)]
struct Link {
    to: u32,
    /// Metres.
    length: f64,
}

/// Places and the links between them.
#[derive(Debug)]
pub(super) struct WalkGraph {
    places: Vec<Place>,
    /// Where each place's links begin in `links`; one more at the end.
    first_link: Vec<u32>,
    links: Vec<Link>,
    /// Places of networks that are large enough.
    usable: Vec<u32>,
    search: Search,
}

/// Buffers of a search, kept from one search to the next.
#[derive(Debug, Default)]
struct Search {
    number: u32,
    visits: Vec<Visit>,
    frontier: Frontier,
    /// Places in order of distance.
    settled: Vec<u32>,
}

/// What a search knows of a place.
#[derive(Debug, Clone, Copy, Default)]
struct Visit {
    /// Number of the search. Visits of earlier searches are void.
    search: u32,
    /// Length of the shortest path to the place, metres.
    cost: f64,
    /// The place before it on that path.
    before: u32,
}

impl WalkGraph {
    /// A graph of places, with a link each way for each pair.
    pub fn new(places: Vec<Place>, mut pairs: Vec<Pair>) -> Self {
        let mirrored: Vec<Pair> = pairs.iter().map(|[a, b]| [*b, *a]).collect();
        pairs.extend(mirrored);
        pairs.sort_unstable();
        pairs.dedup();
        // Sorted by their first place, the links of a place are next to each other.
        let mut first_link = vec![0_u32; places.len() + 1];
        pairs
            .iter()
            .for_each(|[a, _]| first_link[*a as usize + 1] += 1);
        (1..first_link.len()).for_each(|i| first_link[i] += first_link[i - 1]);
        let link = |&[from, to]: &Pair| {
            let length = places[from as usize]
                .point
                .distance(places[to as usize].point);
            Link { to, length }
        };
        let links = pairs.iter().map(link).collect();
        let search = Search {
            visits: vec![Visit::default(); places.len()],
            ..Search::default()
        };
        let mut graph = Self {
            places,
            first_link,
            links,
            usable: Vec::new(),
            search,
        };
        graph.usable = graph.large_networks();
        graph
    }

    /// Whether there is nowhere to walk.
    pub fn is_empty(&self) -> bool {
        self.usable.is_empty()
    }

    pub fn point(&self, place: u32) -> MapPoint {
        self.places[place as usize].point
    }

    /// Half the width of the way at a place, metres.
    pub fn half_width(&self, place: u32) -> f64 {
        self.places[place as usize].half_width
    }

    /// A place drawn from all usable ones.
    ///
    /// # Panics
    /// If the graph [is empty](Self::is_empty).
    pub fn draw(&self, noise: &mut Noise) -> u32 {
        self.usable[(noise.uniform() * self.usable.len() as f64) as usize]
    }

    /// Writes a shortest path (Dijkstra) from `from` to a goal drawn from the places one journey
    /// away.
    pub fn journey(&mut self, from: u32, noise: &mut Noise, path: &mut Vec<u32>) {
        let length =
            SHORTEST_JOURNEY_M + (LONGEST_JOURNEY_M - SHORTEST_JOURNEY_M) * noise.uniform();
        self.settle(from, length);
        let Search {
            visits, settled, ..
        } = &self.search;
        // Places are settled in order of distance: the far ones are at the end.
        let cost = |place: u32| visits[place as usize].cost;
        let reached = cost(settled[settled.len() - 1]);
        let far = settled.partition_point(|p| cost(*p) < FAR_SHARE * reached);
        let choice = far + (noise.uniform() * (settled.len() - far) as f64) as usize;
        let goal = settled[choice.min(settled.len() - 1)];
        self.trace(from, goal, path);
    }

    /// Writes the path that the last search from `from` found to `goal`.
    fn trace(&self, from: u32, goal: u32, path: &mut Vec<u32>) {
        let mut place = goal;
        path.clear();
        path.push(place);
        while place != from {
            place = self.search.visits[place as usize].before;
            path.push(place);
        }
        path.reverse();
    }

    /// Finds the shortest paths from `from` to all places within `length` metres.
    fn settle(&mut self, from: u32, length: f64) {
        let search = &mut self.search;
        search.number += 1;
        search.settled.clear();
        // The last search may have stopped early; emptied, the buffer keeps its memory.
        while search.frontier.pop().is_some() {}
        search.visits[from as usize] = Visit {
            search: search.number,
            cost: 0.0,
            before: from,
        };
        search.frontier.push(0.0, from as usize);
        while let Some((cost, place)) = search.frontier.pop() {
            if cost > length {
                break;
            }
            // An entry from before a shorter path to this place was found.
            if cost > search.visits[place].cost {
                continue;
            }
            search.settled.push(place as u32);
            let links = self.first_link[place] as usize..self.first_link[place + 1] as usize;
            for link in &self.links[links] {
                let known = &mut search.visits[link.to as usize];
                let through = cost + link.length;
                if known.search != search.number || through < known.cost {
                    let before = place as u32;
                    *known = Visit {
                        search: search.number,
                        cost: through,
                        before,
                    };
                    search.frontier.push(through, link.to as usize);
                }
            }
        }
    }

    /// The places of networks that are large enough, in order.
    fn large_networks(&self) -> Vec<u32> {
        let mut visited = vec![false; self.places.len()];
        let mut usable = Vec::new();
        for start in 0..self.places.len() as u32 {
            if visited[start as usize] {
                continue;
            }
            // Breadth first: `members` is the queue and the result at once.
            let mut members = vec![start];
            visited[start as usize] = true;
            let mut next = 0;
            while let Some(&place) = members.get(next) {
                next += 1;
                for link in &self.links[self.links_of(place)] {
                    if !visited[link.to as usize] {
                        visited[link.to as usize] = true;
                        members.push(link.to);
                    }
                }
            }
            if members.len() >= SMALLEST_NETWORK {
                usable.extend(members);
            }
        }
        usable.sort_unstable();
        usable
    }

    fn links_of(&self, place: u32) -> Range<usize> {
        let place = place as usize;
        self.first_link[place] as usize..self.first_link[place + 1] as usize
    }
}

#[cfg(test)]
impl WalkGraph {
    pub fn nearest(&self, point: MapPoint) -> u32 {
        let away = |i: &u32| self.point(*i).distance(point);
        (0..self.places.len() as u32)
            .min_by(|a, b| away(a).total_cmp(&away(b)))
            .unwrap()
    }

    pub fn path_to(&mut self, from: u32, goal: u32, path: &mut Vec<u32>) {
        self.settle(from, f64::INFINITY);
        self.trace(from, goal, path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty places in a row, 1 m apart, and three places of their own.
    fn graph() -> WalkGraph {
        let place = |x: f64| Place {
            point: MapPoint::new(x, 0.0),
            half_width: 1.0,
        };
        let places: Vec<Place> = (0..23).map(|i| place(f64::from(i))).collect();
        let row = (0..19).map(|i| [i, i + 1]);
        WalkGraph::new(places, row.chain([[20, 21], [21, 22]]).collect())
    }

    #[test]
    fn small_networks_are_not_used() {
        assert_eq!(graph().usable, (0..20).collect::<Vec<u32>>());
    }

    #[test]
    fn paths_lead_from_place_to_place() {
        let mut path = Vec::new();
        graph().path_to(4, 1, &mut path);
        assert_eq!(path, [4, 3, 2, 1]);
    }
}
