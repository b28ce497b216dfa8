//! The way from one place on the network to another.

use crate::geo::Place;
use crate::metric::Metric;
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;
use crate::search::{End, Path, Workspace};

/// The way between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// What it counts as.
    pub weight: u32,
    /// Directed edges in order: twice the edge's number, and one more against its direction. The first and the last are
    /// travelled in part.
    pub edges: Vec<u32>,
    /// Where it begins, on the first edge.
    pub from: Position,
    /// Where it ends, on the last edge.
    pub to: Position,
}

/// A directed edge at one of a leg's ends.
#[derive(Debug, Clone, Copy)]
struct Hold {
    directed: u32,
    position: Position,
    end: End,
}

/// Memory of finding legs, used again for the next one.
#[derive(Debug, Default)]
pub struct Memory {
    workspace: Workspace,
    path: Path,
    sources: Vec<Hold>,
    targets: Vec<Hold>,
    ends: [Vec<End>; 2],
}

/// The part of a weight that belongs to a share of an edge. Two parts of an edge are exactly the whole.
fn part(whole: u32, share: f64) -> u32 {
    libm::round(f64::from(whole) * share) as u32
}

/// A share of an edge, in the direction in which it is travelled.
fn directed_share(position: &Position, directed: u32) -> f64 {
    if directed.is_multiple_of(2) { position.share } else { 1.0 - position.share }
}

/// One of a directed edge's two costs before a place on it.
fn before(whole: u32, position: &Position, directed: u32) -> u32 {
    let forward = part(whole, position.share);
    if directed.is_multiple_of(2) { forward } else { whole - forward }
}

impl Leg {
    /// The lightest way from one of some places to one of others.
    pub fn find(
        roads: &Roads,
        metric: &Metric,
        from: &[Position],
        to: &[Position],
        memory: &mut Memory,
    ) -> Option<Self> {
        let straight = straight(metric, from, to);
        memory.hold(roads, metric, from, to);
        let Memory { workspace, path, sources, targets, ends } = memory;
        let around = workspace.route(metric.searched(roads), &ends[0], &ends[1], path);
        match (straight, around) {
            (Some(straight), around) if around.is_none_or(|weight| straight.weight <= weight) => {
                Some(straight)
            }
            (_, Some(weight)) => Some(unpacked(roads, metric, weight, &path.states, [sources, targets])),
            (straight, None) => straight,
        }
    }

    /// Metres, hundredths of a second.
    pub fn length_and_duration(&self, roads: &Roads, metric: &Metric) -> (f64, u32) {
        let (mut length, mut duration) = (0.0, 0);
        for (i, &directed) in self.edges.iter().enumerate() {
            let whole = metric.edges[directed as usize].duration;
            let [begin, end] = self.travelled(i);
            length += f64::from(roads.network.edges[directed as usize / 2].length) / 1000.0 * (end - begin);
            let first = if i == 0 { before(whole, &self.from, directed) } else { 0 };
            let last = if i + 1 == self.edges.len() { before(whole, &self.to, directed) } else { whole };
            duration += last - first;
            if i + 1 < self.edges.len() {
                duration += metric.vertices[roads.network.ends(directed)[1] as usize].duration;
            }
        }
        (length, duration)
    }

    /// From which share of its edge to which one the edge of that index is travelled.
    pub fn travelled(&self, index: usize) -> [f64; 2] {
        let directed = self.edges[index];
        let begin = if index == 0 { directed_share(&self.from, directed) } else { 0.0 };
        let last = index + 1 == self.edges.len();
        [begin, if last { directed_share(&self.to, directed) } else { 1.0 }]
    }

    /// The line, from place to place.
    pub fn points(&self, roads: &Roads) -> Vec<Place> {
        let mut line = vec![self.from.place];
        for (i, &directed) in self.edges.iter().enumerate() {
            let points = roads.network.edge_points(directed / 2);
            let forward = directed.is_multiple_of(2);
            let (mut first, mut last) = (0, points.len());
            // Between the places on the edge.
            let (early, late) = if forward {
                (i == 0, i + 1 == self.edges.len())
            } else {
                (i + 1 == self.edges.len(), i == 0)
            };
            let [a, b] = if forward { [self.from, self.to] } else { [self.to, self.from] };
            if early {
                first = a.segment as usize + 1;
            }
            if late {
                last = b.segment as usize + 1;
            }
            let between = points.get(first..last).unwrap_or_default();
            if forward { line.extend(between) } else { line.extend(between.iter().rev()) }
        }
        line.push(self.to.place);
        line.dedup();
        if line.len() == 1 {
            line.push(self.to.place);
        }
        line
    }
}

