//! Elements one after another, without keeping them: for those who need little of a large file.
//!
//! A [`Source`] may be read several times over. Elements come as they stand in a PBF file and by number from XML.

use std::path::Path;

use openbench_core::LonLat;

use crate::data::{ElementKind, OsmData, Relation};
use crate::error::OsmError;
use crate::pbf;
use crate::tags::Tags;

/// The words on an element, borrowed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Words<'a>(pub &'a [(&'a str, &'a str)]);

impl<'a> Words<'a> {
    /// The value under `key`; of several the last one, as in [`Tags`].
    pub fn get(&self, key: &str) -> Option<&'a str> {
        self.0
            .iter()
            .rev()
            .find(|(k, _)| *k == key)
            .map(|(_, value)| *value)
    }
}

impl From<Words<'_>> for Tags {
    fn from(words: Words<'_>) -> Self {
        words
            .0
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
            .collect()
    }
}

/// A node that is being read.
#[derive(Debug, Clone, Copy)]
pub struct NodeRef<'a> {
    /// Its number.
    pub id: i64,
    /// Where it is said to be, degrees WGS 84: it may lie off the Earth.
    pub position: LonLat,
    /// Its words.
    pub tags: Words<'a>,
}

/// A way that is being read.
#[derive(Debug, Clone, Copy)]
pub struct WayRef<'a> {
    /// Its number.
    pub id: i64,
    /// The nodes in order; the file may lack some.
    pub nodes: &'a [i64],
    /// Its words.
    pub tags: Words<'a>,
}

/// A relation that is being read.
#[derive(Debug, Clone, Copy)]
pub struct RelationRef<'a> {
    /// Its number.
    pub id: i64,
    /// The members in order; the file may lack some.
    pub members: &'a [MemberRef<'a>],
    /// Its words.
    pub tags: Words<'a>,
}

/// One element of a relation.
#[derive(Debug, Clone, Copy)]
pub struct MemberRef<'a> {
    /// What kind of element it is.
    pub kind: ElementKind,
    /// Its number among that kind.
    pub id: i64,
    /// What it is in the relation.
    pub role: &'a str,
}

/// What is shown the elements of a source.
pub trait Visitor {
    /// Whether elements of this kind are to be shown at all. Those that are not cost next to nothing.
    fn wants(&self, _kind: ElementKind) -> bool {
        true
    }

    /// A node.
    fn node(&mut self, _node: NodeRef<'_>) {}

    /// A way.
    fn way(&mut self, _way: WayRef<'_>) {}

    /// A relation.
    fn relation(&mut self, _relation: RelationRef<'_>) {}

    /// An element that is marked as deleted and is not shown.
    fn deleted(&mut self) {}
}

/// What can show its elements.
pub trait Elements {
    /// Shows all elements to a visitor.
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError>;
}

/// A map as a file holds it.
#[derive(Debug)]
pub enum Source {
    /// A PBF file, unpacked again each time it is read.
    Pbf(Vec<u8>),
    /// Data in memory.
    Data(OsmData),
}

impl Source {
    /// Opens OSM XML or PBF; the first bytes tell which, not the name. XML is read whole.
    pub fn open(path: &Path) -> Result<Self, OsmError> {
        let bytes = std::fs::read(path).map_err(|source| OsmError::Io {
            doing: "read",
            path: path.to_owned(),
            source,
        })?;
        Self::from_bytes(bytes).map_err(|error| error.in_file(path))
    }

    /// OSM XML or PBF, whichever the first bytes look like.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, OsmError> {
        if pbf::looks_like_pbf(&bytes) {
            Ok(Self::Pbf(bytes))
        } else {
            OsmData::from_xml(&bytes).map(Self::Data)
        }
    }
}

impl Elements for Source {
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError> {
        match self {
            Self::Pbf(bytes) => pbf::read(bytes, visitor),
            Self::Data(data) => data.visit(visitor),
        }
    }
}

/// Nodes, ways, relations, each by number.
impl Elements for OsmData {
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError> {
        if visitor.wants(ElementKind::Node) {
            for node in self.nodes.values() {
                let words = borrowed(&node.tags);
                visitor.node(NodeRef {
                    id: node.id,
                    position: node.position,
                    tags: Words(&words),
                });
            }
        }
        if visitor.wants(ElementKind::Way) {
            for way in self.ways.values() {
                let words = borrowed(&way.tags);
                visitor.way(WayRef {
                    id: way.id,
                    nodes: &way.nodes,
                    tags: Words(&words),
                });
            }
        }
        if visitor.wants(ElementKind::Relation) {
            self.relations
                .values()
                .for_each(|relation| show(relation, visitor));
        }
        Ok(())
    }
}

fn show(relation: &Relation, visitor: &mut impl Visitor) {
    let words = borrowed(&relation.tags);
    let members = relation.members.iter();
    let members: Vec<_> = members
        .map(|m| MemberRef {
            kind: m.kind,
            id: m.id,
            role: &m.role,
        })
        .collect();
    visitor.relation(RelationRef {
        id: relation.id,
        members: &members,
        tags: Words(&words),
    });
}

fn borrowed(tags: &Tags) -> Vec<(&str, &str)> {
    tags.iter().collect()
}
