//! Lines across pedestrian areas, so that they are crossed and not walked round.
//!
//! Of all corners that see each other those lines are kept that lie on a shortest way from one entry to another: T. Lozano-Pérez, M. Wesley,
//! *An algorithm for planning collision-free paths among polyhedral obstacles*, 1979. All tests are made with whole numbers.

use super::read::{Nodes, Square, Ways};
use crate::geo::{Place, distance};

/// With more corners, or entries, an area is walked round.
pub(super) const CORNERS: usize = 400;
const ENTRIES: usize = 100;
/// Corners to the power of three, of all areas together, beyond which areas are walked round: a map of nothing but areas of 400 corners has 300 of them
/// crossed.
const WORK: u64 = 20_000_000_000;

/// How much longer than it must be a way across may be, as a factor.
const DETOUR: f64 = 1.05;

/// The lines across all squares.
#[derive(Debug, Default)]
pub(super) struct Crossings {
    pub(super) lines: Vec<Crossing>,
    /// Squares that are not crossed.
    pub(super) too_large: usize,
}

/// A line across a square, between two nodes by their indices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) square: usize,
    pub(super) ends: [usize; 2],
}

/// The lines across all squares; nodes at their ends are made vertices.
pub(super) fn crossings(ways: &Ways, nodes: &Nodes, uses: &mut [u8]) -> Crossings {
    let (mut crossings, mut work) = (Crossings::default(), 0);
    for (number, square) in ways.squares.iter().enumerate() {
        let Some(shape) = Shape::new(ways, square, nodes, uses) else {
            continue;
        };
        let too_large = shape.corners.len() > CORNERS || shape.entries.len() > ENTRIES;
        if !too_large && shape.entries.len() > 1 {
            work += (shape.corners.len() as u64).pow(3);
        }
        if too_large || work > WORK {
            crossings.too_large += 1;
            continue;
        }
        for [a, b] in shape.lines() {
            let ends = [shape.corners[a].node, shape.corners[b].node];
            ends.iter().for_each(|end| uses[*end] = uses[*end].max(2));
            crossings.lines.push(Crossing {
                square: number,
                ends,
            });
        }
    }
    crossings
}

/// A corner of an outline or a hole.
#[derive(Debug, Clone, Copy)]
struct Corner {
    node: usize,
    place: Place,
    /// The corners before and behind it on its ring.
    before: usize,
    behind: usize,
    /// Whether the angle inside is above 180 degrees: only there may a shortest way turn.
    reflex: bool,
}

struct Shape {
    corners: Vec<Corner>,
    entries: Vec<usize>,
    /// Whether the outline is a way of its own, so that lines along it are there already.
    outlined: bool,
}

impl Shape {
    /// `None` if a node of the outline is missing.
    fn new(ways: &Ways, square: &Square, nodes: &Nodes, uses: &[u8]) -> Option<Self> {
        let outlined = !square.is_relation;
        let mut corners: Vec<Corner> = Vec::new();
        for ring in &square.rings {
            let (first, count) = (corners.len(), ring.len());
            for (i, id) in ring.iter().enumerate() {
                let node = nodes.index(*id)?;
                let [before, behind] =
                    [(i + count - 1) % count, (i + 1) % count].map(|j| first + j);
                corners.push(Corner {
                    node,
                    place: nodes.places[node]?,
                    before,
                    behind,
                    reflex: false,
                });
            }
        }
        find_reflex(&mut corners, square.rings.iter().map(Vec::len));
        // A closed way uses each of its nodes once, and the one at which it begins four times.
        let begins = |node: usize| {
            square.outlines.iter().any(|id| {
                let way = ways.ways.binary_search_by_key(id, |way| way.id);
                way.is_ok_and(|way| ways.nodes(&ways.ways[way]).first() == Some(&nodes.ids[node]))
            })
        };
        let own = |node: usize| {
            if !outlined {
                0
            } else if begins(node) {
                4
            } else {
                1
            }
        };
        let entries = (0..corners.len())
            .filter(|c| uses[corners[*c].node] > own(corners[*c].node))
            .collect();
        Some(Self {
            corners,
            entries,
            outlined,
        })
    }

