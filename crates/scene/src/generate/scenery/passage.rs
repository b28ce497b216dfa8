//! Whether a thing leaves all ways around it open.
//!
//! In a window around the thing, places that are connected before it is there must be connected
//! with it, for those that it does not cover. Ways through the window then stay open, and so do
//! all ways of the world: each can be led around the thing within the window.

use openbench_core::MapPoint;
use openbench_geometry::Segment;

use crate::generate::layout::clearance::{BARRIER, BUILDING, Kinds, OBJECT, WATER};
use crate::generate::layout::occupied::Occupied;

/// Side of a cell, metres.
const CELL_M: f64 = 0.2;
/// Ground around the thing that belongs to the window, metres.
const AROUND_M: f64 = 2.4;
/// Radii for which ways stay open: that of the robot, of 22 cm, with some room, and one that is
/// comfortable, metres.
const RADII_M: [f64; 2] = [0.3, 0.45];
/// What stops a robot.
const WALLS: Kinds = BUILDING | BARRIER | OBJECT | WATER;

/// Whether all ways stay open if a thing stands within `radius` metres of a segment.
pub(super) fn stays_open(occupied: &Occupied, axis: Segment, radius: f64) -> bool {
    RADII_M
        .iter()
        .all(|room| Window::around(occupied, axis, radius, *room).is_connected_as_before())
}

/// The ground around a thing in cells, row by row.
struct Window {
    side: usize,
    /// Whether a robot fits without the thing.
    before: Vec<bool>,
    /// Whether it fits with it.
    after: Vec<bool>,
}

impl Window {
    fn around(occupied: &Occupied, axis: Segment, radius: f64, room: f64) -> Self {
        let half = axis.length() / 2.0 + radius + room + AROUND_M;
        let side = (2.0 * half / CELL_M).ceil() as usize;
        let middle = axis.middle();
        let cell = |i: usize| {
            let away = |n: usize| (n as f64 + 0.5) * CELL_M - half;
            MapPoint::new(middle.x + away(i % side), middle.y + away(i / side))
        };
        let places: Vec<MapPoint> = (0..side * side).map(cell).collect();
        let before: Vec<bool> = places
            .iter()
            .map(|p| occupied.is_free_at(*p, room, WALLS))
            .collect();
        let beside = |p: &MapPoint| axis.distance_to_point(*p) >= radius + room;
        let after = places
            .iter()
            .zip(&before)
            .map(|(p, free)| *free && beside(p))
            .collect();
        Self {
            side,
            before,
            after,
        }
    }

    /// Whether all free cells that were in one part still are.
    fn is_connected_as_before(&self) -> bool {
        let (old, new) = (
            parts(&self.before, self.side),
            parts(&self.after, self.side),
        );
        // For each old part the new one in which its cells lie; 0 while none is known.
        let mut new_of = vec![0; old.len() + 1];
        old.iter()
            .zip(&new)
            .filter(|(_, new)| **new > 0)
            .all(|(old, new)| {
                let known = &mut new_of[*old as usize];
                let agrees = *known == 0 || *known == *new;
                *known = *new;
                agrees
            })
    }
}

/// For each cell the number of its connected part, from 1; 0 where it is not free.
fn parts(free: &[bool], side: usize) -> Vec<u32> {
    let mut part = vec![0; free.len()];
    let (mut next, mut stack) = (0, Vec::new());
    for start in 0..free.len() {
        if part[start] > 0 || !free[start] {
            continue;
        }
        next += 1;
        part[start] = next;
        stack.push(start);
        while let Some(cell) = stack.pop() {
            let (x, y) = (cell % side, cell / side);
            let neighbours = [
                (x > 0).then(|| cell - 1),
                (x + 1 < side).then(|| cell + 1),
                (y > 0).then(|| cell - side),
                (y + 1 < side).then(|| cell + side),
            ];
            for n in neighbours.into_iter().flatten() {
                if free[n] && part[n] == 0 {
                    part[n] = next;
                    stack.push(n);
                }
            }
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::layout::clearance::Clearance;

    /// A passage between two walls, so many metres wide, along x.
    fn passage(width: f64) -> Clearance {
        let mut map = Clearance::default();
        for side in [-1.0, 1.0] {
            let y = side * width / 2.0;
            let wall = Segment::new(MapPoint::new(-20.0, y), MapPoint::new(20.0, y));
            map.add(wall, 0.0, BARRIER);
        }
        map
    }

    fn disc(y: f64) -> Segment {
        Segment::new(MapPoint::new(0.0, y), MapPoint::new(0.0, y))
    }

    #[test]
    fn a_thing_may_stand_where_there_is_room_beside_it() {
        let map = passage(2.0);
        let occupied = Occupied::new(&map);
        assert!(stays_open(&occupied, disc(-0.8), 0.2));
        assert!(!stays_open(&occupied, disc(0.0), 0.5));
    }

    #[test]
    fn a_thing_beside_another_closes_no_gap() {
        let map = Clearance::default();
        let mut occupied = Occupied::new(&map);
        assert!(stays_open(&occupied, disc(0.0), 0.5), "open ground");
        for i in 0..30 {
            // A wall with a gap of 1.6 m about the middle.
            let y = 1.1 + 0.6 * f64::from(i);
            occupied.add_disc(MapPoint::new(0.0, y), 0.3);
            occupied.add_disc(MapPoint::new(0.0, -y), 0.3);
        }
        assert!(!stays_open(&occupied, disc(0.0), 0.3));
    }

    #[test]
    fn parts_are_numbered() {
        let free = [true, false, true, true, false, true, true, false, true];
        assert_eq!(parts(&free, 3), [1, 0, 2, 1, 0, 2, 1, 0, 2]);
    }
}
