//! Reads the elements of the network, out of all that a map holds: first ways, then the nodes that
//! they go through.

use openbench_osm::visitor::{
    Elements, MemberRef, NodeRef, RelationRef, TagRef, TagsRef, Visitor, WayRef,
};
use openbench_osm::{ElementKind, OsmError};

use super::elements::{Nodes, Square, Way, Ways};
use super::graph::{MOST_VIA_WAYS, Restriction};
use super::outlines::read_outlines;
use super::tag_sets::Classes;
use super::timetable::seconds;
use crate::geo::Place;
use crate::profile::CROSSING;

/// The most ways that a turn restriction may lead from, or to.
const MOST_ENDS: usize = 8;

/// Added to the tags of a square where it is crossed.
const CROSSED: TagRef<'static> = TagRef::new(CROSSING, "yes");

impl Ways {
    /// The ways, squares and turn restrictions of a map.
    pub(super) fn read(source: &impl Elements) -> Result<Self, OsmError> {
        let mut ways = Self::new();
        source.visit(&mut ways)?;
        read_outlines(source, &mut ways.squares)?;
        ways.sort_squares();
        // If a way appears twice, the later one counts.
        ways.ways.reverse();
        ways.ways.sort_by_key(|way| way.id);
        ways.ways.dedup_by_key(|way| way.id);
        Ok(ways)
    }

    /// Drops squares without an outline, and sorts the others.
    fn sort_squares(&mut self) {
        let all = self.squares.len();
        self.squares.retain(|square| !square.rings.is_empty());
        self.squares_without_outline = all - self.squares.len();
        self.squares
            .sort_by_key(|square| (square.is_relation, square.id));
        self.squares
            .dedup_by_key(|square| (square.is_relation, square.id));
        // Squares that are crossed are part of the network, and so are their corners.
        let corners = self
            .squares
            .iter()
            .flat_map(|square| square.rings.iter().flatten());
        self.corners = corners.copied().collect();
    }

    fn take_square(&mut self, relation: RelationRef<'_>) {
        let ways = relation.members.iter().filter(|member| is_way(member));
        let mut outlines: Vec<i64> = ways.map(|way| way.element.id).collect();
        // A member that is listed twice would leave an end over when rings are joined.
        outlines.sort_unstable();
        outlines.dedup();
        self.squares.push(Square {
            id: relation.id,
            is_relation: true,
            outlines,
            rings: Vec::new(),
            class: self.classes.number(relation.tags, Some(CROSSED)),
            name: self.names.number(relation.tags),
        });
    }

    fn take_restriction(&mut self, relation: RelationRef<'_>) {
        // A restriction may name several ways to come from, or to enter.
        let from = at_most(ways_in_role(relation, "from"), MOST_ENDS);
        let to = at_most(ways_in_role(relation, "to"), MOST_ENDS);
        let via_ways: Vec<i64> = ways_in_role(relation, "via")
            .take(MOST_VIA_WAYS + 1)
            .collect();
        let mut nodes = members(relation, "via", ElementKind::Node);
        let via = match (nodes.next(), nodes.next(), via_ways.len()) {
            (Some(node), None, 0) => Some(node),
            (None, None, 1..=MOST_VIA_WAYS) => Some(0),
            _ => None,
        };
        let (Some(from), Some(via), Some(to)) = (from, via, to) else {
            self.odd_restrictions += 1;
            return;
        };
        let tags = self.restriction_sets.number(relation.tags, None);
        let ways = via_ways.len() as u32;
        // Readers of restrictions take their ways in between off one column in order. Each pair
        // therefore has its own copy.
        for &from in &from {
            for &to in &to {
                self.via_ways.extend(&via_ways);
                self.restrictions.push(Restriction {
                    from,
                    via,
                    to,
                    tags,
                    ways,
                });
            }
        }
    }
}

impl Visitor for Ways {
    fn wants(&self, kind: ElementKind) -> bool {
        kind != ElementKind::Node
    }

    fn relation(&mut self, relation: RelationRef<'_>) {
        let kind = relation.tags.get("type").unwrap_or_default();
        if kind == "multipolygon" && is_for_pedestrians(relation.tags) {
            self.take_square(relation);
        } else if kind.starts_with("restriction") {
            self.take_restriction(relation);
        }
    }

    fn way(&mut self, way: WayRef<'_>) {
        if way.nodes.len() < 2 || !is_way_of_network(way.tags) {
            return;
        }
        let is_conditional = |tag: &TagRef<'_>| tag.key.ends_with(":conditional");
        self.conditional += usize::from(way.tags.0.iter().any(is_conditional));
        // The outline of a square is a way of its own, with a class without the tag for crossings:
        // a profile may walk along it and not across.
        let class = self.classes.number(way.tags, None);
        let name = self.names.number(way.tags);
        if is_area(way) && is_for_pedestrians(way.tags) {
            self.squares.push(Square {
                id: way.id,
                is_relation: false,
                outlines: vec![way.id],
                // The way is closed, so the first node is also the last.
                rings: vec![way.nodes[1..].to_vec()],
                class: self.classes.number(way.tags, Some(CROSSED)),
                name,
            });
        }
        let (first, count) = (self.references.len(), way.nodes.len());
        let seconds = ferry_duration(way.tags).and_then(seconds);
        self.ways.push(Way {
            id: way.id,
            first,
            count,
            class,
            name,
            seconds,
        });
        self.references.extend_from_slice(way.nodes);
    }
}

