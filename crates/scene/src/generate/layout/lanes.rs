//! An index of the segments of roads by place, so that a search for the roads nearby need not test
//! all of them.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_geometry::{Segment, segments};
use openbench_osm::Road;

/// Side of a cell, metres: a few segments of a street fit in one.
const CELL_M: f64 = 32.0;
/// A longer segment is that of no street and is not indexed, metres.
const LONGEST_M: f64 = 5_000.0;

/// A segment of a road: numbers of the road and of the segment in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Lane {
    pub road: u32,
    pub segment: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    x: i32,
    y: i32,
}

/// Segments by cell.
#[derive(Debug, Default)]
pub(crate) struct Lanes {
    cells: BTreeMap<Cell, Vec<Lane>>,
}

/// A lane, and its distance from a point in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    pub lane: Lane,
    pub distance: f64,
}

impl Lane {
    /// Its two ends.
    pub fn ends(self, roads: &[Road]) -> Segment {
        let points = &roads[self.road as usize].points;
        Segment::new(
            points[self.segment as usize],
            points[self.segment as usize + 1],
        )
    }
}

impl Lanes {
    /// The segments of the roads that are `wanted`.
    pub fn new(roads: &[Road], wanted: impl Fn(&Road) -> bool) -> Self {
        let mut lanes = Self::default();
        for (r, road) in roads.iter().enumerate().filter(|(_, road)| wanted(road)) {
            for (s, ends) in segments(&road.points).enumerate() {
                lanes.add(
                    Lane {
                        road: r as u32,
                        segment: s as u32,
                    },
                    ends,
                );
            }
        }
        lanes
    }

    fn add(&mut self, lane: Lane, ends: Segment) {
        let length = ends.length();
        if length.is_nan() || length > LONGEST_M {
            return;
        }
        // The rectangle around a long segment has far more cells than the segment touches.
        let pieces = (length / CELL_M).ceil().max(1.0) as usize;
        let share = |k: usize| k as f64 / pieces as f64;
        for i in 0..pieces {
            for cell in cells(ends.at(share(i)), ends.at(share(i + 1)), 0.0) {
                let list = self.cells.entry(cell).or_default();
                // Neighbouring pieces share cells.
                if list.last() != Some(&lane) {
                    list.push(lane);
                }
            }
        }
    }

    /// The lanes that may come within `margin` metres of the rectangle around `a` and `b`; each
    /// once, in the roads' order.
    pub fn near(&self, a: MapPoint, b: MapPoint, margin: f64) -> Vec<Lane> {
        let lists = cells(a, b, margin).filter_map(|cell| self.cells.get(&cell));
        let mut found: Vec<Lane> = lists.flatten().copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The lane nearest to `point` within `limit` metres; of several the first.
    pub fn nearest(&self, roads: &[Road], point: MapPoint, limit: f64) -> Option<Nearest> {
        // Most searches end near by; the others double their reach.
        let mut reach = CELL_M.min(limit);
        loop {
            let best = self
                .near(point, point, reach)
                .into_iter()
                .map(|lane| {
                    let distance = lane.ends(roads).distance_to_point(point);
                    Nearest { lane, distance }
                })
                // A lane beyond the reach may have a nearer one in cells that were not searched
                // yet.
                .filter(|nearest| nearest.distance <= reach)
                .reduce(|a, b| if b.distance < a.distance { b } else { a });
            if best.is_some() || reach >= limit {
                return best;
            }
            reach = (2.0 * reach).min(limit);
        }
    }
}

fn cells(a: MapPoint, b: MapPoint, margin: f64) -> impl Iterator<Item = Cell> {
    let cell = |v: f64| (v / CELL_M).floor() as i32;
    let columns = cell(a.x.min(b.x) - margin)..=cell(a.x.max(b.x) + margin);
    let (low, high) = (cell(a.y.min(b.y) - margin), cell(a.y.max(b.y) + margin));
    columns.flat_map(move |x| (low..=high).map(move |y| Cell { x, y }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_osm::Tags;

    #[test]
    fn the_nearest_lane_is_found_across_cells() {
        let road = |y: f64| Road {
            way: 1,
            nodes: vec![1, 2],
            points: vec![MapPoint::new(-500.0, y), MapPoint::new(500.0, y)],
            tags: Tags::new(),
        };
        let roads = [road(0.0), road(90.0)];
        let lanes = Lanes::new(&roads, |_| true);
        let nearest = |x, y, limit| lanes.nearest(&roads, MapPoint::new(x, y), limit);
        let of_road = |road| Lane { road, segment: 0 };
        let second = Nearest {
            lane: of_road(1),
            distance: 40.0,
        };
        assert_eq!(nearest(433.0, 50.0, 100.0), Some(second));
        let first = Nearest {
            lane: of_road(0),
            distance: 44.0,
        };
        assert_eq!(nearest(-433.0, 44.0, 100.0), Some(first));
        assert_eq!(nearest(0.0, -70.0, 60.0), None);
    }
}
