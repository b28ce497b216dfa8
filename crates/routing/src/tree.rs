//! An index of segments by place: a packed R-tree over runs of an edge's neighbouring segments.
//!
//! Runs are sorted along a Hilbert curve and packed eight to a box, boxes sixteen to a node, as in
//! I. Kamel, C. Faloutsos, *On packing R-trees*, 1993. Only boxes are stored; the tree follows from
//! their order.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::geo::{Place, Scale, TURN};
use crate::network::Network;
use crate::store::Column;

/// The most segments in a run.
const RUN: usize = 8;
/// The most runs in a box of the lowest row: examining a few segments is as fast as examining
/// their boxes.
const LEAF: usize = 8;
/// Boxes in a node.
const FAN: usize = 16;

/// An axis-aligned box: west, south, east, north, in units of a [`Place`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Bounds([i32; 4]);

/// Neighbouring segments of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Run {
    pub(crate) edge: u32,
    /// Its first segment among the edge's.
    pub(crate) first: u32,
}

/// The place on an edge nearest to another place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foot {
    /// The edge.
    pub edge: u32,
    /// The segment of the edge.
    pub segment: u32,
    /// The share of the segment before the place, from 0 to 1.
    pub share: f64,
    /// The place itself.
    pub place: Place,
    /// Metres from the place that was asked about.
    pub away: f64,
}

/// The tree.
#[derive(Debug, Clone, Default)]
pub(crate) struct SegmentTree {
    pub(crate) runs: Column<Run>,
    /// Boxes of neighbouring runs, of neighbouring boxes, …, one row after another.
    pub(crate) boxes: Column<Bounds>,
    /// Where each row begins, and where the last one ends.
    rows: Vec<usize>,
}

/// Memory of a look-up, which is used again for the next one.
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

/// An entry of the queue: a box by row and number, or the exact foot on a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Found {
    Box(u32, u32),
    Foot(u32),
}

impl Bounds {
    const EMPTY: Self = Self([i32::MAX, i32::MAX, i32::MIN, i32::MIN]);

    fn around(points: impl Iterator<Item = Place>) -> Self {
        points.map(Self::of_point).fold(Self::EMPTY, Self::union)
    }

    fn of_point(point: Place) -> Self {
        Self([point.lon, point.lat, point.lon, point.lat])
    }

    fn union(self, other: Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a.min(e), b.min(f), c.max(g), d.max(h)])
    }

    fn union_of(all: &[Self]) -> Self {
        all.iter().copied().fold(Self::EMPTY, Self::union)
    }

    fn middle(&self) -> Place {
        // The sum of two longitudes may exceed `i32`.
        let middle = |a: i32, b: i32| ((i64::from(a) + i64::from(b)) / 2) as i32;
        let [west, south, east, north] = self.0;
        Place {
            lon: middle(west, east),
            lat: middle(south, north),
        }
    }

    /// Squared metres to a place; 0 within.
    fn squared_distance(&self, place: Place, scale: Scale) -> f64 {
        let [west, south, east, north] = self.0.map(i64::from);
        let (lon, lat) = (i64::from(place.lon), i64::from(place.lat));
        // The box, and its copies a turn to the west and to the east.
        let away = |lon: i64| (west - lon).max(lon - east).max(0);
        let x = away(lon).min(away(lon + TURN)).min(away(lon - TURN)) as f64 * scale.lon;
        let y = (south - lat).max(lat - north).max(0) as f64 * scale.lat;
        x * x + y * y
    }
}

impl SegmentTree {
    /// An index of all segments of a network.
    pub(crate) fn new(network: &Network) -> Self {
        let (runs, bounds) = sorted_runs(network);
        let rows = rows(runs.len());
        let mut boxes: Vec<Bounds> = bounds.chunks(LEAF).map(Bounds::union_of).collect();
        // Each row but the highest has a row above it. A node does not reach into the next row.
        for row in rows.windows(2).take(rows.len() - 2) {
            for node in (row[0]..row[1]).step_by(FAN) {
                boxes.push(Bounds::union_of(&boxes[node..row[1].min(node + FAN)]));
            }
        }
        Self {
            runs: runs.into(),
            boxes: boxes.into(),
            rows,
        }
    }

    /// A tree from its parts, `None` if they do not fit together.
    pub(crate) fn from_parts(runs: Column<Run>, boxes: Column<Bounds>) -> Option<Self> {
        let rows = rows(runs.len());
        (rows.last() == Some(&boxes.len())).then_some(Self { runs, boxes, rows })
    }

