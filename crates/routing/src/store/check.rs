//! Checks the content of graph files: a file with the right checksum can still have been made by
//! anyone.

use crate::network::{MOST_VIA_WAYS, Network};
use crate::roads::Roads;

type Checked = Result<(), &'static str>;

fn check(good: bool, problem: &'static str) -> Checked {
    if good { Ok(()) } else { Err(problem) }
}

/// All references have a target, and edges are in order.
pub(super) fn network(network: &Network) -> Checked {
    let vertices = network.vertices.len();
    check(
        network.vertex_classes.len() == vertices,
        "vertices and their tags do not match",
    )?;
    let nodes =
        (network.vertex_nodes.len(), network.nodes.len()) == (vertices, network.points.len());
    check(nodes, "points and their nodes do not match")?;
    check(
        network.ways.len() == network.edge_count(),
        "edges and their ways do not match",
    )?;
    let classes = network.vertex_classes.iter();
    check(
        classes
            .max()
            .is_none_or(|c| (*c as usize) < network.node_tags.len()),
        "a vertex has unknown tags",
    )?;
    let ends = network.edges.last().map(|edge| edge.first_point as usize);
    check(
        ends == Some(network.points.len()),
        "the last edge's points are missing",
    )?;
    check(
        // Directed edges are twice as many, and must stay below `NONE` in 32 bits.
        network.edge_count() < (1 << 30) && vertices < (1 << 30),
        "there are too many vertices or edges",
    )?;
    // `edges` is not empty: its last element was found above.
    for (edge, next) in network.edges().iter().zip(&network.edges[1..]) {
        let known = (edge.from.max(edge.to) as usize) < vertices
            && (edge.class as usize) < network.way_tags.len()
            && (edge.name as usize) < network.names.len();
        check(known, "an edge's vertices, tags or name are unknown")?;
        check(
            edge.first_point <= next.first_point,
            "the points of an edge overlap those of another",
        )?;
    }
    let tags = network
        .restrictions
        .iter()
        .map(|restriction| restriction.tags);
    check(
        tags.max()
            .is_none_or(|w| (w as usize) < network.restriction_tags.len()),
        "a restriction has unknown tags",
    )?;
    let ways = network
        .restrictions
        .iter()
        .map(|restriction| u64::from(restriction.ways))
        .sum::<u64>();
    let few = network
        .restrictions
        .iter()
        .all(|restriction| restriction.ways as usize <= MOST_VIA_WAYS);
    check(
        few && ways == network.via_ways.len() as u64,
        "the ways of a turn restriction are missing, or too many",
    )
}

/// Cells follow one another and are nested.
pub(super) fn levels(levels: &[Vec<u32>], vertices: usize) -> Checked {
    const PROBLEM: &str = "the cells do not fit the network";
    // As many as `CellSizes` allows.
    check(levels.len() <= 7, PROBLEM)?;
    for (i, starts) in levels.iter().enumerate() {
        check(
            starts.first() == Some(&0) && starts.last().map(|end| *end as usize) == Some(vertices),
            PROBLEM,
        )?;
        check(
            // Ascending, so no cell is empty and no index goes backwards.
            starts.len() >= 2 && starts.windows(2).all(|cell| cell[0] < cell[1]),
            PROBLEM,
        )?;
        if let Some(above) = levels.get(i + 1) {
            check(
                above
                    .iter()
                    .all(|start| starts.binary_search(start).is_ok()),
                PROBLEM,
            )?;
        }
    }
    Ok(())
}

/// The runs of the tree are runs of the network.
pub(super) fn roads(roads: &Roads) -> Checked {
    let network = &roads.network;
    let known = roads.segments.runs.iter().all(|run| {
        (run.edge as usize) < network.edge_count()
            && (run.first as usize) + 1 < network.edge_points(run.edge).len()
    });
    check(known, "the tree of segments does not fit the network")
}