/// Members of a relation by their role and kind.
fn members<'a>(
    relation: RelationRef<'a>,
    role: &'static str,
    kind: ElementKind,
) -> impl Iterator<Item = i64> + 'a {
    let members = relation.members.iter();
    members
        .filter(move |member| member.role == role && member.element.kind == kind)
        .map(|member| member.element.id)
}

fn ways_in_role<'a>(
    relation: RelationRef<'a>,
    role: &'static str,
) -> impl Iterator<Item = i64> + 'a {
    members(relation, role, ElementKind::Way)
}

/// All of one to `most` ways; `None` if there are none, or more.
fn at_most(ways: impl Iterator<Item = i64>, most: usize) -> Option<Vec<i64>> {
    // One more than allowed is enough to know that there are too many.
    let ways: Vec<i64> = ways.take(most + 1).collect();
    (1..=most).contains(&ways.len()).then_some(ways)
}

fn is_way(member: &MemberRef<'_>) -> bool {
    member.element.kind == ElementKind::Way
}

fn is_area(way: WayRef<'_>) -> bool {
    let is_closed = way.nodes.len() > 3 && way.nodes.first() == way.nodes.last();
    is_closed && way.tags.get("area") == Some("yes")
}

fn is_for_pedestrians(tags: TagsRef<'_>) -> bool {
    matches!(
        tags.get("highway"),
        Some("pedestrian" | "footway" | "path" | "platform")
    )
}

fn ferry_duration<'a>(tags: TagsRef<'a>) -> Option<&'a str> {
    tags.get("duration")
        .filter(|_| tags.get("route") == Some("ferry"))
}

/// Whether some profile may have a rule for a way: all roads, ferries, platforms, piers and car
/// parks, and places whose tags say who may go there.
fn is_way_of_network(tags: TagsRef<'_>) -> bool {
    const PLACES: [&str; 7] = [
        "amenity",
        "bridge",
        "man_made",
        "platform",
        "public_transport",
        "railway",
        "route",
    ];
    const ACCESS: [&str; 7] = [
        "access",
        "bicycle",
        "foot",
        "motor_vehicle",
        "motorcar",
        "vehicle",
        "wheelchair",
    ];
    let mut is_place = false;
    let mut has_access = false;
    for TagRef { key, value } in tags.0 {
        let is_known = matches!(
            (*key, *value),
            ("highway", _)
                | ("route", "ferry")
                | ("man_made", "pier")
                | ("railway" | "public_transport", "platform")
                | ("amenity", "parking" | "parking_entrance")
        );
        if is_known {
            return true;
        }
        // Other places count only if their tags say who may go there, in any order of tags.
        is_place |= PLACES.contains(key);
        has_access |= ACCESS.contains(&key.split(':').next().unwrap_or_default());
    }
    is_place && has_access
}

impl Nodes {
    /// The nodes that `ways` go through.
    pub(super) fn read(source: &impl Elements, ways: &Ways) -> Result<Self, OsmError> {
        let mut ids = [ways.references.as_slice(), &ways.corners].concat();
        ids.sort_unstable();
        ids.dedup();
        ids.shrink_to_fit();
        let (places, classes) = (vec![None; ids.len()], vec![0; ids.len()]);
        let nodes = Self {
            ids,
            places,
            classes,
            sets: Classes::new(),
        };
        let mut reader = Reader { nodes, next: 0 };
        source.visit(&mut reader)?;
        Ok(reader.nodes)
    }
}

struct Reader {
    nodes: Nodes,
    /// The index at which the next node is looked for first: in most files they are in order.
    next: usize,
}

impl Visitor for Reader {
    fn wants(&self, kind: ElementKind) -> bool {
        kind == ElementKind::Node
    }

    fn node(&mut self, node: NodeRef<'_>) {
        // `next` only advances, so a file in order is read in linear time. A node out of order is
        // found by the binary search below.
        while self
            .nodes
            .ids
            .get(self.next)
            .is_some_and(|id| *id < node.id)
        {
            self.next += 1;
        }
        let in_order = self.nodes.ids.get(self.next) == Some(&node.id);
        let index = if in_order {
            Some(self.next)
        } else {
            self.nodes.index(node.id)
        };
        let Some(index) = index else { return };
        self.nodes.places[index] = Place::new(node.position);
        let is_bare = node.tags.0.is_empty();
        self.nodes.classes[index] = if is_bare {
            0
        } else {
            self.nodes.sets.number(node.tags, None)
        };
    }
}
