//! The way from one place on the network to another.

use std::collections::HashSet;

use crate::geo::Place;
use crate::metric::{Metric, centimetres};
use crate::overlay::FAR;
use crate::position::Position;
use crate::roads::Roads;
use crate::search::{End, Path, Searched, TableMemory, Value, ValuedEnd, Workspace};

/// How much heavier another way may be than the lightest one, as a factor.
const STRETCH: f64 = 1.25;
/// How much of the lightest way another one may share.
const SHARED: f64 = 0.75;
/// How many other ways are looked at.
const CANDIDATES: usize = 64;

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

/// What a part of a leg takes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measures {
    /// Metres.
    pub length: f64,
    /// Hundredths of a second.
    pub duration: u32,
    /// Hundredths of a second, as they count.
    pub weight: u32,
}

/// A directed edge at one of a leg's ends.
#[derive(Debug, Clone, Copy)]
struct Hold {
    directed: u32,
    position: Position,
    end: End,
    /// What the part of the edge takes.
    value: Value,
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

/// One of a directed edge's two costs before a place on it.
fn before(whole: u32, position: &Position, directed: u32) -> u32 {
    let forward = part(whole, position.share);
    if directed.is_multiple_of(2) {
        forward
    } else {
        whole - forward
    }
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
        let Memory {
            workspace,
            path,
            sources,
            targets,
            ends,
        } = memory;
        let around = workspace.route(metric.searched(roads), &ends[0], &ends[1], path);
        match (straight, around) {
            (Some(straight), around) if around.is_none_or(|weight| straight.weight <= weight) => {
                Some(straight)
            }
            (_, Some(weight)) => {
                let leg = unpacked(roads, metric, weight, &path.states, [sources, targets]);
                Some(leg.trimmed(roads, metric))
            }
            (straight, None) => straight,
        }
    }

    /// The lightest way and up to `others` other ones that a traveller might choose, the lightest first.
    ///
    /// I. Abraham, D. Delling, A. Goldberg, R. Werneck, *Alternative routes in road networks*, 2013: a way through a place aside is admitted
    /// if it is at most a quarter heavier than the lightest one, shares at most three quarters of it (and of those admitted before), and is
    /// locally optimal: for a quarter of the lightest way's weight round that place there is no lighter way.
    pub fn alternatives(
        roads: &Roads,
        metric: &Metric,
        from: &[Position],
        to: &[Position],
        others: usize,
        memory: &mut Memory,
    ) -> Vec<Self> {
        let Some(best) = Self::find(roads, metric, from, to, memory) else {
            return Vec::new();
        };
        let mut legs = vec![best];
        if legs[0].edges.len() < 2 {
            return legs;
        }
        memory.hold(roads, metric, from, to);
        let Memory {
            workspace,
            path,
            sources,
            targets,
            ends,
        } = memory;
        let graph = metric.searched(roads);
        let ways = workspace.ways(graph, &ends[0], &ends[1], STRETCH, CANDIDATES);
        for (weight, states) in ways {
            if legs.len() > others {
                break;
            }
            let leg =
                unpacked(roads, metric, weight, &states, [sources, targets]).trimmed(roads, metric);
            let most =
                |known: &Self| SHARED * known.edge_weight(metric).min(f64::from(legs[0].weight));
            let new = legs
                .iter()
                .all(|known| leg.shared(metric, known) <= most(known));
            if new
                && is_simple(&states)
                && is_locally_optimal(graph, &states, legs[0].weight, workspace, path)
            {
                legs.push(leg);
            }
        }
        legs
    }

    /// What the lightest way from each of some places to each of others takes, one after another; `None` where there is none. Lengths are
    /// 0 unless they are asked for.
    pub fn table(
        roads: &Roads,
        metric: &Metric,
        from: &[&[Position]],
        to: &[&[Position]],
        lengths: bool,
        memory: &mut Memory,
        tables: &mut TableMemory,
    ) -> Vec<Option<Measures>> {
        let mut held = |from: &[Position], to: &[Position]| {
            memory.hold(roads, metric, from, to);
            let holds = if to.is_empty() {
                &memory.sources
            } else {
                &memory.targets
            };
            holds
                .iter()
                .map(|hold| ValuedEnd {
                    end: hold.end,
                    value: hold.value,
                })
                .collect()
        };
        let sources: Vec<Vec<ValuedEnd>> = from.iter().map(|place| held(place, &[])).collect();
        let targets: Vec<Vec<ValuedEnd>> = to.iter().map(|place| held(&[], place)).collect();
        // Where everything counts as long as it takes, durations need no sums of their own.
        let plain = !lengths && metric.weight_is_duration();
        let values = (!plain).then(|| metric.values(roads));
        let found = tables.table(
            &mut memory.workspace,
            metric.searched(roads),
            values,
            &sources,
            &targets,
        );
        let pairs = from.iter().flat_map(|a| to.iter().map(move |b| (a, b)));
        let measures = found.into_iter().zip(pairs).map(|(found, (a, b))| {
            let around = (found.weight < FAR).then(|| Measures {
                length: f64::from(found.value[1]) / 100.0,
                duration: if plain { found.weight } else { found.value[0] },
                weight: found.weight,
            });
            let straight = straight(metric, a, b);
            match (straight, around) {
                (Some(leg), around) if around.is_none_or(|around| leg.weight <= around.weight) => {
                    Some(leg.measures(roads, metric, 0))
                }
                (_, around) => around,
            }
        });
        measures.collect()
    }

