//! What must stay free, and whether a thing would stand in the way: capsules (segments with a radius) in a coarse grid.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_osm::{OsmMap, Polygon};

use super::entrances::Doorway;
use super::streets;

/// Side of a grid cell, metres.
const CELL: f64 = 16.0;
/// Entries in the grid at most: what lies scattered over half the Earth must not fill the memory.
const MAX_ENTRIES: usize = 20_000_000;
/// Radius about the start in which nothing is put, metres.
const START_RADIUS: f64 = 2.5;
/// Depth and half width of the free space in front of a door and of a plate, metres.
const DOOR_DEPTH: f64 = 2.7;
const DOOR_HALF_WIDTH: f64 = 1.2;

/// What a capsule stands for; kinds add up to a mask.
pub(super) type Kinds = u16;
pub(super) const BUILDING: Kinds = 1;
pub(super) const BARRIER: Kinds = 2;
pub(super) const ROAD: Kinds = 4;
pub(super) const PATH: Kinds = 8;
pub(super) const DOOR: Kinds = 16;
pub(super) const OBJECT: Kinds = 32;
pub(super) const START: Kinds = 64;
pub(super) const PAVED: Kinds = 128;
pub(super) const DRIVEWAY: Kinds = 256;
pub(super) const WATER: Kinds = 512;
pub(super) const EVERYTHING: Kinds = Kinds::MAX;

#[derive(Debug, Clone, Copy)]
struct Capsule {
    a: MapPoint,
    b: MapPoint,
    radius: f64,
    kind: Kinds,
}

/// Everything that a new thing must keep away from.
#[derive(Debug, Default)]
pub(super) struct Clearance {
    capsules: Vec<Capsule>,
    areas: Vec<(Polygon, Kinds)>,
    capsule_cells: BTreeMap<(i32, i32), Vec<u32>>,
    area_cells: BTreeMap<(i32, i32), Vec<u32>>,
    entries: usize,
}

impl Clearance {
    /// What the map itself asks to keep free.
    pub fn of_map(map: &OsmMap) -> Self {
        let mut all = Self::default();
        for building in &map.buildings {
            all.add_area(building.polygon.clone(), BUILDING);
        }
        for barrier in &map.barriers {
            all.add_line(&barrier.points, 0.35, BARRIER);
        }
        for road in &map.roads {
            let Some(profile) = streets::profile(&road.tags) else {
                continue;
            };
            let kind = match road.tags.get("highway") {
                Some("service" | "track") => ROAD | DRIVEWAY,
                _ if profile.for_cars => ROAD,
                _ => PATH,
            };
            all.add_line(&road.points, profile.width / 2.0, kind);
            if profile.pavement > 0.0 {
                all.add_line(&road.points, profile.width / 2.0 + profile.pavement, PAVED);
            }
        }
        for area in &map.areas {
            if super::water::is_water(&area.tags) {
                all.add_area(area.polygon.clone(), PAVED | WATER);
            } else if area.tags.is("amenity", "parking") {
                all.add_area(area.polygon.clone(), PAVED);
            }
        }
        all
    }

    /// Keeps the ground in front of doors and plates free.
    pub fn add_doorways(&mut self, doorways: &[Doorway]) {
        for door in doorways {
            for p in [door.middle(), door.plate_point()] {
                let far = p.offset(door.facing, DOOR_DEPTH - DOOR_HALF_WIDTH);
                self.add(p, far, DOOR_HALF_WIDTH, DOOR);
            }
        }
    }

    /// Keeps the robot's start free.
    pub fn add_start(&mut self, start: MapPoint) {
        self.add(start, start, START_RADIUS, START);
    }

    /// Takes note of a thing that stands between `a` and `b`.
    pub fn add(&mut self, a: MapPoint, b: MapPoint, radius: f64, kind: Kinds) {
        let index = self.capsules.len() as u32;
        // Long segments would fill far more cells than they touch.
        let pieces = (a.distance(b) / CELL).ceil().clamp(1.0, 4096.0) as usize;
        for i in 0..pieces {
            let share = |k: usize| k as f64 / pieces as f64;
            let (p, q) = (
                super::shapes::along(a, b, share(i)),
                super::shapes::along(a, b, share(i + 1)),
            );
            if !self.afford(p, q, radius) {
                continue;
            }
            for cell in cells(p, q, radius) {
                let list = self.capsule_cells.entry(cell).or_default();
                if list.last() != Some(&index) {
                    list.push(index);
                }
            }
        }
        self.capsules.push(Capsule { a, b, radius, kind });
    }

    /// Whether the grid may take in what covers the rectangle around `a` and `b`.
    fn afford(&mut self, a: MapPoint, b: MapPoint, margin: f64) -> bool {
        let side = |d: f64| (d.abs() + 2.0 * margin) / CELL + 2.0;
        let count = side(b.x - a.x) * side(b.y - a.y);
        let good = count.is_finite() && count < (MAX_ENTRIES - self.entries) as f64;
        self.entries += if good { count as usize } else { 0 };
        good
    }

    fn add_line(&mut self, line: &[MapPoint], radius: f64, kind: Kinds) {
        for pair in line.windows(2) {
            self.add(pair[0], pair[1], radius, kind);
        }
    }

