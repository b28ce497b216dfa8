//! Elements numbered anew.

use std::collections::{BTreeMap, BTreeSet};

use crate::data::OsmData;
use crate::element::{ElementKind, Member, Node, Relation, Way};

/// The same data with new numbers, which do not tell what an editor removed: gaps in the numbers
/// of nodes would count the doors of a building.
///
/// Each kind counts from 1. Ways and relations keep their order. Nodes come in the order in which
/// ways use them; nodes that no way uses follow from west to east. Elements that the data refers to
/// but lacks get the numbers after those.
pub fn renumbered(data: &OsmData) -> OsmData {
    let nodes = Numbers::of(node_order(data));
    let ways = Numbers::of(order(&data.ways, members(data, ElementKind::Way)));
    let relations = Numbers::of(order(&data.relations, members(data, ElementKind::Relation)));
    let number = |kind: ElementKind, id: i64| match kind {
        ElementKind::Node => nodes.get(id),
        ElementKind::Way => ways.get(id),
        ElementKind::Relation => relations.get(id),
    };
    let renumber_node = |node: &Node| Node {
        id: nodes.get(node.id),
        ..node.clone()
    };
    let renumber_way = |way: &Way| Way {
        id: ways.get(way.id),
        nodes: way.nodes.iter().map(|node| nodes.get(*node)).collect(),
        ..way.clone()
    };
    let renumber_member = |member: &Member| Member {
        id: number(member.kind, member.id),
        ..member.clone()
    };
    let renumber_relation = |relation: &Relation| Relation {
        id: relations.get(relation.id),
        members: relation.members.iter().map(renumber_member).collect(),
        ..relation.clone()
    };
    OsmData {
        nodes: by_number(data.nodes.values().map(renumber_node), |node| node.id),
        ways: by_number(data.ways.values().map(renumber_way), |way| way.id),
        relations: by_number(data.relations.values().map(renumber_relation), |relation| {
            relation.id
        }),
        report: data.report,
    }
}

/// New numbers of the elements of one kind, by their old ones.
struct Numbers(BTreeMap<i64, i64>);

impl Numbers {
    /// From 1 in the order of first appearance.
    fn of(ids: impl IntoIterator<Item = i64>) -> Self {
        let mut numbers = BTreeMap::new();
        for id in ids {
            let next = numbers.len() as i64 + 1;
            numbers.entry(id).or_insert(next);
        }
        Self(numbers)
    }

    fn get(&self, id: i64) -> i64 {
        // Every number that the data mentions was counted.
        self.0.get(&id).copied().unwrap_or(id)
    }
}

/// The numbers of all nodes that the data has or mentions, in their new order.
fn node_order(data: &OsmData) -> Vec<i64> {
    let is_known = |id: &i64| data.nodes.contains_key(id);
    let used: Vec<i64> = data
        .ways
        .values()
        .flat_map(|way| way.nodes.clone())
        .collect();
    let in_ways: BTreeSet<i64> = used.iter().copied().collect();
    let mut alone: Vec<&Node> = data
        .nodes
        .values()
        .filter(|node| !in_ways.contains(&node.id))
        .collect();
    alone.sort_by(|a, b| {
        let (a, b) = (a.position, b.position);
        a.lon.total_cmp(&b.lon).then(a.lat.total_cmp(&b.lat))
    });
    let known = used.iter().copied().filter(is_known);
    let missing = used.iter().copied().filter(|id| !is_known(id));
    known
        .chain(alone.into_iter().map(|node| node.id))
        .chain(missing)
        .chain(members(data, ElementKind::Node))
        .collect()
}

/// The numbers of the elements that there are, then of those that are only mentioned.
fn order<T>(elements: &BTreeMap<i64, T>, mentioned: Vec<i64>) -> Vec<i64> {
    elements.keys().copied().chain(mentioned).collect()
}

/// The numbers of the members of one kind in all relations.
fn members(data: &OsmData, kind: ElementKind) -> Vec<i64> {
    data.relations
        .values()
        .flat_map(|relation| &relation.members)
        .filter(|member| member.kind == kind)
        .map(|member| member.id)
        .collect()
}

fn by_number<T>(elements: impl Iterator<Item = T>, id: impl Fn(&T) -> i64) -> BTreeMap<i64, T> {
    elements.map(|element| (id(&element), element)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = r#"<osm version="0.6">
        <node id="-3" lat="1" lon="1"/><node id="7" lat="2" lon="2"/>
        <node id="90" lat="3" lon="3"><tag k="natural" v="tree"/></node>
        <node id="91" lat="3" lon="2.5"><tag k="natural" v="tree"/></node>
        <way id="5"><nd ref="7"/><nd ref="44"/><nd ref="-3"/></way>
        <way id="9"><nd ref="-3"/><nd ref="7"/><tag k="highway" v="path"/></way>
        <relation id="2"><member type="way" ref="9" role="outer"/>
            <member type="way" ref="1000" role="inner"/><member type="node" ref="90" role=""/>
            <tag k="type" v="multipolygon"/></relation></osm>"#;

    #[test]
    fn numbers_count_from_one_and_references_follow() {
        let data = OsmData::from_xml(XML.as_bytes()).unwrap();
        let new = renumbered(&data);
        let lon = |id: i64| new.nodes[&id].position.lon;
        // Nodes 7 and -3 in the order of the first way, then the trees from west to east.
        let lons: Vec<f64> = (1..=4).map(lon).collect();
        assert_eq!((lons, new.nodes.len()), (vec![2.0, 1.0, 2.5, 3.0], 4));
        assert_eq!(new.ways[&1].nodes, [1, 5, 2], "node 44 is missing still");
        assert_eq!(new.ways[&2].nodes, [2, 1]);
        let relation = &new.relations[&1];
        let members: Vec<_> = relation.members.iter().map(|m| (m.kind, m.id)).collect();
        let expected = [
            (ElementKind::Way, 2),
            (ElementKind::Way, 3),
            (ElementKind::Node, 4),
        ];
        assert_eq!(members, expected);
        assert_eq!(relation.tags.get("type"), Some("multipolygon"));
        assert!(new.ways[&2].tags.says("highway"));
    }

    #[test]
    fn removed_nodes_leave_no_gap() {
        let data = OsmData::from_xml(XML.as_bytes()).unwrap();
        let mut less = data.clone();
        less.nodes.remove(&91);
        let numbers: Vec<i64> = renumbered(&less).nodes.into_keys().collect();
        assert_eq!(numbers, [1, 2, 3]);
        // Numbered twice is numbered once.
        let once = renumbered(&data);
        assert_eq!(renumbered(&once).to_xml(), once.to_xml());
    }
}
