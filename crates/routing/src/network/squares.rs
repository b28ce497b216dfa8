//! Lines across pedestrian areas, so that they are crossed and not walked around.
//!
//! Of all lines between corners that see each other those are kept that lie on a shortest path
//! from one entry to another: T. Lozano-Pérez, M. Wesley, *An algorithm for planning
//! collision-free paths among polyhedral obstacles*, 1979.

use super::elements::{MOST_CORNERS, Nodes, Square, Ways};
use super::spanner::{Lines, thinned};
use super::visibility::{Corner, mark_reflex, sees};
use crate::geo::distance;

/// Areas with more entries than this are walked around, not crossed.
const MOST_ENTRIES: usize = 100;
/// Work is the cube of an area's corners. Beyond this sum the areas that follow are walked around:
/// of a map of nothing but areas of 400 corners, 300 are crossed.
const MOST_WORK: u64 = 20_000_000_000;

/// The lines across all squares.
#[derive(Debug, Default)]
pub(super) struct Crossings {
    pub(super) lines: Vec<Crossing>,
    /// How many squares are not crossed.
    pub(super) too_large: usize,
}

/// A line across a square, between two nodes given by their indices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) square: usize,
    pub(super) ends: [usize; 2],
}

/// The lines across all squares. The nodes at their ends are made vertices.
pub(super) fn crossings(ways: &Ways, nodes: &Nodes, uses: &mut [u8]) -> Crossings {
    let mut crossings = Crossings::default();
    let mut work = 0;
    for (number, square) in ways.squares.iter().enumerate() {
        let Some(shape) = Shape::new(ways, square, nodes, uses) else {
            continue;
        };
        let is_large = shape.corners.len() > MOST_CORNERS || shape.entries.len() > MOST_ENTRIES;
        if !is_large && shape.entries.len() > 1 {
            // Each pair of corners is tested against each side.
            work += (shape.corners.len() as u64).pow(3);
        }
        if is_large || work > MOST_WORK {
            crossings.too_large += 1;
            continue;
        }
        for line in shape.lines() {
            let ends = line.map(|corner| shape.corners[corner].node);
            for end in ends {
                // Two uses make a node a vertex.
                uses[end] = uses[end].max(2);
            }
            crossings.lines.push(Crossing {
                square: number,
                ends,
            });
        }
    }
    crossings
}

/// A square with its corners and entries.
struct Shape {
    corners: Vec<Corner>,
    /// The corners at which other ways meet the square.
    entries: Vec<usize>,
    /// Whether the outline is a way of its own, so that lines along it exist already.
    outlined: bool,
}

impl Shape {
    /// `None` if a node of the outline is missing.
    fn new(ways: &Ways, square: &Square, nodes: &Nodes, uses: &[u8]) -> Option<Self> {
        let mut corners: Vec<Corner> = Vec::new();
        for ring in &square.rings {
            let (first, count) = (corners.len(), ring.len());
            for (i, id) in ring.iter().enumerate() {
                let node = nodes.index(*id)?;
                corners.push(Corner {
                    node,
                    place: nodes.places[node]?,
                    before: first + (i + count - 1) % count,
                    behind: first + (i + 1) % count,
                    reflex: false,
                });
            }
        }
        mark_reflex(&mut corners, square.rings.iter().map(Vec::len));
        let is_entry = |corner: &usize| {
            let node = corners[*corner].node;
            // More uses than the outline's own: another way meets the square here.
            uses[node] > own_uses(ways, square, nodes.ids[node])
        };
        let entries = (0..corners.len()).filter(is_entry).collect();
        Some(Self {
            corners,
            entries,
            outlined: !square.is_relation,
        })
    }

    /// The lines that lie on a shortest path between entries, as pairs of corners.
    fn lines(&self) -> Vec<[usize; 2]> {
        if self.entries.len() < 2 {
            return Vec::new();
        }
        let points = self.points();
        let kept = self.lines_between_entries(&points);
        let length = |ends: [usize; 2]| self.length(ends.map(|end| points[end]));
        let kept = thinned(points.len(), &kept, length);
        // Thinning sees lines along the outline too, so that they can stand for others. They are
        // left out afterwards if the outline is a way anyway.
        let lines = kept.into_iter().map(|ends| ends.map(|end| points[end]));
        lines
            .filter(|ends| !(self.outlined && self.are_neighbours(*ends)))
            .collect()
    }

    /// The corners at which a shortest path can begin, turn or end.
    fn points(&self) -> Vec<usize> {
        let turning = (0..self.corners.len()).filter(|corner| self.corners[*corner].reflex);
        let mut points: Vec<usize> = self.entries.iter().copied().chain(turning).collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// The lines of all shortest paths between entries, as pairs of indices into `points`.
    fn lines_between_entries(&self, points: &[usize]) -> Vec<[usize; 2]> {
        let visible = self.visible_lines(points);
        let entries: Vec<usize> = self
            .entries
            .iter()
            .filter_map(|entry| points.binary_search(entry).ok())
            .collect();
        let mut kept = Vec::new();
        for from in &entries {
            let paths = visible.shortest(*from);
            for to in &entries {
                kept.extend(paths.lines_to(*to));
            }
        }
        kept.sort_unstable();
        kept.dedup();
        kept
    }

    /// All lines between points that see each other.
    fn visible_lines(&self, points: &[usize]) -> Lines {
        let mut lines = Lines::new(points.len());
        for i in 0..points.len() {
            for j in 0..i {
                let ends = [points[i], points[j]];
                let [a, b] = ends;
                let apart = self.corners[a].place != self.corners[b].place;
                // Neighbours see each other along their side. `sees` cannot tell: the middle of a
                // side is neither inside nor outside.
                if apart && (self.are_neighbours(ends) || sees(&self.corners, a, b)) {
                    lines.add(i, j, self.length(ends));
                }
            }
        }
        lines
    }

    /// Metres between two corners.
    fn length(&self, ends: [usize; 2]) -> f64 {
        let [a, b] = ends.map(|corner| self.corners[corner].place);
        distance(a, b)
    }

    /// Whether one corner follows the other on a ring.
    fn are_neighbours(&self, [a, b]: [usize; 2]) -> bool {
        self.corners[a].before == b || self.corners[a].behind == b
    }
}

/// How often a square's own outline uses one of its nodes: a closed way uses each node once, and
/// the one at which it begins four times. Outlines of relations are no ways of the network.
fn own_uses(ways: &Ways, square: &Square, node: i64) -> u8 {
    if square.is_relation {
        return 0;
    }
    let begins_here = |id: &i64| {
        let way = ways.ways.binary_search_by_key(id, |way| way.id);
        way.is_ok_and(|way| ways.nodes(&ways.ways[way]).first() == Some(&node))
    };
    if square.outlines.iter().any(begins_here) {
        4
    } else {
        1
    }
}
