//! The ways of the network, out of all that a map holds: first ways, then the nodes that they go through.

use std::collections::{HashMap, HashSet};

use openbench_osm::stream::{Elements, NodeRef, RelationRef, Visitor, WayRef, Words};
use openbench_osm::{ElementKind, OsmError};

use super::Restriction;
use super::squares::CORNERS;
use super::words::{Classes, Names};
use crate::geo::Place;
use crate::profile::CROSSING;

/// Ways in between that a turn restriction may have.
pub(crate) const VIA_WAYS: usize = 16;
/// Ways that a turn restriction may lead from, or to.
const ENDS: usize = 8;
/// Nodes that the outlines of all squares that are relations may have together.
const OUTLINES: usize = 10_000_000;

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
    /// The ways in between of all restrictions.
    pub(super) via_ways: Vec<i64>,
    pub(super) restriction_sets: Classes,
    /// Turn restrictions that are not understood.
    pub(super) odd_restrictions: usize,
    pub(super) squares: Vec<Square>,
    /// The nodes of all squares.
    pub(super) corners: Vec<i64>,
    /// Squares whose outline is not all there, or too long.
    pub(super) squares_without_outline: usize,
}

/// A pedestrian area, which is crossed.
#[derive(Debug, Clone)]
pub(super) struct Square {
    /// The way or relation.
    pub(super) id: i64,
    pub(super) is_relation: bool,
    /// Its outline and its holes, the ways that they are made of.
    pub(super) outlines: Vec<i64>,
    /// The nodes of the outline and the holes, each but the last one once.
    pub(super) rings: Vec<Vec<i64>>,
    pub(super) class: u32,
    pub(super) name: u32,
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
    /// Seconds that a ferry takes, if its timetable says so.
    pub(super) seconds: Option<f64>,
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
            via_ways: Vec::new(),
            restriction_sets: Classes::new(),
            odd_restrictions: 0,
            squares: Vec::new(),
            corners: Vec::new(),
            squares_without_outline: 0,
        };
        source.visit(&mut ways)?;
        ways.read_outlines(source)?;
        // Of ways that stand there twice the later counts.
        ways.ways.reverse();
        ways.ways.sort_by_key(|way| way.id);
        ways.ways.dedup_by_key(|way| way.id);
        Ok(ways)
    }

    /// The outlines of squares that are relations.
    fn read_outlines(&mut self, source: &impl Elements) -> Result<(), OsmError> {
        let wanted: HashSet<i64> = self
            .squares
            .iter()
            .filter(|s| s.rings.is_empty())
            .flat_map(|s| &s.outlines)
            .copied()
            .collect();
        if !wanted.is_empty() {
            let mut outlines = Outlines {
                wanted,
                lines: HashMap::new(),
            };
            source.visit(&mut outlines)?;
            // A million relations can name the same outline.
            let mut room = OUTLINES;
            for square in self
                .squares
                .iter_mut()
                .filter(|square| square.rings.is_empty())
            {
                let lines: Option<Vec<&[i64]>> = square
                    .outlines
                    .iter()
                    .map(|way| outlines.lines.get(way).map(Vec::as_slice))
                    .collect();
                let size = |lines: &Vec<&[i64]>| lines.iter().map(|line| line.len()).sum::<usize>();
                let lines = lines.filter(|lines| size(lines) <= room.min(2 * CORNERS));
                room -= lines.as_ref().map_or(0, size);
                square.rings = lines.and_then(joined).unwrap_or_default();
            }
        }
        let all = self.squares.len();
        self.squares.retain(|square| !square.rings.is_empty());
        self.squares_without_outline = all - self.squares.len();
        self.squares
            .sort_by_key(|square| (square.is_relation, square.id));
        self.squares
            .dedup_by_key(|square| (square.is_relation, square.id));
        // What is crossed is part of the network, and so are its corners.
        let corners = self
            .squares
            .iter()
            .flat_map(|square| square.rings.iter().flatten());
        self.corners = corners.copied().collect();
        Ok(())
    }

    pub(super) fn nodes(&self, way: &Way) -> &[i64] {
        &self.references[way.first..way.first + way.count]
    }
}