    /// Takes note of an area and of its outline.
    pub fn add_area(&mut self, polygon: Polygon, kind: Kinds) {
        for ring in std::iter::once(&polygon.outer).chain(&polygon.holes) {
            for i in 0..ring.len() {
                self.add(ring[i], ring[(i + 1) % ring.len()], 0.0, kind);
            }
        }
        let low =
            |f: fn(&MapPoint) -> f64| polygon.outer.iter().map(f).fold(f64::INFINITY, f64::min);
        let high = |f: fn(&MapPoint) -> f64| {
            polygon
                .outer
                .iter()
                .map(f)
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let (min, max) = (
            MapPoint::new(low(|p| p.x), low(|p| p.y)),
            MapPoint::new(high(|p| p.x), high(|p| p.y)),
        );
        let index = self.areas.len() as u32;
        if min.distance(max) < super::MAX_EXTENT && self.afford(min, max, 0.0) {
            for cell in cells(min, max, 0.0) {
                self.area_cells.entry(cell).or_default().push(index);
            }
        }
        self.areas.push((polygon, kind));
    }

    /// Whether a capsule touches nothing of `kinds`.
    pub fn is_free(&self, a: MapPoint, b: MapPoint, radius: f64, kinds: Kinds) -> bool {
        let touches = |i: &u32| {
            let c = &self.capsules[*i as usize];
            c.kind & kinds != 0 && segment_distance((a, b), (c.a, c.b)) < radius + c.radius
        };
        if cells(a, b, radius).any(|cell| {
            self.capsule_cells
                .get(&cell)
                .is_some_and(|list| list.iter().any(touches))
        }) {
            return false;
        }
        self.areas_at(a, kinds) == 0
    }

    /// How many areas of `kinds` a point lies in.
    pub fn areas_at(&self, point: MapPoint, kinds: Kinds) -> usize {
        let holds = |i: &&u32| {
            let (polygon, kind) = &self.areas[**i as usize];
            kind & kinds != 0 && polygon.contains(point)
        };
        self.area_cells
            .get(&cell_of(point))
            .map_or(0, |list| list.iter().filter(holds).count())
    }

    /// Distance of `point` from the nearest capsule of `kinds`, metres; `limit` if there is none so near.
    pub fn distance(&self, point: MapPoint, kinds: Kinds, limit: f64) -> f64 {
        let near = cells(point, point, limit)
            .filter_map(|cell| self.capsule_cells.get(&cell))
            .flatten();
        near.map(|i| &self.capsules[*i as usize])
            .filter(|c| c.kind & kinds != 0)
            .map(|c| point_distance(point, (c.a, c.b)) - c.radius)
            .fold(limit, f64::min)
            .max(0.0)
    }
}

fn cell_of(p: MapPoint) -> (i32, i32) {
    ((p.x / CELL).floor() as i32, (p.y / CELL).floor() as i32)
}

fn cells(a: MapPoint, b: MapPoint, margin: f64) -> impl Iterator<Item = (i32, i32)> {
    let low = cell_of(MapPoint::new(a.x.min(b.x) - margin, a.y.min(b.y) - margin));
    let high = cell_of(MapPoint::new(a.x.max(b.x) + margin, a.y.max(b.y) + margin));
    (low.0..=high.0).flat_map(move |x| (low.1..=high.1).map(move |y| (x, y)))
}

fn segment_distance((a, b): (MapPoint, MapPoint), (c, d): (MapPoint, MapPoint)) -> f64 {
    use crate::triangulate::turn;
    if turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0 {
        return 0.0;
    }
    let ends = [
        point_distance(a, (c, d)),
        point_distance(b, (c, d)),
        point_distance(c, (a, b)),
        point_distance(d, (a, b)),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

/// Distance of a point from a segment.
pub(super) fn point_distance(p: MapPoint, (a, b): (MapPoint, MapPoint)) -> f64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let squared = dx * dx + dy * dy;
    let share = if squared > 0.0 {
        (((p.x - a.x) * dx + (p.y - a.y) * dy) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(super::shapes::along(a, b, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsules_are_found_across_cells() {
        let mut clearance = Clearance::default();
        clearance.add(
            MapPoint::new(-100.0, 3.0),
            MapPoint::new(100.0, 3.0),
            1.0,
            ROAD,
        );
        let p = |x, y| MapPoint::new(x, y);
        assert!(!clearance.is_free(p(47.9, 4.9), p(47.9, 4.9), 1.0, ROAD));
        assert!(clearance.is_free(p(47.9, 5.1), p(47.9, 5.1), 1.0, ROAD));
        assert!(clearance.is_free(p(47.9, 3.0), p(47.9, 3.0), 1.0, DOOR));
        assert!(!clearance.is_free(p(0.0, -40.0), p(0.0, 40.0), 0.1, EVERYTHING));
    }

    #[test]
    fn the_inside_of_a_long_wall_is_not_free_but_its_far_side_is() {
        let distance = segment_distance(
            (MapPoint::new(0.0, 0.0), MapPoint::new(4.0, 0.0)),
            (MapPoint::new(6.0, -1.0), MapPoint::new(6.0, 5.0)),
        );
        assert!((distance - 2.0).abs() < 1e-12);
    }
}
