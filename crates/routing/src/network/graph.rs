//! The rows of a network, and what can be read from them.

use super::chain::Chain;
use super::words::{RoadName, RoadNames, WordSets};
use crate::geo::Place;
use crate::store::Column;

/// The most ways between the first and the last one of a turn restriction.
pub(crate) const MOST_VIA_WAYS: usize = 16;

/// An edge's two vertices and what is known of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Edge {
    /// Where it begins, in the direction of its way.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
    /// Millimetres.
    pub length: u32,
    /// Index of its words among [`Network::way_words`].
    pub class: u32,
    /// Index of its name among [`Network::names`].
    pub name: u32,
    /// The first of its points between its vertices among [`Network::points`]; the last one stands before the next edge's first.
    pub first_point: u32,
}

/// Which turn is restricted, as the map has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Restriction {
    /// The way that one comes along.
    pub from: i64,
    /// The node where one turns; nothing where there are ways in between.
    pub via: i64,
    /// The way that one turns into.
    pub to: i64,
    /// Index of its words among [`Network::restriction_words`].
    pub words: u32,
    /// How many ways are in between; of all restrictions they stand one after another in [`Network::via_ways`].
    pub ways: u32,
}

/// What was left out while a network was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NetworkReport {
    /// Ways that no two neighbouring nodes are known of.
    pub ways_without_points: usize,
    /// Ways with words that hold at some times only (`*:conditional`); those words are not regarded.
    pub conditional: usize,
    /// Turn restrictions that are not from ways by one node, or by ways, to others; not regarded.
    pub odd_restrictions: usize,
    /// Pedestrian areas with too many corners to be crossed, or without a whole outline.
    pub squares_not_crossed: usize,
}

/// The network.
#[derive(Debug, Clone, Default)]
pub struct Network {
    /// Where vertices are.
    pub vertices: Column<Place>,
    /// For each vertex the index of its node's words among [`Network::node_words`].
    pub vertex_classes: Column<u32>,
    /// The edges, and one more that says where the last one's points end.
    pub edges: Column<Edge>,
    /// The points of all edges between their vertices.
    pub points: Column<Place>,
    /// The OSM nodes at those points.
    pub nodes: Column<i64>,
    /// The OSM nodes at vertices.
    pub vertex_nodes: Column<i64>,
    /// Sets of words of ways; number 0 is the empty one.
    pub way_words: WordSets,
    /// Sets of words of nodes; number 0 is the empty one.
    pub node_words: WordSets,
    /// For each edge the number of its way.
    pub ways: Column<i64>,
    /// Turns that are restricted.
    pub restrictions: Column<Restriction>,
    /// The ways in between of all restrictions.
    pub via_ways: Column<i64>,
    /// What is said of them.
    pub restriction_words: WordSets,
    /// What roads are called; number 0 is nothing.
    pub names: RoadNames,
    /// What was left out.
    pub report: NetworkReport,
}

/// The rows of a network while it is put together.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub(crate) vertices: Vec<Place>,
    pub(crate) vertex_classes: Vec<u32>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) points: Vec<Place>,
    pub(crate) nodes: Vec<i64>,
    pub(crate) vertex_nodes: Vec<i64>,
    pub(crate) ways: Vec<i64>,
}

impl Rows {
    /// The network of these rows; its words are still missing.
    pub(crate) fn into_network(mut self) -> Network {
        let first_point = self.points.len() as u32;
        self.edges.push(Edge {
            first_point,
            ..Edge::default()
        });
        Network {
            vertices: self.vertices.into(),
            vertex_classes: self.vertex_classes.into(),
            edges: self.edges.into(),
            points: self.points.into(),
            nodes: self.nodes.into(),
            vertex_nodes: self.vertex_nodes.into(),
            ways: self.ways.into(),
            ..Network::default()
        }
    }
}

impl Network {
    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// The edges.
    pub fn edges(&self) -> &[Edge] {
        &self.edges[..self.edge_count()]
    }

    /// The vertices at which a directed edge begins and ends: twice the edge's number, and one more against its direction.
    pub fn ends(&self, directed: u32) -> [u32; 2] {
        let edge = &self.edges[directed as usize / 2];
        if directed.is_multiple_of(2) {
            [edge.from, edge.to]
        } else {
            [edge.to, edge.from]
        }
    }

    /// The points of an edge, from vertex to vertex.
    #[inline]
    pub fn edge_points(&self, edge: u32) -> Chain<'_, Place> {
        let Edge { from, to, .. } = self.edges[edge as usize];
        let [from, to] = [from, to].map(|vertex| self.vertices[vertex as usize]);
        Chain::new(from, &self.points[self.between(edge)], to)
    }

    /// The OSM nodes of an edge.
    pub fn edge_nodes(&self, edge: u32) -> Chain<'_, i64> {
        let Edge { from, to, .. } = self.edges[edge as usize];
        let [from, to] = [from, to].map(|vertex| self.vertex_nodes[vertex as usize]);
        Chain::new(from, &self.nodes[self.between(edge)], to)
    }

    /// How many points there are, those of vertices once.
    pub fn point_count(&self) -> usize {
        self.vertices.len() + self.points.len()
    }

    /// What an edge's road is called.
    pub fn name(&self, edge: u32) -> RoadName<'_> {
        self.names.get(self.edges[edge as usize].name)
    }

    /// Where an edge's points between its vertices are.
    pub(crate) fn between(&self, edge: u32) -> std::ops::Range<usize> {
        let [first, end] = [0, 1].map(|i| self.edges[edge as usize + i].first_point as usize);
        first..end
    }
}
