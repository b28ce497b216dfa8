//! What must stay free, and whether a thing would stand in the way: capsules (segments with a
//! radius) and areas in a coarse grid.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_geometry::{Polygon, Segment, segments};

use crate::generate::error::MAX_EXTENT_M;

/// Side of a grid cell, metres: about a house. Smaller cells would hold every long wall many times.
const CELL_M: f64 = 16.0;
/// Entries in the grid at most: a map that is scattered over half the Earth must not fill the
/// memory.
const MAX_ENTRIES: usize = 20_000_000;
/// Pieces at most in which a segment is entered into the grid.
const MAX_PIECES: f64 = 4096.0;

/// Kinds of things, a bit each; unions of kinds are masks.
pub(crate) type Kinds = u16;
pub(crate) const BUILDING: Kinds = 1;
pub(crate) const BARRIER: Kinds = 2;
pub(crate) const ROAD: Kinds = 4;
pub(crate) const PATH: Kinds = 8;
pub(crate) const DOOR: Kinds = 16;
pub(crate) const OBJECT: Kinds = 32;
pub(crate) const START: Kinds = 64;
pub(crate) const PAVED: Kinds = 128;
pub(crate) const DRIVEWAY: Kinds = 256;
pub(crate) const WATER: Kinds = 512;
pub(crate) const EVERYTHING: Kinds = Kinds::MAX;

#[derive(Debug, Clone, Copy)]
struct Capsule {
    axis: Segment,
    radius: f64,
    kind: Kinds,
}

#[derive(Debug)]
struct Area {
    polygon: Polygon,
    kinds: Kinds,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    x: i32,
    y: i32,
}

/// Everything that a new thing must keep away from.
#[derive(Debug, Default)]
pub(crate) struct Clearance {
    capsules: Vec<Capsule>,
    areas: Vec<Area>,
    capsule_cells: BTreeMap<Cell, Vec<u32>>,
    area_cells: BTreeMap<Cell, Vec<u32>>,
    entries: usize,
}

impl Clearance {
    /// An empty one that has as much room left for entries as this one.
    pub fn with_remaining_room(&self) -> Self {
        Self {
            entries: self.entries,
            ..Self::default()
        }
    }

    /// Adds a thing that lies within `radius` metres of a segment.
    pub fn add(&mut self, axis: Segment, radius: f64, kind: Kinds) {
        let index = self.capsules.len() as u32;
        // The rectangle around a long segment has far more cells than the segment touches.
        let pieces = (axis.length() / CELL_M).ceil().clamp(1.0, MAX_PIECES) as usize;
        let share = |k: usize| k as f64 / pieces as f64;
        for i in 0..pieces {
            let piece = axis.part(share(i), share(i + 1));
            if !self.reserve(piece.start, piece.end, radius) {
                continue;
            }
            for cell in cells(piece.start, piece.end, radius) {
                let list = self.capsule_cells.entry(cell).or_default();
                // Neighbouring pieces share cells; the last entry of a cell tells.
                if list.last() != Some(&index) {
                    list.push(index);
                }
            }
        }
        self.capsules.push(Capsule { axis, radius, kind });
    }

    /// Adds a round thing.
    pub fn add_disc(&mut self, center: MapPoint, radius: f64, kind: Kinds) {
        self.add(Segment::new(center, center), radius, kind);
    }

    /// Adds what lies within `radius` metres of a line.
    pub fn add_line(&mut self, line: &[MapPoint], radius: f64, kind: Kinds) {
        for segment in segments(line) {
            self.add(segment, radius, kind);
        }
    }

    /// Adds an area and its outline.
    pub fn add_area(&mut self, polygon: Polygon, kinds: Kinds) {
        for side in polygon.sides() {
            self.add(side, 0.0, kinds);
        }
        let index = self.areas.len() as u32;
        let bounds = polygon.bounds();
        let (min, max) = (bounds.low, bounds.high);
        // An area without cells is never found, but its outline was entered above.
        if min.distance(max) < MAX_EXTENT_M && self.reserve(min, max, 0.0) {
            for cell in cells(min, max, 0.0) {
                self.area_cells.entry(cell).or_default().push(index);
            }
        }
        self.areas.push(Area { polygon, kinds });
    }