    /// Without edges at its ends of which nothing is travelled and nothing else is to be done: one is at their other end already.
    fn trimmed(mut self, roads: &Roads, metric: &Metric) -> Self {
        let nothing = |leg: &Self, index: usize| {
            let [begin, end] = leg.travelled(index);
            begin == end && leg.measures(roads, metric, index) == Measures::default()
        };
        let at = |position: &Position, directed: u32, end: bool| {
            let last = directed.is_multiple_of(2) == end;
            let points = roads.network.edge_points(directed / 2).len() as u32;
            let (share, segment) = if last { (1.0, points - 2) } else { (0.0, 0) };
            Position {
                edge: directed / 2,
                share,
                segment,
                ..*position
            }
        };
        while let [first, second, ..] = self.edges[..] {
            let free = metric.entry_weight(roads, first, second) == 0;
            if !(free && nothing(&self, 0)) {
                break;
            }
            self.edges.remove(0);
            self.from = at(&self.from, second, false);
        }
        while let [.., before, last] = self.edges[..] {
            let free = metric.passing(roads, before, last) == [0, 0];
            if !(free && nothing(&self, self.edges.len() - 1)) {
                break;
            }
            self.edges.pop();
            self.to = at(&self.to, before, true);
        }
        self
    }

    /// The weight of those edges that both have.
    fn shared(&self, metric: &Metric, other: &Self) -> f64 {
        let others: HashSet<u32> = other.edges.iter().copied().collect();
        let shared = self.edges.iter().filter(|edge| others.contains(edge));
        shared
            .map(|edge| f64::from(metric.edges[*edge as usize].weight()))
            .sum()
    }

    /// The weight of all its edges.
    fn edge_weight(&self, metric: &Metric) -> f64 {
        self.edges
            .iter()
            .map(|edge| f64::from(metric.edges[*edge as usize].weight()))
            .sum()
    }

    /// Metres, hundredths of a second.
    pub fn length_and_duration(&self, roads: &Roads, metric: &Metric) -> (f64, u32) {
        let edges = (0..self.edges.len()).map(|i| self.measures(roads, metric, i));
        edges.fold((0.0, 0), |(length, duration), edge| {
            (length + edge.length, duration + edge.duration)
        })
    }

    /// What travelling the edge of that index takes, with the vertex at its end.
    pub fn measures(&self, roads: &Roads, metric: &Metric, index: usize) -> Measures {
        let directed = self.edges[index];
        let cost = metric.edges[directed as usize];
        let last = index + 1 == self.edges.len();
        let [begin, end] = self.travelled(index);
        let length =
            f64::from(roads.network.edges[directed as usize / 2].length) / 1000.0 * (end - begin);
        let travelled = |whole: u32| {
            let first = if index == 0 {
                before(whole, &self.from, directed)
            } else {
                0
            };
            if last {
                before(whole, &self.to, directed) - first
            } else {
                whole - first
            }
        };
        let past = if last {
            [0, 0]
        } else {
            metric.passing(roads, directed, self.edges[index + 1])
        };
        let before_it = index.checked_sub(1).map(|i| self.edges[i]);
        let entry = before_it.map_or(0, |from| metric.entry_weight(roads, from, directed));
        Measures {
            length,
            duration: travelled(cost.duration()) + past[0],
            weight: travelled(cost.weight()) + past[1] + entry,
        }
    }

    /// From which share of its edge to which one the edge of that index is travelled.
    pub fn travelled(&self, index: usize) -> [f64; 2] {
        let directed = self.edges[index];
        let begin = if index == 0 {
            self.from.share_before(directed)
        } else {
            0.0
        };
        let last = index + 1 == self.edges.len();
        [
            begin,
            if last {
                self.to.share_before(directed)
            } else {
                1.0
            },
        ]
    }