impl Ways {
    /// Takes down a turn restriction.
    fn restriction(&mut self, relation: RelationRef<'_>) {
        let members = |role: &'static str, kind| {
            let members = relation
                .members
                .iter()
                .filter(move |m| m.role == role && m.kind == kind);
            members.map(|member| member.id)
        };
        // Several roads may be forbidden to be entered, or to be come from.
        let several = |role| {
            let ways: Vec<i64> = members(role, ElementKind::Way).take(ENDS + 1).collect();
            Some(ways).filter(|ways| (1..=ENDS).contains(&ways.len()))
        };
        let [from, to] = ["from", "to"].map(several);
        let ways: Vec<i64> = members("via", ElementKind::Way)
            .take(VIA_WAYS + 1)
            .collect();
        let mut nodes = members("via", ElementKind::Node);
        let via = match (nodes.next(), nodes.next(), ways.len()) {
            (Some(node), None, 0) => Some(node),
            (None, None, 1..=VIA_WAYS) => Some(0),
            _ => None,
        };
        let (Some(from), Some(via), Some(to)) = (from, via, to) else {
            self.odd_restrictions += 1;
            return;
        };
        let (words, count) = (
            self.restriction_sets.number(relation.tags, None),
            ways.len() as u32,
        );
        for (from, to) in from
            .iter()
            .flat_map(|from| to.iter().map(move |to| (*from, *to)))
        {
            self.via_ways.extend(&ways);
            self.restrictions.push(Restriction {
                from,
                via,
                to,
                words,
                ways: count,
            });
        }
    }
}

impl Visitor for Ways {
    fn wants(&self, kind: ElementKind) -> bool {
        kind != ElementKind::Node
    }

    fn relation(&mut self, relation: RelationRef<'_>) {
        if relation.tags.get("type") == Some("multipolygon") && is_for_pedestrians(relation.tags) {
            let class = self.classes.number(relation.tags, Some((CROSSING, "yes")));
            let ways = relation
                .members
                .iter()
                .filter(|member| member.kind == ElementKind::Way);
            let mut outlines: Vec<i64> = ways.map(|way| way.id).collect();
            outlines.sort_unstable();
            outlines.dedup();
            let name = self.names.number(relation.tags);
            let (id, is_relation) = (relation.id, true);
            self.squares.push(Square {
                id,
                is_relation,
                outlines,
                rings: Vec::new(),
                class,
                name,
            });
        }
        if !relation
            .tags
            .get("type")
            .is_some_and(|kind| kind.starts_with("restriction"))
        {
            return;
        }
        self.restriction(relation);
    }

