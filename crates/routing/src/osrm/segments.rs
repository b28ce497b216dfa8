//! The segments of a leg, for annotations.

use super::service::Service;
use crate::costs::UNITS_PER_SECOND;
use crate::geo::{Place, distance};
use crate::leg::{Leg, Line, Measures};
use crate::metric::PassingCost;

/// A segment that is travelled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Metres.
    pub(super) length: f64,
    /// Hundredths of a second.
    pub(super) duration: f64,
    /// Hundredths of a second.
    pub(super) weight: f64,
    /// The OSM nodes at its ends.
    pub(super) nodes: [i64; 2],
}

impl Segment {
    /// Metres per second; 0 if it takes no time.
    pub(super) fn speed(&self) -> f64 {
        if self.duration > 0.0 {
            self.length / self.duration * UNITS_PER_SECOND
        } else {
            0.0
        }
    }
}

impl Service {
    /// The segments of a leg. Duration and weight of an edge are shared out by length.
    pub(super) fn segments(&self, leg: &Leg, line: &Line) -> Vec<Segment> {
        let mut segments = Vec::new();
        for (i, &directed) in leg.edges.iter().enumerate() {
            let points = line.part(i..i + 1);
            let Measures {
                length,
                duration,
                weight,
            } = leg.measures(&self.roads, &self.metric, i);
            // Turns, barriers and the entry to private ground belong to no segment. They are taken
            // out of the edge's measures before these are shared out.
            let passed = match leg.edges.get(i + 1) {
                None => PassingCost::default(),
                Some(next) => self.metric.passing(&self.roads, directed, *next),
            };
            let entry = match i.checked_sub(1) {
                None => 0,
                Some(i) => self
                    .metric
                    .entry_weight(&self.roads, leg.edges[i], directed),
            };
            let nodes = self.nodes(leg, i);
            for (pair, ids) in points.windows(2).zip(nodes.windows(2)) {
                let metres = distance(pair[0], pair[1]);
                let share = if length > 0.0 { metres / length } else { 0.0 };
                segments.push(Segment {
                    length: metres,
                    duration: f64::from(duration - passed.duration) * share,
                    weight: f64::from(weight - passed.weight - entry) * share,
                    nodes: [ids[0], ids[1]],
                });
            }
        }
        segments
    }

    /// The OSM nodes of the part of an edge that is travelled, one for each of its points. For a
    /// point within a segment, the node at the segment's far end.
    pub(super) fn nodes(&self, leg: &Leg, index: usize) -> Vec<i64> {
        let directed = leg.edges[index];
        let network = &self.roads.network;
        let places = network.edge_points(directed / 2);
        let ids = network.edge_nodes(directed / 2);
        let is_forward = directed.is_multiple_of(2);
        let [a, b] = if is_forward {
            [&leg.from, &leg.to]
        } else {
            [&leg.to, &leg.from]
        };
        let part = leg.travelled_part(index, ids.len());
        // Built exactly as the leg's line is, so that nodes and points correspond one to one.
        let mut along = NodesAlong::default();
        if part.begins_within {
            along.push_within(a.place, ids.at(a.segment as usize));
        }
        for i in part.points {
            along.push_node(places.at(i), ids.at(i));
        }
        if part.ends_within {
            along.push_within(b.place, ids.at(b.segment as usize + 1));
        }
        let mut nodes: Vec<i64> = along.0.into_iter().map(|(_, node)| node).collect();
        // `travelled_part` is in the edge's own direction, the leg may run against it.
        if !is_forward {
            nodes.reverse();
        }
        nodes
    }
}

/// Points of an edge with their nodes. As in a [`Line`], no two neighbours are the same place.
#[derive(Default)]
struct NodesAlong(Vec<(Place, i64)>);

impl NodesAlong {
    /// Adds a node. If the last point is the same place, its node is replaced: a real node counts
    /// before the one that stands for a point within a segment.
    fn push_node(&mut self, place: Place, node: i64) {
        match self.0.last_mut() {
            Some(last) if last.0 == place => last.1 = node,
            _ => self.0.push((place, node)),
        }
    }

    /// Adds a point within a segment, which `node` stands for, unless the last point is the same
    /// place.
    fn push_within(&mut self, place: Place, node: i64) {
        if self.0.last().is_none_or(|last| last.0 != place) {
            self.0.push((place, node));
        }
    }
}
