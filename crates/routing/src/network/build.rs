//! Vertices and edges from ways and nodes.

use openbench_osm::OsmError;
use openbench_osm::visitor::{Elements, TagRef};

use super::elements::{Nodes, Square, Way, Ways};
use super::graph::{Edge, Network, NetworkReport, Rows};
use super::squares;
use crate::geo::{Place, distance};
use crate::profile::TIMETABLE;

const NO_VERTEX: u32 = u32::MAX;

impl Network {
    /// The network of a map.
    ///
    /// # Errors
    /// If the map is malformed.
    pub fn read(source: &impl Elements) -> Result<Self, OsmError> {
        let ways = Ways::read(source)?;
        let nodes = Nodes::read(source, &ways)?;
        Ok(network(ways, nodes))
    }
}

fn network(mut ways: Ways, nodes: Nodes) -> Network {
    // Before edges are made, because it gives ways another class.
    keep_timetables(&mut ways, &nodes);
    let mut uses = uses(&ways, &nodes);
    // Also before: ends of lines across squares become vertices, at which ways are divided.
    let crossings = squares::crossings(&ways, &nodes, &mut uses);
    let mut builder = Builder::new(&nodes, &uses);
    for way in &ways.ways {
        builder.way(&ways, way);
    }
    for crossing in &crossings.lines {
        builder.crossing(&ways.squares[crossing.square], crossing.ends);
    }
    let report = NetworkReport {
        ways_without_points: builder.ways_without_points,
        conditional: ways.conditional,
        odd_restrictions: ways.odd_restrictions,
        squares_not_crossed: crossings.too_large + ways.squares_without_outline,
    };
    let rows = builder.rows;
    Network {
        restrictions: ways.restrictions.into(),
        via_ways: ways.via_ways.into(),
        restriction_tags: ways.restriction_sets.into_sets(),
        way_tags: ways.classes.into_sets(),
        names: ways.names.into_names(),
        node_tags: nodes.sets.into_sets(),
        report,
        ..rows.into_network()
    }
}

/// Puts rows together, way by way.
struct Builder<'a> {
    nodes: &'a Nodes,
    /// For each node its vertex.
    vertex: Vec<u32>,
    rows: Rows,
    ways_without_points: usize,
    /// The piece of a way that is being put together: indices of nodes.
    piece: Vec<usize>,
}

impl<'a> Builder<'a> {
    fn new(nodes: &'a Nodes, uses: &[u8]) -> Self {
        let vertex = vertices(nodes, uses);
        let mut rows = Rows::default();
        for (index, vertex) in vertex.iter().enumerate() {
            if *vertex != NO_VERTEX {
                rows.vertices.push(nodes.places[index].unwrap_or_default());
                rows.vertex_classes.push(nodes.classes[index]);
                rows.vertex_nodes.push(nodes.ids[index]);
            }
        }
        Self {
            nodes,
            vertex,
            rows,
            ways_without_points: 0,
            piece: Vec::new(),
        }
    }

    fn way(&mut self, ways: &Ways, way: &Way) {
        let before = self.rows.edges.len();
        for id in ways.nodes(way) {
            let Some(index) = self.nodes.known(*id) else {
                // A node that the map lacks ends the piece: joining across the gap would invent a
                // road.
                self.piece.clear();
                continue;
            };
            // A node named twice in a row would make a segment without length.
            if self.piece.last() == Some(&index) {
                continue;
            }
            self.piece.push(index);
            if self.vertex[index] != NO_VERTEX {
                // The piece up to here is an edge, and the vertex begins the next one.
                self.edge(way);
                self.piece.push(index);
            }
        }
        self.piece.clear();
        self.ways_without_points += usize::from(self.rows.edges.len() == before);
    }

    /// A straight line across a square.
    fn crossing(&mut self, square: &Square, ends: [usize; 2]) {
        self.piece.clear();
        self.piece.extend(ends);
        let Square {
            id, class, name, ..
        } = *square;
        // The fields about nodes and timetables are not read by `edge`.
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

    /// Makes an edge of the piece, if it has two nodes or more.
    fn edge(&mut self, way: &Way) {
        if let [first, between @ .., last] = self.piece.as_slice() {
            let first_point = self.rows.points.len() as u32;
            self.rows
                .points
                .extend(between.iter().map(|index| place(self.nodes, *index)));
            self.rows
                .nodes
                .extend(between.iter().map(|index| self.nodes.ids[*index]));
            self.rows.edges.push(Edge {
                from: self.vertex[*first],
                to: self.vertex[*last],
                length: millimetres(self.piece.iter().map(|index| place(self.nodes, *index))),
                class: way.class,
                name: way.name,
                first_point,
            });
            self.rows.ways.push(way.id);
        }
        self.piece.clear();
    }
}

fn place(nodes: &Nodes, index: usize) -> Place {
    nodes.places[index].unwrap_or_default()
}

/// Gives ferries with a timetable the speed that follows from it.
fn keep_timetables(ways: &mut Ways, nodes: &Nodes) {
    for i in 0..ways.ways.len() {
        let way = ways.ways[i];
        let Some(seconds) = way.seconds else { continue };
        let nodes_of_way = ways.nodes(&way).iter();
        let places = nodes_of_way.filter_map(|id| nodes.places[nodes.index(*id)?]);
        let metres = f64::from(millimetres(places)) / 1000.0;
        // Within the range that `timetable_speed` of a profile accepts.
        let speed = format!("{:.2}", (metres / seconds * 3.6).clamp(0.1, 100.0));
        ways.ways[i].class = ways.classes.with(way.class, TagRef::new(TIMETABLE, &speed));
    }
}

/// For each node how often it is used: once by each way that goes through it, twice where a run of
/// known nodes begins or ends.
fn uses(ways: &Ways, nodes: &Nodes) -> Vec<u8> {
    let mut uses = vec![0_u8; nodes.ids.len()];
    // Saturating, because counts are compared with 4 at most.
    let mut count = |index: usize, by: u8| uses[index] = uses[index].saturating_add(by);
    for way in &ways.ways {
        let mut last: Option<usize> = None;
        for id in ways.nodes(way) {
            let index = nodes.known(*id);
            // A run begins with 2 and its last node gets one more, so both ends reach 2 and become
            // vertices.
            match (last, index) {
                (Some(a), Some(b)) if a == b => continue,
                (None, Some(b)) => count(b, 2),
                (Some(_), Some(b)) => count(b, 1),
                (Some(a), None) => count(a, 1),
                (None, None) => {}
            }
            last = index;
        }
        if let Some(last) = last {
            count(last, 1);
        }
    }
    uses
}

/// For each node its vertex, [`NO_VERTEX`] if it is none. Nodes that are used twice are vertices,
/// and nodes with tags.
fn vertices(nodes: &Nodes, uses: &[u8]) -> Vec<u32> {
    let mut count = 0;
    let mut vertices = vec![NO_VERTEX; uses.len()];
    for (index, uses) in uses.iter().enumerate() {
        let is_known = nodes.places[index].is_some();
        let has_tags = nodes.classes[index] != 0;
        if is_known && (*uses >= 2 || (*uses == 1 && has_tags)) {
            vertices[index] = count;
            count += 1;
        }
    }
    vertices
}

/// Length of a line, millimetres.
fn millimetres(points: impl Iterator<Item = Place> + Clone) -> u32 {
    let pairs = points.clone().zip(points.skip(1));
    let metres: f64 = pairs.map(|(a, b)| distance(a, b)).sum();
    libm::round(metres * 1000.0) as u32
}