    /// Shows the foot on each run of segments, nearest first, until `show` returns `false` or
    /// nothing is left within `limit` metres. Edges that are not usable are skipped.
    pub(crate) fn nearest(
        &self,
        network: &Network,
        place: Place,
        limit: f64,
        memory: &mut Nearest,
        is_usable: impl Fn(u32) -> bool,
        mut show: impl FnMut(Foot) -> bool,
    ) {
        let scale = Scale::at(f64::from(place.lat));
        let heap = &mut memory.heap;
        heap.clear();
        let top = self.rows.len().saturating_sub(2);
        if !self.boxes.is_empty() {
            let away = self.boxes[self.rows[top]].squared_distance(place, scale);
            heap.push(Reverse((Distance(away), Found::Box(top as u32, 0))));
        }
        // Best first: a box is as near as anything in it can be. A foot that leaves the queue is
        // therefore nearer than all that is left.
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
                        if is_usable(self.runs[run].edge) {
                            // The queue keeps numbers only. The few feet that are shown are
                            // computed again.
                            let away = self.foot(network, run as u32, place, scale).away;
                            let entry = (Distance(away * away), Found::Foot(run as u32));
                            heap.push(Reverse(entry));
                        }
                    }
                }
                Found::Box(row, node) => {
                    let (row, first) = (row as usize - 1, node as usize * FAN);
                    let [begin, end] = [self.rows[row], self.rows[row + 1]];
                    let children = begin + first..end.min(begin + first + FAN);
                    for (child, bounds) in (first as u32..).zip(&self.boxes[children]) {
                        let away = Distance(bounds.squared_distance(place, scale));
                        heap.push(Reverse((away, Found::Box(row as u32, child))));
                    }
                }
            }
        }
    }

    /// The foot on a run.
    fn foot(&self, network: &Network, run: u32, place: Place, scale: Scale) -> Foot {
        let Run { edge, first } = self.runs[run as usize];
        let points = network.edge_points(edge);
        // Segments, one fewer than points.
        let last = (points.len() - 1).min(first as usize + RUN);
        let mut nearest = Projected {
            squared_distance: f64::INFINITY,
            share: 0.0,
        };
        let mut segment = first;
        for i in first as usize..last {
            let projected = project([points.at(i), points.at(i + 1)], place, scale);
            if projected.squared_distance < nearest.squared_distance {
                (nearest, segment) = (projected, i as u32);
            }
        }
        let [a, b] = [points.at(segment as usize), points.at(segment as usize + 1)];
        let Projected {
            squared_distance,
            share,
        } = nearest;
        let place = between(a, b, share);
        Foot {
            edge,
            segment,
            share,
            place,
            away: squared_distance.sqrt(),
        }
    }
}

/// All runs of a network in the order of a Hilbert curve, and their boxes.
fn sorted_runs(network: &Network) -> (Vec<Run>, Vec<Bounds>) {
    let mut runs: Vec<(Run, Bounds)> = Vec::new();
    for edge in 0..network.edge_count() as u32 {
        let points = network.edge_points(edge);
        for first in (0..points.len() - 1).step_by(RUN) {
            // A run of `RUN` segments has one point more.
            let bounds = Bounds::around(points.part(first, first + RUN + 1));
            runs.push((
                Run {
                    edge,
                    first: first as u32,
                },
                bounds,
            ));
        }
    }
    runs.sort_by_cached_key(|(_, bounds)| bounds.middle().hilbert());
    runs.into_iter().unzip()
}

/// Where each row of boxes over so many runs begins, and where the last one ends.
fn rows(runs: usize) -> Vec<usize> {
    let mut width = runs.div_ceil(LEAF);
    let mut rows = vec![0, width];
    while width > 1 {
        width = width.div_ceil(FAN);
        rows.push(rows[rows.len() - 1] + width);
    }
    rows
}

/// A place projected onto a segment.
#[derive(Debug, Clone, Copy)]
struct Projected {
    /// Square metres.
    squared_distance: f64,
    /// The share of the segment before its nearest point.
    share: f64,
}

fn project([a, b]: [Place; 2], place: Place, scale: Scale) -> Projected {
    let ([dx, dy], [px, py]) = (scale.offset(a, b), scale.offset(a, place));
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 {
        ((px * dx + py * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (x, y) = (px - share * dx, py - share * dy);
    Projected {
        squared_distance: x * x + y * y,
        share,
    }
}

/// The place at a share of a segment, which goes the short way around the Earth.
fn between(a: Place, b: Place, share: f64) -> Place {
    let step = |step: i64| libm::round(step as f64 * share) as i64;
    let mut east = i64::from(b.lon) - i64::from(a.lon);
    if east.abs() > TURN / 2 {
        east -= east.signum() * TURN;
    }
    // Back into half a turn to each side, if the segment crosses the 180th meridian.
    let lon = (i64::from(a.lon) + step(east) + TURN / 2).rem_euclid(TURN) - TURN / 2;
    let lat = i64::from(a.lat) + step(i64::from(b.lat) - i64::from(a.lat));
    Place {
        lon: lon as i32,
        lat: lat as i32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_segment_across_the_date_line_is_on_it() {
        let [a, b] = [TURN / 2 - 100, 100 - TURN / 2].map(|lon| Place {
            lon: lon as i32,
            lat: 0,
        });
        let middle = between(a, b, 0.5);
        assert_eq!(i64::from(middle.lon).abs(), TURN / 2);
        assert_eq!(between(a, b, 0.0), a);
        assert_eq!(between(a, b, 1.0), b);
    }

    #[test]
    fn rows_shrink_by_their_fan() {
        assert_eq!(rows(0), [0, 0]);
        assert_eq!(rows(8), [0, 1]);
        assert_eq!(rows(8 * 17), [0, 17, 19, 20]);
    }
}
