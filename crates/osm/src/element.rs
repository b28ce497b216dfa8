//! Nodes, ways and relations of the OSM data model, API 0.6.
//!
//! Versions, authors and time stamps are left out on purpose: no part of a delivery needs them.

use std::fmt;

use openbench_core::LonLat;

use crate::tags::Tags;

/// A node: a position with tags.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Node {
    /// Positive if assigned by the OSM database, negative for local data.
    pub id: i64,
    /// Position, degrees WGS 84.
    pub position: LonLat,
    /// Its tags.
    pub tags: Tags,
}

/// A way: a line through nodes. It is an area if it is closed and its tags say so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Way {
    /// Numbered like nodes, but separately from them.
    pub id: i64,
    /// The nodes in order. Some may be missing from the data, and the list may be empty.
    pub nodes: Vec<i64>,
    /// Its tags.
    pub tags: Tags,
}

impl Way {
    /// Whether the way ends where it begins and has at least three corners.
    pub fn is_closed(&self) -> bool {
        self.nodes.len() > 3 && self.nodes.first() == self.nodes.last()
    }
}

/// A relation: a list of elements, each in a role.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Relation {
    /// Numbered like nodes, but separately from them.
    pub id: i64,
    /// The members in order. Some may be missing from the data.
    pub members: Vec<Member>,
    /// Its tags.
    pub tags: Tags,
}

/// A member of a relation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// The kind of element.
    pub kind: ElementKind,
    /// Its number among the elements of that kind.
    pub id: i64,
    /// Its role in the relation: `outer`, `inner`, `entrance`, … or empty.
    pub role: String,
}

impl Member {
    /// The element that is the member.
    pub const fn element(&self) -> ElementId {
        ElementId {
            kind: self.kind,
            id: self.id,
        }
    }
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
    /// The element's name in OSM XML.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Way => "way",
            Self::Relation => "relation",
        }
    }
}

/// Identifies one element: a number is unique only among elements of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ElementId {
    /// The kind of element.
    pub kind: ElementKind,
    /// Its number among the elements of that kind.
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
