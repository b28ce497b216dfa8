//! The segments near a place: a packed R-tree over an edge's neighbouring segments.
//!
//! Runs are sorted along a Hilbert curve and packed eight to a box, boxes sixteen to a node, as in I. Kamel, C. Faloutsos, *On packing R-trees*, 1993.
//! Nothing but the boxes is stored; which belong together follows from their order.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::geo::{Place, Scale, TURN};
use crate::network::Network;
use crate::store::Column;

/// Segments in a run at most.
const RUN: usize = 8;
/// Runs in a box of the lowest row: a few segments are as soon looked at as their boxes.
const LEAF: usize = 8;
/// Boxes in a node.
const FAN: usize = 16;

/// West, south, east, north.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Bounds([i32; 4]);

/// Neighbouring segments of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Run {
    pub(crate) edge: u32,
    /// Its first segment among the edge's.
    pub(crate) first: u32,
}

/// A place on an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The edge.
    pub edge: u32,
    /// The segment of the edge, and the share of it before the place.
    pub segment: u32,
    /// From 0 to 1.
    pub share: f64,
    /// Where it is.
    pub place: Place,
    /// Metres from the place that was asked about.
    pub away: f64,
}

/// The tree.
#[derive(Debug, Clone, Default)]
pub struct SegmentTree {
    pub(crate) runs: Column<Run>,
    /// Boxes of neighbouring runs, of neighbouring boxes, …, one row after another.
    pub(crate) boxes: Column<Bounds>,
    /// Where each row begins, and where the last one ends.
    rows: Vec<usize>,
}

/// Memory of a look-up, used again for the next one.
#[derive(Debug, Default)]
pub struct Nearest {
    heap: BinaryHeap<Reverse<(Distance, Found)>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// What waits: a box by row and number, or an exact place on a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Found {
    Box(u32, u32),
    Foot(u32),
}

impl Bounds {
    fn around(points: impl Iterator<Item = Place>) -> Self {
        let mut bounds = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
        for point in points {
            bounds = [
                bounds[0].min(point.lon),
                bounds[1].min(point.lat),
                bounds[2].max(point.lon),
                bounds[3].max(point.lat),
            ];
        }
        Self(bounds)
    }

    fn union<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        let join = |a: Self, b: &Self| {
            let ([a, b, c, d], [e, f, g, h]) = (a.0, b.0);
            Self([a.min(e), b.min(f), c.max(g), d.max(h)])
        };
        all.fold(Self([i32::MAX, i32::MAX, i32::MIN, i32::MIN]), join)
    }

    fn middle(&self) -> Place {
        let middle = |a: i32, b: i32| ((i64::from(a) + i64::from(b)) / 2) as i32;
        let [west, south, east, north] = self.0;
        Place {
            lon: middle(west, east),
            lat: middle(south, north),
        }
    }

    /// Metres to a place, squared; 0 within.
    fn away(&self, place: Place, scale: Scale) -> f64 {
        let [west, south, east, north] = self.0.map(i64::from);
        let (lon, lat) = (i64::from(place.lon), i64::from(place.lat));
        // The box, and the same one a turn to the west and to the east.
        let away = |lon: i64| (west - lon).max(lon - east).max(0);
        let x = away(lon).min(away(lon + TURN)).min(away(lon - TURN)) as f64 * scale.lon;
        let y = (south - lat).max(lat - north).max(0) as f64 * scale.lat;
        x * x + y * y
    }
}

impl SegmentTree {
    /// An index of all segments of a network.
    pub fn new(network: &Network) -> Self {
        let mut runs: Vec<(u64, Run, Bounds)> = Vec::new();
        for edge in 0..network.edge_count() as u32 {
            let points = network.edge_points(edge);
            for first in (0..points.len() - 1).step_by(RUN) {
                let bounds = Bounds::around(points.part(first, first + RUN + 1));
                runs.push((
                    bounds.middle().hilbert(),
                    Run {
                        edge,
                        first: first as u32,
                    },
                    bounds,
                ));
            }
        }
        runs.sort_by_key(|(place, ..)| *place);
        let rows = rows(runs.len());
        let union =
            |runs: &[(u64, Run, Bounds)]| Bounds::union(runs.iter().map(|(_, _, bounds)| bounds));
        let mut boxes: Vec<Bounds> = runs.chunks(LEAF).map(union).collect();
        for row in rows.windows(2).take(rows.len() - 2) {
            for node in (row[0]..row[1]).step_by(FAN) {
                boxes.push(Bounds::union(boxes[node..row[1].min(node + FAN)].iter()));
            }
        }
        Self {
            runs: runs.into_iter().map(|(_, run, _)| run).collect(),
            boxes: boxes.into(),
            rows,
        }
    }