    /// The lines that lie on a shortest way between entries, as pairs of corners.
    fn lines(&self) -> Vec<[usize; 2]> {
        if self.entries.len() < 2 {
            return Vec::new();
        }
        let turning = (0..self.corners.len()).filter(|corner| self.corners[*corner].reflex);
        let mut points: Vec<usize> = self.entries.iter().copied().chain(turning).collect();
        points.sort_unstable();
        points.dedup();
        let mut lines: Vec<Vec<(usize, f64)>> = vec![Vec::new(); points.len()];
        for i in 0..points.len() {
            for j in 0..i {
                let [a, b] = [points[i], points[j]];
                let apart = self.corners[a].place != self.corners[b].place;
                if apart
                    && (self.corners[a].before == b
                        || self.corners[a].behind == b
                        || self.sees(a, b))
                {
                    let length = distance(self.corners[a].place, self.corners[b].place);
                    lines[i].push((j, length));
                    lines[j].push((i, length));
                }
            }
        }
        let mut kept: Vec<[usize; 2]> = Vec::new();
        for entry in self
            .entries
            .iter()
            .filter_map(|entry| points.binary_search(entry).ok())
        {
            let (_, tree) = shortest(&lines, entry);
            for mut at in self
                .entries
                .iter()
                .filter_map(|entry| points.binary_search(entry).ok())
            {
                while at != entry && tree[at] != usize::MAX {
                    kept.push([at.min(tree[at]), at.max(tree[at])]);
                    at = tree[at];
                }
            }
        }
        kept.sort_unstable();
        kept.dedup();
        let kept = self.thinned(&points, &kept);
        let lines = kept.into_iter().map(|ends| ends.map(|end| points[end]));
        let beside =
            |[a, b]: &[usize; 2]| self.corners[*a].before == *b || self.corners[*a].behind == *b;
        lines
            .filter(|ends| !(self.outlined && beside(ends)))
            .collect()
    }

    /// Those of the lines without which a way would be longer than it must by more than [`DETOUR`]: I. Althöfer et al., *On sparse
    /// spanners of weighted graphs*, 1993. Between a hundred entries there are thousands of lines, and a few hundred will do.
    fn thinned(&self, points: &[usize], lines: &[[usize; 2]]) -> Vec<[usize; 2]> {
        let place = |point: usize| self.corners[points[point]].place;
        let mut sorted: Vec<(f64, [usize; 2])> = lines
            .iter()
            .map(|[a, b]| (distance(place(*a), place(*b)), [*a, *b]))
            .collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut graph: Vec<Vec<(usize, f64)>> = vec![Vec::new(); points.len()];
        let mut kept = Vec::new();
        for (length, [a, b]) in sorted {
            if shortest(&graph, a).0[b] <= length * DETOUR {
                continue;
            }
            graph[a].push((b, length));
            graph[b].push((a, length));
            kept.push([a, b]);
        }
        kept
    }

    /// Whether the straight line between two corners stays inside.
    fn sees(&self, a: usize, b: usize) -> bool {
        let [p, q] = [a, b].map(|c| self.corners[c].place);
        for (i, corner) in self.corners.iter().enumerate() {
            let next = corner.behind;
            let (c, d) = (corner.place, self.corners[next].place);
            let [s, t] = [side(p, q, c), side(p, q, d)];
            let [u, v] = [side(c, d, p), side(c, d, q)];
            if s * t < 0 && u * v < 0 {
                return false;
            }
            // A corner on the line cuts it in two if the outline goes on to the other side there.
            let between = s == 0 && i != a && i != b && strictly_between(p, q, c);
            if between && side(p, q, self.corners[corner.before].place) * t <= 0 {
                return false;
            }
        }
        self.contains_middle(p, q)
    }

