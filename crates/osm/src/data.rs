//! OSM data as it stands in a file: nodes, ways and relations with their tags.
//!
//! Follows the OSM data model, API 0.6. Left out on purpose: versions, authors and time stamps, which no part of a delivery needs.
//! What a file refers to but lacks (a cut-out of a larger map always does) is kept as a reference and counted.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use openbench_core::LonLat;

use crate::error::OsmError;
use crate::stream::{NodeRef, RelationRef, Visitor, WayRef};
use crate::tags::Tags;
use crate::{pbf, xml};

/// A node: a position with tags.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Node {
    /// Positive if the OSM database gave it, negative for data of one's own.
    pub id: i64,
    /// Where it is, degrees WGS 84.
    pub position: LonLat,
    /// Its words.
    pub tags: Tags,
}

/// A way: a line through nodes, an area if it ends where it begins and its tags say so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Way {
    /// As of a node; nodes and ways count separately.
    pub id: i64,
    /// The nodes in order. Some may be missing from the data, and there may be none at all.
    pub nodes: Vec<i64>,
    /// Its words.
    pub tags: Tags,
}

/// A relation: elements in roles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Relation {
    /// As of a node; relations count separately.
    pub id: i64,
    /// The members in order. Some may be missing from the data.
    pub members: Vec<Member>,
    /// Its words.
    pub tags: Tags,
}

/// One element of a relation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// What kind of element it is.
    pub kind: ElementKind,
    /// Its number among that kind.
    pub id: i64,
    /// What it is in the relation: `outer`, `inner`, `entrance`, … or nothing.
    pub role: String,
}

/// The three kinds of element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ElementKind {
    /// A [`Node`].
    Node,
    /// A [`Way`].
    Way,
    /// A [`Relation`].
    Relation,
}

impl ElementKind {
    /// The word in OSM XML.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Way => "way",
            Self::Relation => "relation",
        }
    }
}

/// Names one element: a number is unique only among elements of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ElementId {
    /// Which kind.
    pub kind: ElementKind,
    /// Its number.
    pub id: i64,
}

impl ElementId {
    /// The node `id`.
    pub const fn node(id: i64) -> Self {
        Self {
            kind: ElementKind::Node,
            id,
        }
    }

    /// The way `id`.
    pub const fn way(id: i64) -> Self {
        Self {
            kind: ElementKind::Way,
            id,
        }
    }

    /// The relation `id`.
    pub const fn relation(id: i64) -> Self {
        Self {
            kind: ElementKind::Relation,
            id,
        }
    }
}

impl fmt::Display for ElementId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind.word(), self.id)
    }
}

/// What was survived while reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReadReport {
    /// Ways that name at least one node which the data lacks.
    pub ways_with_missing_nodes: usize,
    /// Ways that name no node at all.
    pub ways_without_nodes: usize,
    /// Relations that name at least one member which the data lacks.
    pub relations_with_missing_members: usize,
    /// Elements left out because they are marked as deleted.
    pub deleted_elements: usize,
    /// Elements left out because their number or position cannot be read or lies off the Earth.
    pub bad_elements: usize,
    /// Elements that stood there twice; the later one was kept.
    pub repeated_elements: usize,
}

impl ReadReport {
    /// What was left out or mended, in words; empty if nothing was.
    pub fn notes(&self) -> Vec<String> {
        let counts = [
            (
                self.ways_with_missing_nodes,
                "name nodes that the file lacks",
            ),
            (self.ways_without_nodes, "are ways without nodes"),
            (
                self.relations_with_missing_members,
                "are relations with members that the file lacks",
            ),
            (self.bad_elements, "cannot be read and were left out"),
            (self.repeated_elements, "stand there twice"),
        ];
        let plural = |n: usize| if n == 1 { "element" } else { "elements" };
        let told = counts.into_iter().filter(|(count, _)| *count > 0);
        told.map(|(count, what)| format!("{count} {} {what}", plural(count)))
            .collect()
    }
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
    /// What was survived while reading.
    pub report: ReadReport,
}

impl OsmData {
    /// Reads OSM XML or PBF from a file; the first bytes tell which, not the name.
    pub fn read(path: &Path) -> Result<Self, OsmError> {
        let bytes = std::fs::read(path).map_err(|source| OsmError::Io {
            doing: "read",
            path: path.to_owned(),
            source,
        })?;
        Self::from_bytes(&bytes).map_err(|error| error.in_file(path))
    }

    /// Reads OSM XML or PBF, whichever the first bytes look like.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OsmError> {
        if pbf::looks_like_pbf(bytes) {
            Self::from_pbf(bytes)
        } else {
            Self::from_xml(bytes)
        }
    }

    /// Reads OSM XML (API 0.6, Overpass, JOSM). A document type is refused.
    pub fn from_xml(bytes: &[u8]) -> Result<Self, OsmError> {
        let mut data = xml::read(bytes)?;
        data.count_missing();
        Ok(data)
    }

    /// Reads OSM PBF.
    pub fn from_pbf(bytes: &[u8]) -> Result<Self, OsmError> {
        let mut data = Self::default();
        pbf::read(bytes, &mut data)?;
        data.count_missing();
        Ok(data)
    }

    /// The tags of an element, if the data has it.
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
        let good = node.position.lon.abs() <= 180.0 && node.position.lat.abs() <= 90.0;
        if !good {
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

    fn count_missing(&mut self) {
        let lacks = |way: &&Way| way.nodes.iter().any(|id| !self.nodes.contains_key(id));
        self.report.ways_with_missing_nodes = self.ways.values().filter(lacks).count();
        self.report.ways_without_nodes = self
            .ways
            .values()
            .filter(|way| way.nodes.is_empty())
            .count();
        let lacks = |relation: &&Relation| {
            relation.members.iter().any(|m| {
                !self.has(ElementId {
                    kind: m.kind,
                    id: m.id,
                })
            })
        };
        self.report.relations_with_missing_members = self.relations.values().filter(lacks).count();
    }
}

/// Keeps all that it is shown.
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
        let members = relation.members.iter();
        let members = members
            .map(|m| Member {
                kind: m.kind,
                id: m.id,
                role: m.role.to_owned(),
            })
            .collect();
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