    /// The line, from place to place.
    pub fn line(&self, roads: &Roads) -> Line {
        let mut line = Line {
            points: vec![self.from.place],
            ends: Vec::with_capacity(self.edges.len()),
        };
        for (i, &directed) in self.edges.iter().enumerate() {
            let points = roads.network.edge_points(directed / 2);
            let forward = directed.is_multiple_of(2);
            let (begins, ends) = (i == 0, i + 1 == self.edges.len());
            // Between the places on the edge, in its own direction.
            let [a, b] = if forward {
                [&self.from, &self.to]
            } else {
                [&self.to, &self.from]
            };
            let [first_here, last_here] = if forward {
                [begins, ends]
            } else {
                [ends, begins]
            };
            let first = if first_here {
                a.segment as usize + 1
            } else {
                0
            };
            let last = if last_here {
                b.segment as usize + 1
            } else {
                points.len()
            };
            let between = points.part(first, last);
            if forward {
                between.for_each(|point| line.push(point));
            } else {
                between.rev().for_each(|point| line.push(point));
            }
            if ends {
                line.push(self.to.place);
            }
            line.ends.push(line.points.len() - 1);
        }
        line
    }
}

/// The line of a leg.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Line {
    /// Its points; no two neighbours are the same place.
    pub points: Vec<Place>,
    /// For each of the leg's edges the index of its last point.
    pub ends: Vec<usize>,
}

impl Line {
    fn push(&mut self, point: Place) {
        if self.points.last() != Some(&point) {
            self.points.push(point);
        }
    }

    /// The points of some of the leg's edges; at least one, at the leg's end.
    pub fn part(&self, edges: std::ops::Range<usize>) -> &[Place] {
        let first = edges
            .start
            .checked_sub(1)
            .map_or(0, |before| self.ends[before]);
        let last = edges.end.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.points[first..=last.max(first)]
    }
}

impl Memory {
    /// Takes down the directed edges that one can begin and end on.
    fn hold(&mut self, roads: &Roads, metric: &Metric, from: &[Position], to: &[Position]) {
        self.sources.clear();
        self.sources.extend(
            open_sides(metric, from).map(|(directed, at)| source(roads, metric, directed, at)),
        );
        self.targets.clear();
        for (directed, at) in open_sides(metric, to) {
            self.hold_target(roads, metric, directed, at);
        }
        self.sources.retain(|hold| hold.end.weight < FAR);
        self.targets.retain(|hold| hold.end.weight < FAR);
        for (ends, holds) in self.ends.iter_mut().zip([&self.sources, &self.targets]) {
            ends.clear();
            ends.extend(holds.iter().map(|hold| hold.end));
        }
    }

    /// Takes down the ends that one can reach a place from along a directed edge.
    fn hold_target(&mut self, roads: &Roads, metric: &Metric, directed: u32, position: Position) {
        let cost = metric.edges[directed as usize];
        let [first, time] =
            [cost.weight(), cost.duration()].map(|whole| before(whole, &position, directed));
        let length = part(
            centimetres(roads, directed),
            position.share_before(directed),
        );
        let Some(turns) = &metric.turns else {
            let [state, _] = roads.network.ends(directed);
            let end = End {
                state,
                weight: metric.edge_weight(&roads.network, directed, first),
            };
            return self.targets.push(Hold {
                directed,
                position,
                end,
                value: [time, length],
            });
        };
        // By each turn into the edge.
        let graph = metric.searched(roads);
        let incoming = graph.overlay.incoming();
        let slots = turns
            .states_of(directed)
            .flat_map(|state| incoming.of(state));
        for slot in slots.filter(|slot| graph.weights.into[*slot] < FAR) {
            let from = incoming.head[slot];
            let end = End {
                state: from,
                weight: graph.weights.into[slot] - cost.weight() + first,
            };
            let [passed, _] = metric.passing(roads, turns.edge_of[from as usize], directed);
            self.targets.push(Hold {
                directed,
                position,
                end,
                value: [time + passed, length],
            });
        }
    }
}

/// The directions in which places may be left or reached.
fn open_sides<'a>(
    metric: &'a Metric,
    positions: &'a [Position],
) -> impl Iterator<Item = (u32, Position)> + 'a {
    let sides = positions
        .iter()
        .flat_map(|at| [(2 * at.edge, *at), (2 * at.edge + 1, *at)]);
    sides.filter(|(directed, at)| {
        at.open[*directed as usize % 2] && metric.edges[*directed as usize].is_open()
    })
}