impl Memory {
    /// Takes down the directed edges that one can begin and end on.
    fn hold(&mut self, roads: &Roads, metric: &Metric, from: &[Position], to: &[Position]) {
        let sides = |position: &Position| {
            let position = *position;
            [2 * position.edge, 2 * position.edge + 1].map(move |directed| (directed, position))
        };
        let open = |(directed, _): &(u32, Position)| metric.edges[*directed as usize].weight < FAR;
        let source = |(directed, position): (u32, Position)| {
            let whole = metric.edges[directed as usize].weight;
            let [_, state] = roads.network.ends(directed);
            let past = metric.vertices[state as usize].weight;
            let weight = whole - before(whole, &position, directed) + past;
            (weight < FAR).then_some(Hold { directed, position, end: End { state, weight } })
        };
        let target = |(directed, position): (u32, Position)| {
            let whole = metric.edges[directed as usize].weight;
            let [state, _] = roads.network.ends(directed);
            let weight = metric.edge_weight(&roads.network, directed, 0, before(whole, &position, directed));
            (weight < FAR).then_some(Hold { directed, position, end: End { state, weight } })
        };
        self.sources.clear();
        self.sources.extend(from.iter().flat_map(sides).filter(open).filter_map(source));
        self.targets.clear();
        self.targets.extend(to.iter().flat_map(sides).filter(open).filter_map(target));
        for (ends, holds) in self.ends.iter_mut().zip([&self.sources, &self.targets]) {
            ends.clear();
            ends.extend(holds.iter().map(|hold| hold.end));
        }
    }
}

/// The lightest way along a single edge.
fn straight(metric: &Metric, from: &[Position], to: &[Position]) -> Option<Leg> {
    let pairs = from.iter().flat_map(|a| to.iter().filter(|b| b.edge == a.edge).map(move |b| (a, b)));
    let ways = pairs.flat_map(|(a, b)| [2 * a.edge, 2 * a.edge + 1].map(|directed| (a, b, directed)));
    let legs = ways.filter_map(|(a, b, directed)| {
        let whole = metric.edges[directed as usize].weight;
        let onwards = directed_share(a, directed) <= directed_share(b, directed);
        let weight = || before(whole, b, directed) - before(whole, a, directed);
        (whole < FAR && onwards).then(|| Leg { weight: weight(), edges: vec![directed], from: *a, to: *b })
    });
    legs.min_by_key(|leg| leg.weight)
}

/// The leg that a row of vertices stands for.
fn unpacked(roads: &Roads, metric: &Metric, weight: u32, states: &[u32], holds: [&[Hold]; 2]) -> Leg {
    let best = |holds: &[Hold], state: u32| {
        holds.iter().filter(|hold| hold.end.state == state).min_by_key(|hold| hold.end.weight).copied()
    };
    let [first, last] = [states[0], states[states.len() - 1]];
    let (source, target) = (best(holds[0], first), best(holds[1], last));
    let weights = &metric.searched(roads).weights.out;
    let arcs = states.windows(2).filter_map(|pair| {
        let out = &roads.vertices.out;
        let slots = out.of(pair[0]).filter(|slot| out.head[*slot] == pair[1]);
        slots.min_by_key(|slot| weights[*slot]).map(|slot| out.via[slot])
    });
    let mut edges: Vec<u32> = source.iter().map(|hold| hold.directed).chain(arcs).collect();
    edges.extend(target.iter().map(|hold| hold.directed));
    // A search begins and ends with what was held.
    let from = source.map_or_else(|| holds[0][0].position, |hold| hold.position);
    let to = target.map_or_else(|| holds[1][0].position, |hold| hold.position);
    Leg { weight, edges, from, to }
}
