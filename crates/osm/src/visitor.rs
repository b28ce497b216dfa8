//! Elements shown one after another to a visitor, which keeps what it needs.

use openbench_core::LonLat;

use crate::element::{ElementId, ElementKind};
use crate::error::OsmError;
use crate::tags::Tags;

/// A tag, borrowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TagRef<'a> {
    /// The key, for example `highway`.
    pub key: &'a str,
    /// The value, for example `footway`.
    pub value: &'a str,
}

impl<'a> TagRef<'a> {
    /// The tag `key=value`.
    pub const fn new(key: &'a str, value: &'a str) -> Self {
        Self { key, value }
    }
}

/// The tags of an element, borrowed, in the order of the file. A key may appear twice.
#[derive(Debug, Clone, Copy, Default)]
pub struct TagsRef<'a>(pub &'a [TagRef<'a>]);

impl<'a> TagsRef<'a> {
    /// The value of `key`. If the key appears several times, the last value, as in [`Tags`].
    pub fn get(&self, key: &str) -> Option<&'a str> {
        self.0
            .iter()
            .rev()
            .find(|tag| tag.key == key)
            .map(|tag| tag.value)
    }
}

impl From<TagsRef<'_>> for Tags {
    fn from(tags: TagsRef<'_>) -> Self {
        tags.0.iter().map(|tag| (tag.key, tag.value)).collect()
    }
}

/// A node that is being read.
#[derive(Debug, Clone, Copy)]
pub struct NodeRef<'a> {
    /// Its number.
    pub id: i64,
    /// Its position as the file states it, degrees WGS 84. It may be off the Earth.
    pub position: LonLat,
    /// Its tags.
    pub tags: TagsRef<'a>,
}

/// A way that is being read.
#[derive(Debug, Clone, Copy)]
pub struct WayRef<'a> {
    /// Its number.
    pub id: i64,
    /// Its nodes in order. The file may lack some of them.
    pub nodes: &'a [i64],
    /// Its tags.
    pub tags: TagsRef<'a>,
}

/// A relation that is being read.
#[derive(Debug, Clone, Copy)]
pub struct RelationRef<'a> {
    /// Its number.
    pub id: i64,
    /// Its members in order. The file may lack some of them.
    pub members: &'a [MemberRef<'a>],
    /// Its tags.
    pub tags: TagsRef<'a>,
}

/// A member of a relation.
#[derive(Debug, Clone, Copy)]
pub struct MemberRef<'a> {
    /// The element.
    pub element: ElementId,
    /// Its role in the relation: `outer`, `via`, … or empty.
    pub role: &'a str,
}

/// Receives the elements of a map. Each method does nothing unless it is overridden.
pub trait Visitor {
    /// Whether elements of this kind are wanted. Skipped kinds cost next to nothing to read.
    fn wants(&self, _kind: ElementKind) -> bool {
        true
    }

    /// Receives a node.
    fn node(&mut self, _node: NodeRef<'_>) {}

    /// Receives a way.
    fn way(&mut self, _way: WayRef<'_>) {}

    /// Receives a relation.
    fn relation(&mut self, _relation: RelationRef<'_>) {}

    /// Called once for each element that is marked as deleted and therefore not shown.
    fn deleted(&mut self) {}
}

/// A map whose elements can be visited, several times over.
pub trait Elements {
    /// Shows all elements to `visitor`.
    ///
    /// # Errors
    /// If the underlying bytes are malformed. Elements before that place have been shown.
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError>;
}
