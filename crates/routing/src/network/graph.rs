//! The rows of a network, and access to them.

use super::chain::Chain;
use super::tag_sets::{RoadName, RoadNames, TagSets};
use crate::geo::Place;
use crate::store::Column;

/// The most ways between the first and the last one of a turn restriction.
pub(crate) const MOST_VIA_WAYS: usize = 16;

/// An edge: its two vertices and its properties.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Edge {
    /// Where it begins, in the direction of its way.
    pub from: u32,
    /// Where it ends.
    pub to: u32,
    /// Length, millimetres.
    pub length: u32,
    /// Index of its tags among [`Network::way_tags`].
    pub(crate) class: u32,
    /// Index of its name among [`Network::names`].
    pub name: u32,
    /// Index of its first point between its vertices among [`Network::points`]. The last one
    /// precedes the next edge's first.
    pub(crate) first_point: u32,
}

/// A turn restriction, as the map has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Restriction {
    /// The way before the turn.
    pub from: i64,
    /// The node of the turn; 0 if there are ways in between.
    pub via: i64,
    /// The way after the turn.
    pub to: i64,
    /// Index of its tags among those of all restrictions.
    pub tags: u32,
    /// How many ways are in between. Those of all restrictions follow one another in one column.
    pub ways: u32,
}

/// Elements that could not be used, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NetworkReport {
    /// Ways of which no two neighbouring nodes are known.
    pub ways_without_points: usize,
    /// Ways with tags that hold at some times only (`*:conditional`). Those tags are ignored.
    pub conditional: usize,
    /// Turn restrictions that do not lead from ways through one node, or through ways, to others.
    /// They are ignored.
    pub odd_restrictions: usize,
    /// Pedestrian areas with too many corners to be crossed, or with an incomplete outline.
    pub squares_not_crossed: usize,
}

/// The network.
#[derive(Debug, Clone, Default)]
pub struct Network {
    /// The places of the vertices.
    pub vertices: Column<Place>,
    /// For each vertex the index of its node's tags among [`Network::node_tags`].
    pub(crate) vertex_classes: Column<u32>,
    /// The edges, and one more whose first point is the end of the last edge's points.
    pub edges: Column<Edge>,
    /// The points of all edges between their vertices.
    pub(crate) points: Column<Place>,
    /// The OSM nodes at those points.
    pub(crate) nodes: Column<i64>,
    /// The OSM nodes at vertices.
    pub(crate) vertex_nodes: Column<i64>,
    /// Sets of tags of ways; number 0 is the empty set.
    pub(crate) way_tags: TagSets,
    /// Sets of tags of nodes; number 0 is the empty set.
    pub(crate) node_tags: TagSets,
    /// For each edge the number of its way.
    pub ways: Column<i64>,
    /// Turn restrictions.
    pub restrictions: Column<Restriction>,
    /// The ways in between of all restrictions.
    pub(crate) via_ways: Column<i64>,
    /// Sets of tags of turn restrictions.
    pub(crate) restriction_tags: TagSets,
    /// Names of roads; number 0 is no name.
    pub names: RoadNames,
    /// Elements that could not be used.
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
    /// The network of these rows, without tags and names.
    pub(crate) fn into_network(mut self) -> Network {
        // A sentinel edge, so that the points of edge `i` end where those of `i + 1` begin.
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

    /// The vertices at which a directed edge begins and ends: twice the edge's number, and one more
    /// against its direction.
    pub(crate) fn ends(&self, directed: u32) -> [u32; 2] {
        let edge = &self.edges[directed as usize / 2];
        if directed.is_multiple_of(2) {
            [edge.from, edge.to]
        } else {
            [edge.to, edge.from]
        }
    }

    /// The points of an edge, from vertex to vertex.
    #[inline]
    pub(crate) fn edge_points(&self, edge: u32) -> Chain<'_, Place> {
        let Edge { from, to, .. } = self.edges[edge as usize];
        let [from, to] = [from, to].map(|vertex| self.vertices[vertex as usize]);
        Chain::new(from, &self.points[self.between(edge)], to)
    }

    /// The OSM nodes of an edge.
    pub(crate) fn edge_nodes(&self, edge: u32) -> Chain<'_, i64> {
        let Edge { from, to, .. } = self.edges[edge as usize];
        let [from, to] = [from, to].map(|vertex| self.vertex_nodes[vertex as usize]);
        Chain::new(from, &self.nodes[self.between(edge)], to)
    }

    /// The number of points, those of vertices counted once.
    pub fn point_count(&self) -> usize {
        self.vertices.len() + self.points.len()
    }

    /// The name of an edge's road.
    pub fn name(&self, edge: u32) -> RoadName<'_> {
        self.names.get(self.edges[edge as usize].name)
    }

    /// The range of an edge's points between its vertices.
    pub(crate) fn between(&self, edge: u32) -> std::ops::Range<usize> {
        let [first, end] = [0, 1].map(|i| self.edges[edge as usize + i].first_point as usize);
        first..end
    }
}