    fn way(&mut self, way: WayRef<'_>) {
        if way.nodes.len() < 2 || !is_way_of_network(way.tags) {
            return;
        }
        self.conditional += usize::from(
            way.tags
                .0
                .iter()
                .any(|(key, _)| key.ends_with(":conditional")),
        );
        let (class, name) = (
            self.classes.number(way.tags, None),
            self.names.number(way.tags),
        );
        let closed = way.nodes.len() > 3 && way.nodes.first() == way.nodes.last();
        if closed && way.tags.get("area") == Some("yes") && is_for_pedestrians(way.tags) {
            let class = self.classes.number(way.tags, Some((CROSSING, "yes")));
            let (id, rings) = (way.id, vec![way.nodes[1..].to_vec()]);
            self.squares.push(Square {
                id,
                is_relation: false,
                outlines: vec![id],
                rings,
                class,
                name,
            });
        }
        let (first, count) = (self.references.len(), way.nodes.len());
        let ferry = way.tags.get("route") == Some("ferry");
        let seconds = way.tags.get("duration").filter(|_| ferry).and_then(seconds);
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

/// `MM`, `HH:MM`, `HH:MM:SS`, or as ISO 8601 has it, `PT1H30M`.
fn seconds(duration: &str) -> Option<f64> {
    let text = duration.trim();
    let (mut total, mut units) = (0.0, Vec::new());
    if let Some(mut rest) = text.strip_prefix("PT") {
        while let Some(unit) = rest.find(['H', 'M', 'S']) {
            units.push((
                rest[..unit].parse::<f64>().ok()?,
                match rest.as_bytes()[unit] {
                    b'H' => 3600.0,
                    b'M' => 60.0,
                    _ => 1.0,
                },
            ));
            rest = &rest[unit + 1..];
        }
    } else {
        let parts: Vec<&str> = text.split(':').collect();
        let sizes: &[f64] = match parts.len() {
            1 => &[60.0],
            2 => &[3600.0, 60.0],
            3 => &[3600.0, 60.0, 1.0],
            _ => return None,
        };
        for (part, size) in parts.iter().zip(sizes) {
            units.push((part.parse::<f64>().ok()?, *size));
        }
    }
    for (count, size) in units {
        total += count * size;
    }
    (1.0..1e6).contains(&total).then_some(total)
}

fn is_for_pedestrians(words: Words<'_>) -> bool {
    matches!(
        words.get("highway"),
        Some("pedestrian" | "footway" | "path" | "platform")
    )
}

/// The nodes of ways that are wanted.
struct Outlines {
    wanted: HashSet<i64>,
    lines: HashMap<i64, Vec<i64>>,
}

impl Visitor for Outlines {
    fn wants(&self, kind: ElementKind) -> bool {
        kind == ElementKind::Way
    }

    fn way(&mut self, way: WayRef<'_>) {
        if (2..=CORNERS + 1).contains(&way.nodes.len()) && self.wanted.contains(&way.id) {
            self.lines.insert(way.id, way.nodes.to_vec());
        }
    }
}

/// Rings, each node once, of lines that are rings or go on in one another; `None` if an end is left over.
fn joined(mut lines: Vec<&[i64]>) -> Option<Vec<Vec<i64>>> {
    let mut rings = Vec::new();
    while let Some(line) = lines.pop() {
        let mut ring = line.to_vec();
        while let (Some(first), Some(last)) = (ring.first().copied(), ring.last().copied()) {
            if first == last {
                break;
            }
            let next = lines
                .iter()
                .position(|line| line.first() == Some(&last) || line.last() == Some(&last))?;
            let line = lines.swap_remove(next);
            if line.first() == Some(&last) {
                ring.extend(&line[1..]);
            } else {
                ring.extend(line[..line.len() - 1].iter().rev());
            }
        }
        ring.pop();
        if ring.len() < 3 {
            return None;
        }
        rings.push(ring);
    }
    Some(rings)
}

/// Whether some profile may have something to say about a way: all roads, ferries, platforms, piers and car parks, and what says in
/// so many words who may go there.
fn is_way_of_network(words: Words<'_>) -> bool {
    const PLACES: [&str; 7] = [
        "amenity",
        "bridge",
        "man_made",
        "platform",
        "public_transport",
        "railway",
        "route",
    ];
    const GOERS: [&str; 7] = [
        "access",
        "bicycle",
        "foot",
        "motor_vehicle",
        "motorcar",
        "vehicle",
        "wheelchair",
    ];
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
        let mut ids = [ways.references.as_slice(), &ways.corners].concat();
        ids.sort_unstable();
        ids.dedup();
        ids.shrink_to_fit();
        let (places, classes) = (vec![None; ids.len()], vec![0; ids.len()]);
        let mut reader = Reader {
            nodes: Self {
                ids,
                places,
                classes,
                sets: Classes::new(),
            },
            next: 0,
        };
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
        self.nodes.classes[index] = if node.tags.0.is_empty() {
            0
        } else {
            self.nodes.sets.number(node.tags, None)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::{joined, seconds};

    #[test]
    fn outlines_are_joined_end_to_end() {
        let ring = |lines: &[&[i64]]| joined(lines.to_vec());
        assert_eq!(ring(&[&[1, 2, 3, 1]]), Some(vec![vec![1, 2, 3]]));
        assert_eq!(
            ring(&[&[1, 2], &[4, 3, 2], &[4, 1]]),
            Some(vec![vec![4, 1, 2, 3]])
        );
        assert_eq!(
            ring(&[&[7, 8, 9, 7], &[1, 2, 3], &[1, 3]]).map(|rings| rings.len()),
            Some(2)
        );
        assert_eq!(ring(&[&[1, 2], &[2, 3]]), None);
        assert_eq!(ring(&[&[1, 2], &[2, 1]]), None);
    }

    #[test]
    fn timetables_are_read() {
        for (text, expected) in [
            ("10", 600.0),
            ("01:30", 5400.0),
            ("0:10:30", 630.0),
            ("PT1H30M", 5400.0),
            ("PT45S", 45.0),
        ] {
            assert_eq!(seconds(text), Some(expected), "{text}");
        }
        for text in ["", "soon", "-5", "1:2:3:4", "PT", "PTxH", "nan", "inf"] {
            assert_eq!(seconds(text), None, "{text}");
        }
    }
}
