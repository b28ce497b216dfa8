//! What stands on the ground so far, and whether something else fits between it.

use openbench_core::MapPoint;
use openbench_geometry::{Bounds, Polygon, Segment, segments, sides};

use crate::plan::{Half, Street};

/// A building may stand so far outside the planned rectangle, metres.
const OUTSIDE_M: f64 = 1.0;
/// Least distance of a building from the edge of a pavement, metres.
const FROM_EDGE_M: f64 = 0.2;

/// A stretch of a street or path, and half its width.
#[derive(Debug, Clone, Copy)]
struct Strip {
    axis: Segment,
    /// Metres.
    half: f64,
}

/// The outline of something solid.
#[derive(Debug, Clone)]
struct Taken {
    polygon: Polygon,
    bounds: Bounds,
}

/// The ground of a neighbourhood.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    half: Half,
    strips: Vec<Strip>,
    taken: Vec<Taken>,
}

impl Ground {
    pub fn new(half: Half, streets: &[Street]) -> Self {
        let mut ground = Self {
            half,
            strips: Vec::new(),
            taken: Vec::new(),
        };
        for street in streets {
            ground.add_strip(&street.line, street.edge() + FROM_EDGE_M);
        }
        ground
    }

    /// Keeps what is within `half` metres of a line free.
    pub fn add_strip(&mut self, line: &[MapPoint], half: f64) {
        let stretches = segments(line).map(|axis| Strip { axis, half });
        self.strips.extend(stretches);
    }

    /// Adds the outline of a building and returns its number here.
    pub fn add(&mut self, ring: &[MapPoint]) -> usize {
        if let Some(polygon) = Polygon::new(ring.to_vec(), Vec::new()) {
            let bounds = polygon.bounds();
            self.taken.push(Taken { polygon, bounds });
        }
        self.taken.len().saturating_sub(1)
    }

    /// Whether a building fits: inside the rectangle, off the streets, `gap` metres from others.
    /// Those numbered from `touching` on may be touched.
    pub fn fits(&self, ring: &[MapPoint], gap: f64, touching: usize) -> bool {
        let inside = |p: &MapPoint| {
            p.x.abs() <= self.half.x + OUTSIDE_M && p.y.abs() <= self.half.y + OUTSIDE_M
        };
        let off_streets = || {
            let mut strips = self.strips.iter();
            strips.all(|s| sides(ring).all(|side| side.distance_to(s.axis) > s.half))
        };
        let free = || {
            let mut others = self.taken.iter().enumerate();
            others.all(|(i, other)| {
                let gap = if i >= touching { 0.0 } else { gap };
                apart(ring, other, gap)
            })
        };
        ring.iter().all(inside) && off_streets() && free()
    }

    /// Whether a line keeps so many metres away from all buildings.
    pub fn is_clear_of_buildings(&self, line: Segment, metres: f64) -> bool {
        self.taken.iter().all(|other| {
            let near = other.bounds.grown(metres);
            let meets = near.meets(
                Bounds::of_point(line.start).union(Bounds::of_point(line.end)),
                0.0,
            );
            !meets || is_clear(line, &other.polygon, metres)
        })
    }

    /// Whether a line keeps so many metres away from the edges of all streets and paths.
    pub fn is_off_streets(&self, line: Segment, metres: f64) -> bool {
        let mut strips = self.strips.iter();
        strips.all(|s| line.distance_to(s.axis) > s.half + metres)
    }
}

fn is_clear(line: Segment, polygon: &Polygon, metres: f64) -> bool {
    polygon.sides().all(|side| side.distance_to(line) > metres) && !polygon.contains(line.start)
}

fn apart(ring: &[MapPoint], other: &Taken, gap: f64) -> bool {
    let corners = ring.iter().map(|p| Bounds::of_point(*p));
    let Some(bounds) = corners.reduce(Bounds::union) else {
        return true;
    };
    if !bounds.meets(other.bounds, gap) {
        return true;
    }
    let clear = sides(ring).all(|side| is_clear(side, &other.polygon, gap));
    let holds = Polygon::new(ring.to_vec(), Vec::new())
        .is_some_and(|polygon| polygon.contains(other.polygon.outer[0]));
    clear && !holds
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> Vec<MapPoint> {
        [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
            .map(|(dx, dy)| MapPoint::new(x + dx, dy))
            .to_vec()
    }

    #[test]
    fn buildings_keep_their_distance_unless_they_may_touch() {
        let half = Half { x: 50.0, y: 50.0 };
        let mut ground = Ground::new(half, &[]);
        assert_eq!(ground.add(&square(0.0, 8.0)), 0);
        assert!(ground.fits(&square(12.0, 8.0), 3.0, 1));
        assert!(!ground.fits(&square(10.0, 8.0), 3.0, 1));
        assert!(ground.fits(&square(8.1, 8.0), 3.0, 0));
        // Inside, and around.
        assert!(!ground.fits(&square(2.0, 2.0), 0.0, 0));
        assert!(!ground.fits(&square(-1.0, 20.0), 0.0, 0));
        assert!(!ground.fits(&square(45.0, 8.0), 0.0, 1));
    }
}
