//! The edges of a route, and what travelling them takes.

use crate::metric::Metric;
use crate::network::Network;
use crate::position::Position;
use crate::roads::Roads;

/// The route between two places.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Its weight.
    pub weight: u32,
    /// Directed edges in order: twice the edge's number, plus one against its direction. Of the
    /// first and the last one only a part is travelled.
    pub edges: Vec<u32>,
    /// Where it begins, on the first edge.
    pub from: Position,
    /// Where it ends, on the last edge.
    pub to: Position,
}

/// What a part of a route takes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measures {
    /// Metres.
    pub length: f64,
    /// Hundredths of a second.
    pub duration: u32,
    /// The weight, hundredths of a second.
    pub weight: u32,
}

/// The length and the duration of a route.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LengthAndDuration {
    /// Metres.
    pub length: f64,
    /// Hundredths of a second.
    pub duration: u32,
}

impl Leg {
    /// Its length and duration.
    pub fn length_and_duration(&self, roads: &Roads, metric: &Metric) -> LengthAndDuration {
        let edges = (0..self.edges.len()).map(|i| self.measures(roads, metric, i));
        edges.fold(LengthAndDuration::default(), |sum, edge| {
            LengthAndDuration {
                length: sum.length + edge.length,
                duration: sum.duration + edge.duration,
            }
        })
    }

    /// What travelling the edge of that index takes, together with passing the vertex at its end.
    pub fn measures(&self, roads: &Roads, metric: &Metric, index: usize) -> Measures {
        let directed = self.edges[index];
        let cost = metric.edges[directed as usize];
        // A vertex and its turn count for the edge before them, the entry to private ground for the
        // edge that is entered.
        let passed = match self.edges.get(index + 1) {
            // The goal is before the vertex at the edge's end, which is not passed.
            None => Default::default(),
            Some(next) => metric.passing(roads, directed, *next),
        };
        let entry = match index.checked_sub(1) {
            None => 0,
            Some(before) => metric.entry_weight(roads, self.edges[before], directed),
        };
        Measures {
            length: self.length(&roads.network, index),
            duration: self.part_of(cost.duration(), index) + passed.duration,
            weight: self.part_of(cost.weight(), index) + passed.weight + entry,
        }
    }

    /// Metres travelled on the edge of that index.
    fn length(&self, network: &Network, index: usize) -> f64 {
        let edge = &network.edges[self.edges[index] as usize / 2];
        let [begin, end] = self.travelled(index);
        f64::from(edge.length) / 1000.0 * (end - begin)
    }

    /// That part of a whole edge's cost that belongs to what is travelled of it.
    fn part_of(&self, whole: u32, index: usize) -> u32 {
        let directed = self.edges[index];
        let first = if index == 0 {
            cost_before(whole, &self.from, directed)
        } else {
            0
        };
        let is_last = index + 1 == self.edges.len();
        if is_last {
            // No underflow: a leg within one edge ends at or behind the place where it begins.
            cost_before(whole, &self.to, directed) - first
        } else {
            whole - first
        }
    }

    /// The shares of the edge of that index between which it is travelled, 0 at its begin and 1
    /// at its end.
    pub fn travelled(&self, index: usize) -> [f64; 2] {
        let directed = self.edges[index];
        let begin = if index == 0 {
            self.from.share_before(directed)
        } else {
            0.0
        };
        let is_last = index + 1 == self.edges.len();
        let end = if is_last {
            self.to.share_before(directed)
        } else {
            1.0
        };
        [begin, end]
    }
}

/// The part of a cost that belongs to a share of an edge.
#[inline]
pub(super) fn part(whole: u32, share: f64) -> u32 {
    libm::round(f64::from(whole) * share) as u32
}

/// The part of a directed edge's cost before a place on it. Against the edge's direction it is the
/// difference to the whole, so that two parts of an edge always add up exactly.
#[inline]
pub(super) fn cost_before(whole: u32, position: &Position, directed: u32) -> u32 {
    let forward = part(whole, position.share);
    if directed.is_multiple_of(2) {
        forward
    } else {
        whole - forward
    }
}
