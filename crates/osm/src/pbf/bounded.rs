//! No more elements than a map of that size can have.
//!
//! Equal numbers compress by a factor of a thousand, so that a megabyte can ask for a gigabyte of
//! nodes. In real maps a node takes several bytes, since positions do not repeat.

use crate::element::ElementKind;
use crate::error::Problem;
use crate::visitor::{NodeRef, RelationRef, Visitor, WayRef};

/// So many of each kind may be in a file of any size.
const ALWAYS_ALLOWED: u64 = 1_000_000;
/// Most nodes, ways and relations for a byte of the file.
const ELEMENTS_PER_BYTE: u64 = 1;
/// Most tags for a byte of the file.
const TAGS_PER_BYTE: u64 = 2;
/// Most nodes of ways and members of relations for a byte of the file.
const REFERENCES_PER_BYTE: u64 = 8;

/// Shows elements to a visitor as long as their number is possible.
pub(super) struct Bounded<'v, V> {
    visitor: &'v mut V,
    elements: Quota,
    tags: Quota,
    references: Quota,
}

/// How many more there may be.
struct Quota {
    left: u64,
    exceeded: bool,
}

impl Quota {
    fn new(bytes: usize, per_byte: u64) -> Self {
        Self {
            left: ALWAYS_ALLOWED + per_byte * bytes as u64,
            exceeded: false,
        }
    }

    fn take(&mut self, count: usize) {
        let left = self.left.checked_sub(count as u64);
        self.exceeded |= left.is_none();
        self.left = left.unwrap_or(0);
    }
}

impl<'v, V> Bounded<'v, V> {
    /// For a file of so many bytes.
    pub(super) fn new(visitor: &'v mut V, bytes: usize) -> Self {
        Self {
            visitor,
            elements: Quota::new(bytes, ELEMENTS_PER_BYTE),
            tags: Quota::new(bytes, TAGS_PER_BYTE),
            references: Quota::new(bytes, REFERENCES_PER_BYTE),
        }
    }

    /// Whether a map can have the elements so far.
    pub(super) fn check(&self) -> Result<(), Problem> {
        if self.is_exceeded() {
            return Err(
                "the file has more elements than a map of its size; it is damaged or no map".into(),
            );
        }
        Ok(())
    }

    fn is_exceeded(&self) -> bool {
        self.elements.exceeded || self.tags.exceeded || self.references.exceeded
    }

    /// Counts an element; whether the visitor gets it.
    fn admits(&mut self, tags: usize, references: usize) -> bool {
        self.elements.take(1);
        self.tags.take(tags);
        self.references.take(references);
        !self.is_exceeded()
    }
}

impl<V: Visitor> Visitor for Bounded<'_, V> {
    fn wants(&self, kind: ElementKind) -> bool {
        self.visitor.wants(kind)
    }

    fn node(&mut self, node: NodeRef<'_>) {
        if self.admits(node.tags.0.len(), 0) {
            self.visitor.node(node);
        }
    }

    fn way(&mut self, way: WayRef<'_>) {
        if self.admits(way.tags.0.len(), way.nodes.len()) {
            self.visitor.way(way);
        }
    }

    fn relation(&mut self, relation: RelationRef<'_>) {
        if self.admits(relation.tags.0.len(), relation.members.len()) {
            self.visitor.relation(relation);
        }
    }

    fn deleted(&mut self) {
        self.visitor.deleted();
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::LonLat;

    use super::*;
    use crate::data::OsmData;
    use crate::visitor::TagsRef;

    #[test]
    fn a_few_bytes_cannot_ask_for_millions_of_nodes() {
        let mut data = OsmData::default();
        let mut bounded = Bounded::new(&mut data, 1000);
        for id in 1..=ALWAYS_ALLOWED as i64 + 1000 {
            bounded.node(NodeRef {
                id,
                position: LonLat::default(),
                tags: TagsRef::default(),
            });
        }
        assert!(bounded.check().is_ok());
        for id in 1..10 {
            bounded.node(NodeRef {
                id: -id,
                position: LonLat::default(),
                tags: TagsRef::default(),
            });
        }
        assert!(bounded.check().is_err());
        assert_eq!(data.nodes.len(), ALWAYS_ALLOWED as usize + 1000);
    }
}