    /// Whether the middle between two places is inside: a ray from it eastwards meets an odd number of sides.
    fn contains_middle(&self, p: Place, q: Place) -> bool {
        let doubled = [
            i128::from(p.lon) + i128::from(q.lon),
            i128::from(p.lat) + i128::from(q.lat),
        ];
        let mut inside = false;
        for corner in &self.corners {
            let [a, b] = [corner.place, self.corners[corner.behind].place]
                .map(|place| [2 * i128::from(place.lon), 2 * i128::from(place.lat)]);
            if (a[1] > doubled[1]) != (b[1] > doubled[1]) {
                // Left of the side, without division.
                let cross =
                    (b[0] - a[0]) * (doubled[1] - a[1]) - (doubled[0] - a[0]) * (b[1] - a[1]);
                if (cross > 0) == (b[1] > a[1]) && cross != 0 {
                    inside = !inside;
                }
            }
        }
        inside
    }
}

/// The largest ring is the outline, the others are holes.
fn find_reflex(corners: &mut [Corner], rings: impl Iterator<Item = usize>) {
    let mut first = 0;
    let rings: Vec<(std::ops::Range<usize>, f64)> = rings
        .map(|count| {
            let ring = first..first + count;
            first += count;
            let origin = corners[ring.start].place;
            let at = |place: Place| {
                (
                    f64::from(place.lon) - f64::from(origin.lon),
                    f64::from(place.lat) - f64::from(origin.lat),
                )
            };
            let area = ring.clone().map(|c| {
                let ((ax, ay), (bx, by)) =
                    (at(corners[c].place), at(corners[corners[c].behind].place));
                ax * by - bx * ay
            });
            (ring, area.sum())
        })
        .collect();
    let largest = rings.iter().map(|(_, area)| area.abs()).fold(0.0, f64::max);
    for (ring, area) in rings {
        let left_is_inside = (area > 0.0) == (area.abs() == largest);
        for c in ring {
            let Corner {
                place,
                before,
                behind,
                ..
            } = corners[c];
            let turn = side(corners[before].place, place, corners[behind].place);
            corners[c].reflex = if left_is_inside { turn < 0 } else { turn > 0 };
        }
    }
}

/// On which side of the line from `a` to `b` a place is: 1 left, -1 right, 0 on it.
fn side(a: Place, b: Place, place: Place) -> i64 {
    let [ax, ay, bx, by, x, y] = [a.lon, a.lat, b.lon, b.lat, place.lon, place.lat].map(i128::from);
    ((bx - ax) * (y - ay) - (x - ax) * (by - ay)).signum() as i64
}

/// Whether a place on the line through two others is between them.
fn strictly_between(a: Place, b: Place, place: Place) -> bool {
    let [ax, ay, bx, by, x, y] = [a.lon, a.lat, b.lon, b.lat, place.lon, place.lat].map(i128::from);
    (x - ax) * (x - bx) + (y - ay) * (y - by) < 0
}

/// For each point how far it is from the first, and the one before it on the shortest way.
fn shortest(lines: &[Vec<(usize, f64)>], from: usize) -> (Vec<f64>, Vec<usize>) {
    let (mut length, mut before) = (
        vec![f64::INFINITY; lines.len()],
        vec![usize::MAX; lines.len()],
    );
    let mut open: Vec<usize> = (0..lines.len()).collect();
    length[from] = 0.0;
    while let Some(i) = (0..open.len()).min_by(|a, b| length[open[*a]].total_cmp(&length[open[*b]]))
    {
        let point = open.swap_remove(i);
        for (to, step) in &lines[point] {
            if length[point] + step < length[*to] {
                length[*to] = length[point] + step;
                before[*to] = point;
            }
        }
    }
    (length, before)
}
