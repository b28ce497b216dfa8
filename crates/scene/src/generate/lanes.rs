//! The roads' segments by place, so that what asks for the roads nearby need not look at all of them.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_osm::Road;

use super::clearance::point_distance;
use super::shapes::along;

/// Side of a cell, metres.
const CELL: f64 = 32.0;
/// A segment longer than this is that of no street and is not looked up, metres.
const LONGEST: f64 = 5_000.0;

/// A segment: number of the road and of the segment in it.
pub(super) type Segment = (u32, u32);

/// Segments by cell.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    cells: BTreeMap<(i32, i32), Vec<Segment>>,
}

impl Lanes {
    /// The segments of the roads that `wanted` holds for.
    pub fn new(roads: &[Road], wanted: impl Fn(&Road) -> bool) -> Self {
        let mut lanes = Self::default();
        for (r, road) in roads.iter().enumerate().filter(|(_, road)| wanted(road)) {
            for (s, pair) in road.points.windows(2).enumerate() {
                lanes.add((r as u32, s as u32), (pair[0], pair[1]));
            }
        }
        lanes
    }

    fn add(&mut self, segment: Segment, (a, b): (MapPoint, MapPoint)) {
        let length = a.distance(b);
        if length.is_nan() || length > LONGEST {
            return;
        }
        let pieces = (length / CELL).ceil().max(1.0) as usize;
        for i in 0..pieces {
            let share = |k: usize| along(a, b, k as f64 / pieces as f64);
            for cell in cells(share(i), share(i + 1), 0.0) {
                let list = self.cells.entry(cell).or_default();
                if list.last() != Some(&segment) {
                    list.push(segment);
                }
            }
        }
    }

    /// The segments that may come within `margin` metres of the rectangle around `a` and `b`; each once, in the roads' order.
    pub fn near(&self, a: MapPoint, b: MapPoint, margin: f64) -> Vec<Segment> {
        let mut found: Vec<Segment> = cells(a, b, margin)
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .copied()
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The segment nearest to `point` and how far it is, if there is one within `limit` metres; of several the first.
    pub fn nearest(&self, roads: &[Road], point: MapPoint, limit: f64) -> Option<(Segment, f64)> {
        let mut reach = CELL.min(limit);
        loop {
            let away = |s: &Segment| point_distance(point, ends(roads, *s));
            let all = self
                .near(point, point, reach)
                .into_iter()
                .map(|s| (s, away(&s)));
            let best = all
                .filter(|(_, d)| *d <= reach)
                .reduce(|a, b| if b.1 < a.1 { b } else { a });
            if best.is_some() || reach >= limit {
                return best;
            }
            reach = (2.0 * reach).min(limit);
        }
    }
}

/// Both ends of a segment.
pub(super) fn ends(roads: &[Road], (road, segment): Segment) -> (MapPoint, MapPoint) {
    let points = &roads[road as usize].points;
    (points[segment as usize], points[segment as usize + 1])
}

fn cells(a: MapPoint, b: MapPoint, margin: f64) -> impl Iterator<Item = (i32, i32)> {
    let cell = |v: f64| (v / CELL).floor() as i32;
    let columns = cell(a.x.min(b.x) - margin)..=cell(a.x.max(b.x) + margin);
    let (low, high) = (cell(a.y.min(b.y) - margin), cell(a.y.max(b.y) + margin));
    columns.flat_map(move |x| (low..=high).map(move |y| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_osm::Tags;

    #[test]
    fn the_nearest_segment_is_found_across_cells() {
        let road = |y: f64| Road {
            way: 1,
            nodes: vec![1, 2],
            points: vec![MapPoint::new(-500.0, y), MapPoint::new(500.0, y)],
            tags: Tags::new(),
        };
        let roads = [road(0.0), road(90.0)];
        let lanes = Lanes::new(&roads, |_| true);
        let nearest = |x, y, limit| lanes.nearest(&roads, MapPoint::new(x, y), limit);
        assert_eq!(nearest(433.0, 50.0, 100.0), Some(((1, 0), 40.0)));
        assert_eq!(nearest(-433.0, 44.0, 100.0), Some(((0, 0), 44.0)));
        assert_eq!(nearest(0.0, -70.0, 60.0), None);
    }
}
