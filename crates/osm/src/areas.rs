//! Polygons from closed ways and multipolygons.
//!
//! Follows the OSM definition of areas: a closed way, or a relation of type `multipolygon` (or
//! `boundary`) whose members form rings. Nodes that the data lacks are skipped: the rest of the
//! outline is closer to the truth than no outline.

use std::cell::Cell;
use std::collections::BTreeSet;

use openbench_core::MapPoint;

use crate::data::OsmData;
use crate::element::{ElementKind, Relation, Way};
use crate::projection::Projection;
use crate::rings::{Assembled, assemble};
use crate::spatial::BoxTree;
use crate::tags::Tags;
use openbench_geometry::Polygon;

/// Keys that make a closed way an area.
const AREA_KEYS: [&str; 10] = [
    "landuse",
    "natural",
    "leisure",
    "amenity",
    "water",
    "place",
    "area:highway",
    "tourism",
    "man_made",
    "building:part",
];

/// Tags with one of those keys that nevertheless describe lines.
const LINES: [(&str, &str); 12] = [
    ("natural", "coastline"),
    ("natural", "cliff"),
    ("natural", "ridge"),
    ("natural", "arete"),
    ("natural", "valley"),
    ("natural", "tree_row"),
    ("leisure", "track"),
    ("leisure", "slipway"),
    ("man_made", "embankment"),
    ("man_made", "pipeline"),
    ("man_made", "breakwater"),
    ("man_made", "groyne"),
];

/// Whether the tags of a closed way or multipolygon say that it covers ground. Buildings are not
/// considered.
pub(crate) fn is_area(tags: &Tags) -> bool {
    let line = LINES.iter().any(|(key, value)| tags.is(key, value));
    let surface = AREA_KEYS.iter().any(|key| tags.says(key)) || tags.is("waterway", "riverbank");
    // `area=*` is the mapper's own word on the question, and counts before what keys imply.
    tags.is("area", "yes") || surface && !line && !tags.is("area", "no")
}

/// Whether a relation's members form rings.
pub(crate) fn is_multipolygon(relation: &Relation) -> bool {
    ["multipolygon", "boundary"]
        .iter()
        .any(|kind| relation.tags.is("type", kind))
}

/// The areas of a multipolygon.
pub(crate) struct Shapes {
    /// One for each outer ring.
    pub(crate) polygons: Vec<Polygon>,
    /// How many rings could not be used: open ones, holes in nothing, and rings beyond the budget.
    pub(crate) unused_rings: usize,
}

/// Rings of a multipolygon.
struct Rings {
    rings: Vec<Vec<MapPoint>>,
    /// How many more could not be used.
    unused: usize,
}

/// On which side of its boundary a multipolygon's area is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// Members that are outlines.
    Outer,
    /// Members that are holes.
    Inner,
}

/// Makes polygons from the elements of one map.
pub(crate) struct Shaper<'a> {
    pub(crate) data: &'a OsmData,
    pub(crate) projection: &'a Projection,
    /// How much more the map may grow, see [`Shaper::afford`].
    budget: Cell<usize>,
}

impl<'a> Shaper<'a> {
    pub(crate) fn new(data: &'a OsmData, projection: &'a Projection) -> Self {
        let references: usize = data.ways.values().map(|way| way.nodes.len()).sum();
        Self {
            data,
            projection,
            // Real maps use each node of a way in one or two areas, so 16 uses are ample. The
            // million lets small maps with many tags through.
            budget: Cell::new(1_000_000 + 16 * references),
        }
    }

    /// Whether the map may take in `points` more points with a copy of `tags`.
    ///
    /// A small file can reference one long way in very many relations, or very many parts with one
    /// long list of tags. Memory must not grow with their product.
    pub(crate) fn afford(&self, points: usize, tags: &Tags) -> bool {
        let words: usize = tags
            .iter()
            .map(|(key, value)| key.len() + value.len())
            .sum();
        // A point has 16 bytes.
        let left = self.budget.get().checked_sub(points + words / 16);
        self.budget.set(left.unwrap_or_default());
        left.is_some()
    }

    /// The position of a node; `None` if the data lacks it.
    pub(crate) fn point(&self, node: i64) -> Option<MapPoint> {
        self.data
            .nodes
            .get(&node)
            .map(|node| self.projection.to_map(node.position))
    }

    /// The area inside a closed way.
    pub(crate) fn way(&self, way: &Way) -> Option<Polygon> {
        if way.is_closed() {
            Polygon::new(self.points(&way.nodes), Vec::new())
        } else {
            None
        }
    }

    /// The areas of a multipolygon, one for each outer ring.
    pub(crate) fn relation(&self, relation: &Relation) -> Shapes {
        let outer = self.rings(relation, Side::Outer);
        let inner = self.rings(relation, Side::Inner);
        let outlines = outer.rings.into_iter();
        let mut polygons: Vec<Polygon> = outlines
            .filter_map(|ring| Polygon::new(ring, Vec::new()))
            .collect();
        let stray = cut_holes(&mut polygons, inner.rings);
        Shapes {
            polygons,
            unused_rings: outer.unused + inner.unused + stray,
        }
    }

    /// The rings that the members on one side of the boundary make.
    fn rings(&self, relation: &Relation, side: Side) -> Rings {
        let members = relation.members.iter().filter(|member| {
            member.kind == ElementKind::Way && (member.role == "inner") == (side == Side::Inner)
        });
        // Some relations list a way twice, which would make two pieces of one ring.
        let mut seen = BTreeSet::new();
        let once = members.filter(|member| seen.insert(member.id));
        let ways = once.filter_map(|member| self.data.ways.get(&member.id));
        let pieces: Vec<&[i64]> = ways.map(|way| way.nodes.as_slice()).collect();
        let length = pieces.iter().map(|piece| piece.len()).sum();
        if !self.afford(length, &Tags::new()) {
            return Rings {
                rings: Vec::new(),
                unused: 1,
            };
        }
        // The budget pays for the points once, and for a copy of the tags for each ring.
        let Assembled { rings, open } = assemble(&pieces);
        let (good, bad): (Vec<_>, Vec<_>) =
            rings.iter().partition(|_| self.afford(0, &relation.tags));
        let rings = good.into_iter().map(|ring| self.points(ring)).collect();
        Rings {
            rings,
            unused: open + bad.len(),
        }
    }

    fn points(&self, nodes: &[i64]) -> Vec<MapPoint> {
        nodes.iter().filter_map(|node| self.point(*node)).collect()
    }
}

/// Cuts each hole out of the smallest polygon around it. Returns how many holes lie in none.
fn cut_holes(polygons: &mut [Polygon], holes: Vec<Vec<MapPoint>>) -> usize {
    let tree = BoxTree::new(polygons.iter().map(Polygon::bounds));
    // An island in a lake on an island lies in two outlines. Areas are compared without holes, so
    // that the order of the holes has no effect.
    let solid = polygons.to_vec();
    let mut stray = 0;
    for hole in holes
        .into_iter()
        .filter_map(|ring| Polygon::new(ring, Vec::new()))
    {
        // Not a corner: a hole may touch the outline there, and then lies in it by chance.
        let inside = hole.interior_point();
        let around = tree
            .within(inside, 0.0)
            .into_iter()
            .filter(|i| solid[*i].contains(inside));
        match around.min_by(|a, b| solid[*a].area().total_cmp(&solid[*b].area())) {
            Some(i) => polygons[i]
                .holes
                // `Polygon::new` has made the ring counter-clockwise. Holes are clockwise.
                .push(hole.outer.into_iter().rev().collect()),
            None => stray += 1,
        }
    }
    stray
}