/// The end that one goes on from who leaves a place along a directed edge.
fn source(roads: &Roads, metric: &Metric, directed: u32, position: Position) -> Hold {
    let cost = metric.edges[directed as usize];
    let [weight, time] =
        [cost.weight(), cost.duration()].map(|whole| whole - before(whole, &position, directed));
    let length = part(
        centimetres(roads, directed),
        1.0 - position.share_before(directed),
    );
    let (state, past) = match &metric.turns {
        Some(turns) => (turns.state_of[directed as usize], [0, 0]),
        None => {
            let [_, state] = roads.network.ends(directed);
            let vertex = metric.vertices[state as usize];
            (state, [vertex.weight(), vertex.duration()])
        }
    };
    let end = End {
        state,
        weight: weight + past[0],
    };
    Hold {
        directed,
        position,
        end,
        value: [time + past[1], length],
    }
}

fn is_simple(states: &[u32]) -> bool {
    let mut sorted = states.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|pair| pair[0] != pair[1])
}

/// Whether every stretch of a quarter of `best` on either side of the way's middle, moved along it, is a lightest way: looked at where the
/// two trees meet it cannot be told here, so all along in steps of one stretch.
fn is_locally_optimal(
    graph: Searched<'_>,
    states: &[u32],
    best: u32,
    workspace: &mut Workspace,
    path: &mut Path,
) -> bool {
    let weight = |pair: &[u32]| {
        let out = &graph.overlay.out;
        out.of(pair[0])
            .filter(|slot| out.head[*slot] == pair[1])
            .map(|slot| graph.weights.out[slot])
            .min()
            .unwrap_or(FAR)
    };
    let stretch = best / 4;
    let mut along = vec![0_u32];
    for pair in states.windows(2) {
        along.push(along[along.len() - 1].saturating_add(weight(pair)));
    }
    let mut first = 0;
    while first + 1 < states.len() {
        let end = along
            .partition_point(|a| *a <= along[first] + 2 * stretch)
            .clamp(first + 2, states.len())
            - 1;
        let ends = [first, end].map(|i| {
            [End {
                state: states[i],
                weight: 0,
            }]
        });
        if workspace
            .route(graph, &ends[0], &ends[1], path)
            .is_none_or(|w| w < along[end] - along[first])
        {
            return false;
        }
        if end + 1 == states.len() {
            return true;
        }
        first = along
            .partition_point(|a| *a <= along[first] + stretch)
            .max(first + 1);
    }
    true
}

/// The lightest way along a single edge.
fn straight(metric: &Metric, from: &[Position], to: &[Position]) -> Option<Leg> {
    let pairs = from
        .iter()
        .flat_map(|a| to.iter().filter(|b| b.edge == a.edge).map(move |b| (a, b)));
    let ways =
        pairs.flat_map(|(a, b)| [2 * a.edge, 2 * a.edge + 1].map(|directed| (a, b, directed)));
    let legs = ways.filter_map(|(a, b, directed)| {
        let whole = metric.edges[directed as usize].weight();
        let onwards = a.share_before(directed) <= b.share_before(directed);
        let weight = || before(whole, b, directed) - before(whole, a, directed);
        let open = a.open[directed as usize % 2] && b.open[directed as usize % 2];
        (whole < FAR && onwards && open).then(|| Leg {
            weight: weight(),
            edges: vec![directed],
            from: *a,
            to: *b,
        })
    });
    legs.min_by_key(|leg| leg.weight)
}

/// The leg that a row of vertices stands for.
fn unpacked(
    roads: &Roads,
    metric: &Metric,
    weight: u32,
    states: &[u32],
    holds: [&[Hold]; 2],
) -> Leg {
    let best = |holds: &[Hold], state: u32| {
        holds
            .iter()
            .filter(|hold| hold.end.state == state)
            .min_by_key(|hold| hold.end.weight)
            .copied()
    };
    let [first, last] = [states[0], states[states.len() - 1]];
    let (source, target) = (best(holds[0], first), best(holds[1], last));
    let mut edges = match &metric.turns {
        Some(turns) => states
            .iter()
            .map(|state| turns.edge_of[*state as usize])
            .collect(),
        None => {
            let graph = metric.searched(roads);
            let (out, weights) = (&graph.overlay.out, &graph.weights.out);
            let arcs = states.windows(2).filter_map(|pair| {
                let slots = out.of(pair[0]).filter(|slot| out.head[*slot] == pair[1]);
                slots
                    .min_by_key(|slot| weights[*slot])
                    .map(|slot| out.via[slot])
            });
            source
                .iter()
                .map(|hold| hold.directed)
                .chain(arcs)
                .collect::<Vec<u32>>()
        }
    };
    edges.extend(target.iter().map(|hold| hold.directed));
    // A search begins and ends with what was held.
    let from = source.map_or_else(|| holds[0][0].position, |hold| hold.position);
    let to = target.map_or_else(|| holds[1][0].position, |hold| hold.position);
    Leg {
        weight,
        edges,
        from,
        to,
    }
}
