//! Vertices and edges from ways and nodes.

use super::read::{Nodes, Square, Way, Ways};
use super::squares;
use super::{Edge, Network, NetworkReport, Rows};
use crate::geo::{Place, distance};
use crate::profile::TIMETABLE;

const NO_VERTEX: u32 = u32::MAX;

pub(super) fn network(mut ways: Ways, nodes: Nodes) -> Network {
    keep_timetables(&mut ways, &nodes);
    let mut uses = uses(&ways, &nodes);
    let crossings = squares::crossings(&ways, &nodes, &mut uses);
    let mut builder = Builder::new(&nodes, &uses);
    for way in &ways.ways {
        builder.way(&ways, way);
    }
    for crossing in &crossings.lines {
        builder.crossing(&ways.squares[crossing.square], crossing.ends);
    }
    builder.report.squares_not_crossed = crossings.too_large + ways.squares_without_outline;
    let report = builder.report;
    let mut network = builder.rows.into_network();
    network.report = report;
    network.report.conditional = ways.conditional;
    network.report.odd_restrictions = ways.odd_restrictions;
    network.restrictions = ways.restrictions.into();
    network.via_ways = ways.via_ways.into();
    network.restriction_words = ways.restriction_sets.into_sets();
    network.way_words = ways.classes.into_sets();
    network.names = ways.names.into_names();
    network.node_words = nodes.sets.into_sets();
    network
}

struct Builder<'a> {
    nodes: &'a Nodes,
    /// For each node its vertex.
    vertex: Vec<u32>,
    rows: Rows,
    report: NetworkReport,
    /// The piece of a way that is being put together: indices of nodes.
    piece: Vec<usize>,
}

impl<'a> Builder<'a> {
    fn new(nodes: &'a Nodes, uses: &[u8]) -> Self {
        let vertex = vertices(nodes, uses);
        let mut rows = Rows::default();
        for (index, _) in vertex
            .iter()
            .enumerate()
            .filter(|(_, vertex)| **vertex != NO_VERTEX)
        {
            rows.vertices.push(nodes.places[index].unwrap_or_default());
            rows.vertex_classes.push(nodes.classes[index]);
            rows.vertex_nodes.push(nodes.ids[index]);
        }
        Self {
            nodes,
            vertex,
            rows,
            report: NetworkReport::default(),
            piece: Vec::new(),
        }
    }

    fn way(&mut self, ways: &Ways, way: &Way) {
        let before = self.rows.edges.len();
        for index in ways.nodes(way).iter().map(|id| self.nodes.index(*id)) {
            let known = index.filter(|i| self.nodes.places[*i].is_some());
            let Some(index) = known else {
                self.piece.clear();
                continue;
            };
            if self.piece.last() == Some(&index) {
                continue;
            }
            self.piece.push(index);
            if self.vertex[index] != NO_VERTEX {
                self.edge(way);
                self.piece.push(index);
            }
        }
        self.piece.clear();
        self.report.ways_without_points += usize::from(self.rows.edges.len() == before);
    }

    /// A straight line across a square.
    fn crossing(&mut self, square: &Square, ends: [usize; 2]) {
        self.piece.clear();
        self.piece.extend(ends);
        let Square {
            id, class, name, ..
        } = *square;
        let way = Way {
            id,
            first: 0,
            count: 0,
            class,
            name,
            seconds: None,
        };
        self.edge(&way);
    }

    /// Makes an edge of the piece, if it is one.
    fn edge(&mut self, way: &Way) {
        if let [first, between @ .., last] = self.piece.as_slice() {
            let places = self
                .piece
                .iter()
                .map(|i| self.nodes.places[*i].unwrap_or_default());
            let length = millimetres(places);
            let first_point = self.rows.points.len() as u32;
            self.rows.points.extend(
                between
                    .iter()
                    .map(|i| self.nodes.places[*i].unwrap_or_default()),
            );
            self.rows
                .nodes
                .extend(between.iter().map(|i| self.nodes.ids[*i]));
            let (from, to) = (self.vertex[*first], self.vertex[*last]);
            let (class, name) = (way.class, way.name);
            self.rows.edges.push(Edge {
                from,
                to,
                length,
                class,
                name,
                first_point,
            });
            self.rows.ways.push(way.id);
        }
        self.piece.clear();
    }
}

/// Gives ferries with a timetable the speed that it asks for.
fn keep_timetables(ways: &mut Ways, nodes: &Nodes) {
    for i in 0..ways.ways.len() {
        let way = ways.ways[i];
        let Some(seconds) = way.seconds else { continue };
        let places = ways
            .nodes(&way)
            .iter()
            .filter_map(|id| nodes.places[nodes.index(*id)?]);
        let metres = f64::from(millimetres(places)) / 1000.0;
        let speed = (metres / seconds * 3.6).clamp(0.1, 100.0);
        ways.ways[i].class = ways
            .classes
            .with(way.class, TIMETABLE, &format!("{speed:.2}"));
    }
}

/// For each node how often it is used: once by each way that goes through it, twice where a run of known nodes begins or ends.
fn uses(ways: &Ways, nodes: &Nodes) -> Vec<u8> {
    let mut uses = vec![0_u8; nodes.ids.len()];
    let mut count = |index: usize, by: u8| uses[index] = uses[index].saturating_add(by);
    for way in &ways.ways {
        let mut last: Option<usize> = None;
        for id in ways.nodes(way) {
            let index = nodes.index(*id).filter(|i| nodes.places[*i].is_some());
            match (last, index) {
                (Some(a), Some(b)) if a == b => continue,
                (None, Some(b)) => count(b, 2),
                (Some(_), Some(b)) => count(b, 1),
                (Some(a), None) => count(a, 1),
                (None, None) => {}
            }
            last = index;
        }
        last.into_iter().for_each(|a| count(a, 1));
    }
    uses
}

/// For each node its vertex: nodes that are used twice, and nodes that have words.
fn vertices(nodes: &Nodes, uses: &[u8]) -> Vec<u32> {
    let mut vertices = 0;
    let number = |(index, uses): (usize, &u8)| {
        let known = nodes.places[index].is_some();
        if known && (*uses >= 2 || (*uses == 1 && nodes.classes[index] != 0)) {
            vertices += 1;
            vertices - 1
        } else {
            NO_VERTEX
        }
    };
    uses.iter().enumerate().map(number).collect()
}

fn millimetres(points: impl Iterator<Item = Place> + Clone) -> u32 {
    let metres: f64 = points
        .clone()
        .zip(points.skip(1))
        .map(|(a, b)| distance(a, b))
        .sum();
    libm::round(metres * 1000.0) as u32
}
