//! The ways of the network, out of all that a map holds: first ways, then the nodes that they go through.

use openbench_osm::stream::{Elements, NodeRef, RelationRef, Visitor, WayRef, Words};
use openbench_osm::{ElementKind, OsmError};

use super::Restriction;
use super::words::{Classes, Names};
use crate::geo::Place;

/// Ways that a profile may be asked about, by number.
pub(super) struct Ways {
    pub(super) classes: Classes,
    pub(super) names: Names,
    pub(super) ways: Vec<Way>,
    /// The nodes of all ways, one way after another.
    pub(super) references: Vec<i64>,
    /// Ways with words that hold at some times only.
    pub(super) conditional: usize,
    pub(super) restrictions: Vec<Restriction>,
    pub(super) restriction_sets: Classes,
    /// Turn restrictions that are not understood.
    pub(super) odd_restrictions: usize,
}

/// A way of the network.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) id: i64,
    /// Its first node among the references, and how many it has.
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) class: u32,
    pub(super) name: u32,
}

/// The nodes of the network, by number.
pub(super) struct Nodes {
    pub(super) ids: Vec<i64>,
    /// `None` for those that the map lacks.
    pub(super) places: Vec<Option<Place>>,
    pub(super) classes: Vec<u32>,
    /// The sets of words of nodes.
    pub(super) sets: Classes,
}

impl Ways {
    pub(super) fn read(source: &impl Elements) -> Result<Self, OsmError> {
        let mut ways = Self {
            classes: Classes::new(),
            names: Names::new(),
            ways: Vec::new(),
            references: Vec::new(),
            conditional: 0,
            restrictions: Vec::new(),
            restriction_sets: Classes::new(),
            odd_restrictions: 0,
        };
        source.visit(&mut ways)?;
        // Of ways that stand there twice the later counts.
        ways.ways.reverse();
        ways.ways.sort_by_key(|way| way.id);
        ways.ways.dedup_by_key(|way| way.id);
        Ok(ways)
    }

    pub(super) fn nodes(&self, way: &Way) -> &[i64] {
        &self.references[way.first..way.first + way.count]
    }
}

impl Visitor for Ways {
    fn wants(&self, kind: ElementKind) -> bool {
        kind != ElementKind::Node
    }

    fn relation(&mut self, relation: RelationRef<'_>) {
        if !relation.tags.get("type").is_some_and(|kind| kind.starts_with("restriction")) {
            return;
        }
        let member = |role: &str, kind: ElementKind| {
            let mut members = relation.members.iter().filter(|m| m.role == role && m.kind == kind);
            members.next().filter(|_| members.next().is_none()).map(|m| m.id)
        };
        let [from, to] = ["from", "to"].map(|role| member(role, ElementKind::Way));
        let via = member("via", ElementKind::Node);
        let (Some(from), Some(via), Some(to)) = (from, via, to) else {
            self.odd_restrictions += 1;
            return;
        };
        let words = self.restriction_sets.number(relation.tags, None).into();
        self.restrictions.push(Restriction { from, via, to, words });
    }

    fn way(&mut self, way: WayRef<'_>) {
        if way.nodes.len() < 2 || !is_way_of_network(way.tags) {
            return;
        }
        self.conditional += usize::from(way.tags.0.iter().any(|(key, _)| key.ends_with(":conditional")));
        let (class, name) = (self.classes.number(way.tags, None), self.names.number(way.tags));
        let (first, count) = (self.references.len(), way.nodes.len());
        self.ways.push(Way { id: way.id, first, count, class, name });
        self.references.extend_from_slice(way.nodes);
    }
}

/// Whether some profile may have something to say about a way: all roads, ferries, platforms, piers and car parks, and what says in
/// so many words who may go there.
fn is_way_of_network(words: Words<'_>) -> bool {
    const PLACES: [&str; 7] =
        ["amenity", "bridge", "man_made", "platform", "public_transport", "railway", "route"];
    const GOERS: [&str; 7] =
        ["access", "bicycle", "foot", "motor_vehicle", "motorcar", "vehicle", "wheelchair"];
    let mut place = false;
    let mut told = false;
    for (key, value) in words.0 {
        let known = matches!(
            (*key, *value),
            ("highway", _)
                | ("route", "ferry")
                | ("man_made", "pier")
                | ("railway" | "public_transport", "platform")
                | ("amenity", "parking" | "parking_entrance")
        );
        if known {
            return true;
        }
        place |= PLACES.contains(key);
        told |= GOERS.contains(&key.split(':').next().unwrap_or_default());
    }
    place && told
}

impl Nodes {
    /// The nodes that `ways` go through.
    pub(super) fn read(source: &impl Elements, ways: &Ways) -> Result<Self, OsmError> {
        let mut ids = ways.references.clone();
        ids.sort_unstable();
        ids.dedup();
        ids.shrink_to_fit();
        let (places, classes) = (vec![None; ids.len()], vec![0; ids.len()]);
        let mut reader = Reader { nodes: Self { ids, places, classes, sets: Classes::new() }, next: 0 };
        source.visit(&mut reader)?;
        Ok(reader.nodes)
    }

    /// Index of a node.
    pub(super) fn index(&self, id: i64) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }
}

struct Reader {
    nodes: Nodes,
    /// Where the next node is looked for first: in most files they stand in order.
    next: usize,
}

impl Visitor for Reader {
    fn wants(&self, kind: ElementKind) -> bool {
        kind == ElementKind::Node
    }

    fn node(&mut self, node: NodeRef<'_>) {
        while self.nodes.ids.get(self.next).is_some_and(|id| *id < node.id) {
            self.next += 1;
        }
        let in_order = self.nodes.ids.get(self.next) == Some(&node.id);
        let index = if in_order { Some(self.next) } else { self.nodes.index(node.id) };
        let Some(index) = index else { return };
        self.nodes.places[index] = Place::new(node.position);
        self.nodes.classes[index] =
            if node.tags.0.is_empty() { 0 } else { self.nodes.sets.number(node.tags, None) };
    }
}
