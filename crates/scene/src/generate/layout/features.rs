//! Things of the map that are no roads, areas or buildings: tagged nodes, and rows of trees.

use openbench_core::MapPoint;
use openbench_osm::{OsmData, OsmMap, Tags};

/// Keys of nodes that may represent a thing.
const KEYS: [&str; 7] = [
    "natural",
    "highway",
    "amenity",
    "emergency",
    "barrier",
    "power",
    "leisure",
];

/// A tagged node that represents a thing: a tree, a lamp, a crossing.
pub(crate) struct Feature {
    /// Number of the node.
    pub node: i64,
    pub position: MapPoint,
    pub tags: Tags,
}

/// A line of trees.
pub(crate) struct TreeRow {
    /// Number of the way.
    pub way: i64,
    pub line: Vec<MapPoint>,
}

/// The tagged nodes of a map.
pub(crate) fn features(data: &OsmData, map: &OsmMap) -> Vec<Feature> {
    let tagged = data
        .nodes
        .values()
        .filter(|n| KEYS.iter().any(|key| n.tags.says(key)));
    tagged
        .map(|node| Feature {
            node: node.id,
            position: map.projection.to_map(node.position),
            tags: node.tags.clone(),
        })
        .collect()
}

/// The rows of trees of a map (`natural=tree_row`).
pub(crate) fn tree_rows(data: &OsmData, map: &OsmMap) -> Vec<TreeRow> {
    let point = |id: &i64| {
        data.nodes
            .get(id)
            .map(|node| map.projection.to_map(node.position))
    };
    let rows = data
        .ways
        .values()
        .filter(|way| way.tags.is("natural", "tree_row"));
    rows.map(|way| TreeRow {
        way: way.id,
        line: way.nodes.iter().filter_map(point).collect(),
    })
    .collect()
}