    /// A tree from its parts, `None` if they do not fit together.
    pub(crate) fn from_parts(runs: Column<Run>, boxes: Column<Bounds>) -> Option<Self> {
        let rows = rows(runs.len());
        (rows.last() == Some(&boxes.len())).then_some(Self { runs, boxes, rows })
    }

    /// Shows the nearest place on each run of segments, nearest first, until `show` says that it is enough or nothing is left within
    /// `limit` metres. Edges that are not `usable` are passed over.
    pub fn nearest(
        &self,
        network: &Network,
        place: Place,
        limit: f64,
        memory: &mut Nearest,
        usable: impl Fn(u32) -> bool,
        mut show: impl FnMut(Foot) -> bool,
    ) {
        let scale = Scale::at(f64::from(place.lat));
        let heap = &mut memory.heap;
        heap.clear();
        let top = self.rows.len().saturating_sub(2);
        if !self.boxes.is_empty() {
            let away = self.boxes[self.rows[top]].away(place, scale);
            heap.push(Reverse((Distance(away), Found::Box(top as u32, 0))));
        }
        while let Some(Reverse((Distance(away), found))) = heap.pop() {
            if away > limit * limit {
                return;
            }
            match found {
                Found::Foot(run) => {
                    if !show(self.foot(network, run, place, scale)) {
                        return;
                    }
                }
                Found::Box(0, node) => {
                    let first = node as usize * LEAF;
                    for run in first..self.runs.len().min(first + LEAF) {
                        if usable(self.runs[run].edge) {
                            let away = self.foot(network, run as u32, place, scale).away;
                            heap.push(Reverse((Distance(away * away), Found::Foot(run as u32))));
                        }
                    }
                }
                Found::Box(row, node) => {
                    let (row, first) = (row as usize - 1, node as usize * FAN);
                    let [begin, end] = [self.rows[row], self.rows[row + 1]];
                    let children = begin + first..end.min(begin + first + FAN);
                    for (child, bounds) in (first as u32..).zip(&self.boxes[children]) {
                        let away = Distance(bounds.away(place, scale));
                        heap.push(Reverse((away, Found::Box(row as u32, child))));
                    }
                }
            }
        }
    }

    /// The nearest place on a run.
    fn foot(&self, network: &Network, run: u32, place: Place, scale: Scale) -> Foot {
        let Run { edge, first } = self.runs[run as usize];
        let points = network.edge_points(edge);
        let last = (points.len() - 1).min(first as usize + RUN);
        let mut best = (f64::INFINITY, first, 0.0);
        for segment in first as usize..last {
            let (away, share) = project(points.at(segment), points.at(segment + 1), place, scale);
            if away < best.0 {
                best = (away, segment as u32, share);
            }
        }
        let (away, segment, share) = best;
        let [a, b] = [points.at(segment as usize), points.at(segment as usize + 1)];
        Foot {
            edge,
            segment,
            share,
            place: between(a, b, share),
            away: away.sqrt(),
        }
    }
}

/// Where each row of boxes begins over so many runs, and where the last one ends.
fn rows(runs: usize) -> Vec<usize> {
    let mut width = runs.div_ceil(LEAF);
    let mut rows = vec![0, width];
    while width > 1 {
        width = width.div_ceil(FAN);
        rows.push(rows[rows.len() - 1] + width);
    }
    rows
}

/// How far a segment is from a place, metres squared, and the share of the segment before its nearest point.
fn project(a: Place, b: Place, place: Place, scale: Scale) -> (f64, f64) {
    let ([dx, dy], [px, py]) = (scale.offset(a, b), scale.offset(a, place));
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 {
        ((px * dx + py * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (x, y) = (px - share * dx, py - share * dy);
    (x * x + y * y, share)
}

/// The place at a share of a segment, which goes the short way round the Earth.
pub fn between(a: Place, b: Place, share: f64) -> Place {
    let step = |step: i64| libm::round(step as f64 * share) as i64;
    let mut east = i64::from(b.lon) - i64::from(a.lon);
    if east.abs() > TURN / 2 {
        east -= east.signum() * TURN;
    }
    let lon = (i64::from(a.lon) + step(east) + TURN / 2).rem_euclid(TURN) - TURN / 2;
    let lat = i64::from(a.lat) + step(i64::from(b.lat) - i64::from(a.lat));
    Place {
        lon: lon as i32,
        lat: lat as i32,
    }
}
