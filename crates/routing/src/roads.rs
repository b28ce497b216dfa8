//! A network in cells: everything about a map that is independent of profiles.

use openbench_osm::OsmError;
use openbench_osm::visitor::Elements;

use crate::network::{Edge, Network, Rows};
use crate::overlay::{Arc, Arcs, NONE, Overlay};
use crate::partition::{CellSizes, Partition};
use crate::tree::SegmentTree;

/// A network whose vertices are in the order of their cells, with the layers of these and an index
/// of its segments.
#[derive(Debug, Clone, Default)]
pub struct Roads {
    /// Vertices and edges.
    pub network: Network,
    /// For each level, smallest cells first: the begin of each cell, and the end of the last one.
    pub levels: Vec<Vec<u32>>,
    /// Layers over vertices, for profiles to which turns do not matter.
    pub vertices: Overlay,
    /// Finds segments near a place.
    pub(crate) segments: SegmentTree,
}

impl Roads {
    /// Reads a map and prepares it.
    ///
    /// # Errors
    /// If the map is malformed.
    pub fn read(source: &impl Elements, sizes: &CellSizes) -> Result<Self, OsmError> {
        Network::read(source).map(|network| Self::new(network, sizes))
    }

    /// Prepares a network.
    pub fn new(network: Network, sizes: &CellSizes) -> Self {
        let edges: Vec<[u32; 2]> = network
            .edges()
            .iter()
            .map(|edge| [edge.from, edge.to])
            .collect();
        let partition = Partition::new(&network.vertices, &edges, sizes);
        let network = in_order(network, &partition.order);
        let segments = SegmentTree::new(&network);
        Self::assemble(network, partition.levels, segments)
    }

    /// Derives the layers from a network in the order of its cells.
    pub(crate) fn assemble(network: Network, levels: Vec<Vec<u32>>, segments: SegmentTree) -> Self {
        let vertices = Overlay::new(vertex_arcs(&network), &levels);
        Self {
            network,
            levels,
            vertices,
            segments,
        }
    }
}

/// The network with its vertices in another order, and its edges in the order of their vertices.
fn in_order(network: Network, order: &[u32]) -> Network {
    let mut position = vec![NONE; order.len()];
    for (i, vertex) in order.iter().enumerate() {
        position[*vertex as usize] = i as u32;
    }
    let place = |edge: &Edge| [position[edge.from as usize], position[edge.to as usize]];
    let mut edges: Vec<u32> = (0..network.edge_count() as u32).collect();
    // Edges of one cell become neighbours in memory, as their vertices are.
    edges.sort_by_key(|edge| {
        let [from, to] = place(&network.edges[*edge as usize]);
        (from.min(to), from.max(to))
    });
    let mut rows = Rows {
        vertices: order
            .iter()
            .map(|v| network.vertices[*v as usize])
            .collect(),
        vertex_classes: order
            .iter()
            .map(|v| network.vertex_classes[*v as usize])
            .collect(),
        vertex_nodes: order
            .iter()
            .map(|v| network.vertex_nodes[*v as usize])
            .collect(),
        ..Rows::default()
    };
    for &edge in &edges {
        let old = network.edges[edge as usize];
        let [from, to] = place(&old);
        rows.edges.push(Edge {
            from,
            to,
            first_point: rows.points.len() as u32,
            ..old
        });
        let between = network.between(edge);
        rows.points
            .extend_from_slice(&network.points[between.clone()]);
        rows.nodes.extend_from_slice(&network.nodes[between]);
        rows.ways.push(network.ways[edge as usize]);
    }
    Network {
        way_tags: network.way_tags,
        node_tags: network.node_tags,
        names: network.names,
        restrictions: network.restrictions,
        via_ways: network.via_ways,
        restriction_tags: network.restriction_tags,
        report: network.report,
        ..rows.into_network()
    }
}

/// Both directions of all edges, except of those that end where they begin.
fn vertex_arcs(network: &Network) -> Arcs {
    let edges = network
        .edges()
        .iter()
        .zip(0_u32..)
        // No lightest path goes round a loop.
        .filter(|(edge, _)| edge.from != edge.to);
    let both = edges.flat_map(|(edge, i)| {
        let Edge { from, to, .. } = *edge;
        [
            Arc {
                from,
                to,
                via: 2 * i,
            },
            Arc {
                from: to,
                to: from,
                via: 2 * i + 1,
            },
        ]
    });
    Arcs::new(network.vertices.len(), both)
}