    /// Reserves entries for what covers the rectangle around `a` and `b`; false if there is no room
    /// for them.
    fn reserve(&mut self, a: MapPoint, b: MapPoint, margin: f64) -> bool {
        let side = |d: f64| (d.abs() + 2.0 * margin) / CELL_M + 2.0;
        let count = side(b.x - a.x) * side(b.y - a.y);
        let fits = count.is_finite() && count < (MAX_ENTRIES - self.entries) as f64;
        self.entries += if fits { count as usize } else { 0 };
        fits
    }

    /// Whether a capsule touches nothing of `kinds`, nor begins in an area of them.
    pub fn is_free(&self, axis: Segment, radius: f64, kinds: Kinds) -> bool {
        let touches = |i: &u32| {
            let c = &self.capsules[*i as usize];
            c.kind & kinds != 0 && axis.distance_to(c.axis) < radius + c.radius
        };
        let is_touched = cells(axis.start, axis.end, radius)
            .filter_map(|cell| self.capsule_cells.get(&cell))
            .any(|list| list.iter().any(touches));
        // What crosses no outline lies inside of an area as a whole, or outside: its beginning
        // tells.
        !is_touched && self.areas_at(axis.start, kinds) == 0
    }

    /// Whether a disc touches nothing of `kinds`.
    pub fn is_free_at(&self, center: MapPoint, radius: f64, kinds: Kinds) -> bool {
        self.is_free(Segment::new(center, center), radius, kinds)
    }

    /// How many areas of `kinds` a point lies in.
    pub fn areas_at(&self, point: MapPoint, kinds: Kinds) -> usize {
        let holds = |i: &&u32| {
            let area = &self.areas[**i as usize];
            area.kinds & kinds != 0 && area.polygon.contains(point)
        };
        let list = self.area_cells.get(&Cell::of(point));
        list.map_or(0, |list| list.iter().filter(holds).count())
    }

    /// Distance of `point` from the nearest capsule of `kinds`, metres; `limit` if none is as near.
    pub fn distance(&self, point: MapPoint, kinds: Kinds, limit: f64) -> f64 {
        cells(point, point, limit)
            .filter_map(|cell| self.capsule_cells.get(&cell))
            .flatten()
            .map(|i| &self.capsules[*i as usize])
            .filter(|c| c.kind & kinds != 0)
            .map(|c| c.axis.distance_to_point(point) - c.radius)
            .fold(limit, f64::min)
            .max(0.0)
    }
}

impl Cell {
    fn of(p: MapPoint) -> Self {
        Self {
            x: (p.x / CELL_M).floor() as i32,
            y: (p.y / CELL_M).floor() as i32,
        }
    }
}

/// The cells of the rectangle around `a` and `b`, grown by `margin` metres.
fn cells(a: MapPoint, b: MapPoint, margin: f64) -> impl Iterator<Item = Cell> {
    let low = Cell::of(MapPoint::new(a.x.min(b.x) - margin, a.y.min(b.y) - margin));
    let high = Cell::of(MapPoint::new(a.x.max(b.x) + margin, a.y.max(b.y) + margin));
    (low.x..=high.x).flat_map(move |x| (low.y..=high.y).map(move |y| Cell { x, y }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsules_are_found_across_cells() {
        let mut clearance = Clearance::default();
        let p = MapPoint::new;
        clearance.add(Segment::new(p(-100.0, 3.0), p(100.0, 3.0)), 1.0, ROAD);
        assert!(!clearance.is_free_at(p(47.9, 4.9), 1.0, ROAD));
        assert!(clearance.is_free_at(p(47.9, 5.1), 1.0, ROAD));
        assert!(clearance.is_free_at(p(47.9, 3.0), 1.0, DOOR));
        let across = Segment::new(p(0.0, -40.0), p(0.0, 40.0));
        assert!(!clearance.is_free(across, 0.1, EVERYTHING));
    }
}
