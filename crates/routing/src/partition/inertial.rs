//! Bisection of a graph with few edges between the halves.
//!
//! A. Schild, C. Sommer, *On balanced separators in road networks*, SEA 2015: order the vertices
//! along a line, keep the first and the last quarter apart, and find the minimum cut between them.
//! The best of several lines counts.

use super::flow::{Flow, Graph, Role};
use crate::geo::Place;

/// A part of the network that is to be bisected.
#[derive(Debug)]
pub(super) struct Part {
    /// Numbers of its vertices in the whole network.
    pub(super) vertices: Vec<u32>,
    places: Vec<Place>,
    graph: Graph,
}

/// The share of vertices that is fixed on each side, as a divisor.
const FIXED_SHARE: usize = 4;
/// The lines, as weights of longitude and latitude.
const LINES: [[i64; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

impl Part {
    /// A whole network. Its vertices are ordered along a Hilbert curve, so that vertices that a
    /// flow passes one after another are close in memory.
    pub(super) fn new(places: &[Place], edges: &[[u32; 2]]) -> Self {
        let mut vertices: Vec<u32> = (0..places.len() as u32).collect();
        vertices.sort_by_cached_key(|vertex| places[*vertex as usize].hilbert());
        let mut number = vec![0; places.len()];
        for (i, vertex) in (0..).zip(&vertices) {
            number[*vertex as usize] = i;
        }
        let edges = edges
            .iter()
            .map(|ends| ends.map(|end| number[end as usize]));
        let graph = Graph::new(places.len(), edges);
        let places = vertices
            .iter()
            .map(|vertex| places[*vertex as usize])
            .collect();
        Self {
            vertices,
            places,
            graph,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The vertices on one side as a part of their own: those that are inside, or those that are
    /// not.
    fn side(&self, inside: &[bool], of: bool) -> Self {
        let mut number = vec![u32::MAX; self.len()];
        let members: Vec<u32> = (0..self.len() as u32)
            .filter(|vertex| inside[*vertex as usize] == of)
            .collect();
        for (i, member) in (0..).zip(&members) {
            number[*member as usize] = i;
        }
        let edges = members.iter().flat_map(|&vertex| {
            let heads = self.graph.slots(vertex).map(|slot| self.graph.head[slot]);
            // Each edge is stored at both of its ends, and is taken once.
            heads
                .filter(move |&head| vertex < head)
                .map(move |head| [vertex, head])
        });
        let edges = edges.filter(|[_, head]| inside[*head as usize] == of);
        let edges = edges.map(|ends| ends.map(|end| number[end as usize]));
        Self {
            vertices: members
                .iter()
                .map(|vertex| self.vertices[*vertex as usize])
                .collect(),
            places: members
                .iter()
                .map(|vertex| self.places[*vertex as usize])
                .collect(),
            graph: Graph::new(members.len(), edges),
        }
    }
}

/// Bisects parts. Its memory is used again for the next one.
#[derive(Debug, Default)]
pub(super) struct Halver {
    flow: Flow,
    order: Vec<(i64, u32)>,
    roles: Vec<Role>,
    inside: Vec<bool>,
    best: Vec<bool>,
}

impl Halver {
    /// Bisects a part of two vertices or more.
    pub(super) fn halve(&mut self, part: &Part) -> [Part; 2] {
        let count = part.len();
        // Edges cut times vertices on the larger side, then these vertices alone.
        let mut best = (usize::MAX, 0);
        for line in LINES {
            self.hold_ends(part, line);
            // The larger side has at least half of the vertices. A cut of more edges than this
            // cannot be better, and its flow is given up early. The first line has no limit, so
            // some cut is always found.
            let limit = best.0 / count.div_ceil(2);
            let Some(cut) = self.flow.largest(&part.graph, &self.roles, limit) else {
                continue;
            };
            // Of all minimum cuts the one nearest to the sources and the one nearest to the sinks:
            // the more balanced counts.
            for from_sinks in [false, true] {
                self.flow
                    .side(&part.graph, &self.roles, from_sinks, &mut self.inside);
                let size = self.inside.iter().filter(|inside| **inside).count();
                let larger = size.max(count - size);
                if (cut * larger, larger) < best {
                    best = (cut * larger, larger);
                    std::mem::swap(&mut self.best, &mut self.inside);
                }
            }
        }
        [true, false].map(|of| part.side(&self.best, of))
    }

    fn hold_ends(&mut self, part: &Part, line: [i64; 2]) {
        let along = |p: &Place| line[0] * i64::from(p.lon) + line[1] * i64::from(p.lat);
        self.order.clear();
        self.order.extend(
            part.places
                .iter()
                .zip(0..)
                .map(|(place, i)| (along(place), i)),
        );
        // At least one vertex on each side, so that neither half is empty.
        let (count, held) = (
            part.len(),
            part.len().div_ceil(FIXED_SHARE).min(part.len() / 2),
        );
        // Only the first and the last `held` are needed, not a sorted order. Vertex numbers break
        // ties, so that the result is unique.
        self.order.select_nth_unstable(held);
        self.order[held..].select_nth_unstable(count - held - held);
        self.roles.clear();
        self.roles.resize(count, Role::Free);
        for (_, vertex) in &self.order[..held] {
            self.roles[*vertex as usize] = Role::Source;
        }
        for (_, vertex) in &self.order[count - held..] {
            self.roles[*vertex as usize] = Role::Sink;
        }
    }
}
