//! OSM data in memory, as it stands in a file.
//!
//! References to elements that the file lacks are kept and counted: a cut-out of a larger map
//! always has some.

use std::collections::BTreeMap;

use crate::element::{ElementId, ElementKind, Member, Node, Relation, Way};
use crate::error::OsmError;
use crate::tags::Tags;
use crate::visitor::{Elements, MemberRef, NodeRef, RelationRef, TagRef, TagsRef, Visitor, WayRef};

/// Irregularities that reading tolerated, counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ReadReport {
    /// Ways that reference at least one node which the data lacks.
    pub ways_with_missing_nodes: usize,
    /// Ways without nodes.
    pub ways_without_nodes: usize,
    /// Relations that reference at least one member which the data lacks.
    pub relations_with_missing_members: usize,
    /// Elements skipped because they are marked as deleted.
    pub deleted_elements: usize,
    /// Elements skipped because their number or position is unreadable or off the Earth.
    pub bad_elements: usize,
    /// Elements that appeared twice. The later one was kept.
    pub repeated_elements: usize,
}

impl ReadReport {
    /// What was skipped or repaired, one sentence each. Empty if nothing was.
    pub fn notes(&self) -> Vec<String> {
        let counts = [
            (
                self.ways_with_missing_nodes,
                "reference nodes that the file lacks",
            ),
            (self.ways_without_nodes, "are ways without nodes"),
            (
                self.relations_with_missing_members,
                "are relations with members that the file lacks",
            ),
            (self.bad_elements, "cannot be read and were skipped"),
            (self.repeated_elements, "appear twice"),
        ];
        let occurred = counts.into_iter().filter(|(count, _)| *count > 0);
        occurred
            .map(|(count, what)| format!("{count} {} {what}", elements(count)))
            .collect()
    }
}

fn elements(count: usize) -> &'static str {
    if count == 1 { "element" } else { "elements" }
}

/// OSM data in memory.
#[derive(Debug, Clone, Default)]
pub struct OsmData {
    /// By number.
    pub nodes: BTreeMap<i64, Node>,
    /// By number.
    pub ways: BTreeMap<i64, Way>,
    /// By number.
    pub relations: BTreeMap<i64, Relation>,
    /// Irregularities that reading tolerated.
    pub report: ReadReport,
}

impl OsmData {
    /// The tags of an element; `None` if the data lacks it.
    pub fn tags(&self, element: ElementId) -> Option<&Tags> {
        match element.kind {
            ElementKind::Node => self.nodes.get(&element.id).map(|n| &n.tags),
            ElementKind::Way => self.ways.get(&element.id).map(|w| &w.tags),
            ElementKind::Relation => self.relations.get(&element.id).map(|r| &r.tags),
        }
    }

    /// Whether the data has an element.
    pub fn has(&self, element: ElementId) -> bool {
        self.tags(element).is_some()
    }

    pub(crate) fn put_node(&mut self, node: Node) {
        // False for NaN as well.
        let on_earth = node.position.lon.abs() <= 180.0 && node.position.lat.abs() <= 90.0;
        if !on_earth {
            self.report.bad_elements += 1;
        } else if self.nodes.insert(node.id, node).is_some() {
            self.report.repeated_elements += 1;
        }
    }

    pub(crate) fn put_way(&mut self, way: Way) {
        self.report.repeated_elements += usize::from(self.ways.insert(way.id, way).is_some());
    }

    pub(crate) fn put_relation(&mut self, relation: Relation) {
        let before = self.relations.insert(relation.id, relation);
        self.report.repeated_elements += usize::from(before.is_some());
    }

    /// Counts references without a target. To be called once all elements are there.
    pub(crate) fn count_missing(&mut self) {
        self.report.ways_with_missing_nodes = self
            .ways
            .values()
            .filter(|way| self.lacks_nodes_of(way))
            .count();
        self.report.ways_without_nodes = self
            .ways
            .values()
            .filter(|way| way.nodes.is_empty())
            .count();
        self.report.relations_with_missing_members = self
            .relations
            .values()
            .filter(|relation| self.lacks_members_of(relation))
            .count();
    }

    fn lacks_nodes_of(&self, way: &Way) -> bool {
        way.nodes.iter().any(|id| !self.nodes.contains_key(id))
    }

    fn lacks_members_of(&self, relation: &Relation) -> bool {
        relation
            .members
            .iter()
            .any(|member| !self.has(member.element()))
    }
}

/// Keeps every element.
impl Visitor for OsmData {
    fn node(&mut self, node: NodeRef<'_>) {
        self.put_node(Node {
            id: node.id,
            position: node.position,
            tags: node.tags.into(),
        });
    }

    fn way(&mut self, way: WayRef<'_>) {
        self.put_way(Way {
            id: way.id,
            nodes: way.nodes.to_vec(),
            tags: way.tags.into(),
        });
    }

    fn relation(&mut self, relation: RelationRef<'_>) {
        let members = relation.members.iter().map(owned_member).collect();
        self.put_relation(Relation {
            id: relation.id,
            members,
            tags: relation.tags.into(),
        });
    }

    fn deleted(&mut self) {
        self.report.deleted_elements += 1;
    }
}

/// Nodes, then ways, then relations, each by number.
impl Elements for OsmData {
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError> {
        if visitor.wants(ElementKind::Node) {
            for node in self.nodes.values() {
                let tags = borrowed_tags(&node.tags);
                visitor.node(NodeRef {
                    id: node.id,
                    position: node.position,
                    tags: TagsRef(&tags),
                });
            }
        }
        if visitor.wants(ElementKind::Way) {
            for way in self.ways.values() {
                let tags = borrowed_tags(&way.tags);
                visitor.way(WayRef {
                    id: way.id,
                    nodes: &way.nodes,
                    tags: TagsRef(&tags),
                });
            }
        }
        if visitor.wants(ElementKind::Relation) {
            for relation in self.relations.values() {
                let tags = borrowed_tags(&relation.tags);
                let members: Vec<_> = relation.members.iter().map(borrowed_member).collect();
                visitor.relation(RelationRef {
                    id: relation.id,
                    members: &members,
                    tags: TagsRef(&tags),
                });
            }
        }
        Ok(())
    }
}

fn owned_member(member: &MemberRef<'_>) -> Member {
    let ElementId { kind, id } = member.element;
    Member {
        kind,
        id,
        role: member.role.to_owned(),
    }
}

fn borrowed_member(member: &Member) -> MemberRef<'_> {
    MemberRef {
        element: member.element(),
        role: &member.role,
    }
}

fn borrowed_tags(tags: &Tags) -> Vec<TagRef<'_>> {
    tags.iter()
        .map(|(key, value)| TagRef { key, value })
        .collect()
}
