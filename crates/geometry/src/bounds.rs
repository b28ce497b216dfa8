//! Axis-aligned bounding boxes.

use std::ops::Range;

use openbench_core::MapPoint;

use crate::segment::Segment;

/// An axis-aligned box in the `map` frame.
///
/// ```
/// use openbench_core::MapPoint;
/// use openbench_geometry::Bounds;
///
/// let yard = Bounds { low: MapPoint::new(0.0, 0.0), high: MapPoint::new(20.0, 10.0) };
/// assert_eq!(yard.distance(MapPoint::new(23.0, 14.0)), 5.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// South-west corner.
    pub low: MapPoint,
    /// North-east corner.
    pub high: MapPoint,
}

impl Bounds {
    /// The box that holds one point.
    #[inline]
    pub const fn of_point(point: MapPoint) -> Self {
        Self {
            low: point,
            high: point,
        }
    }

    /// The smallest box that holds both.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            low: MapPoint::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: MapPoint::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
        }
    }

    /// The part that both have in common. If there is none, `low` is beyond `high`.
    #[must_use]
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self {
            low: MapPoint::new(self.low.x.max(other.low.x), self.low.y.max(other.low.y)),
            high: MapPoint::new(self.high.x.min(other.high.x), self.high.y.min(other.high.y)),
        }
    }

    /// The box with `margin` more metres on each side.
    #[must_use]
    #[inline]
    pub fn grown(self, margin: f64) -> Self {
        Self {
            low: MapPoint::new(self.low.x - margin, self.low.y - margin),
            high: MapPoint::new(self.high.x + margin, self.high.y + margin),
        }
    }

    /// Whether `point` lies at most `margin` metres outside along each axis. A point with NaN does
    /// not.
    #[inline]
    pub fn holds(&self, point: MapPoint, margin: f64) -> bool {
        point.x >= self.low.x - margin
            && point.x <= self.high.x + margin
            && point.y >= self.low.y - margin
            && point.y <= self.high.y + margin
    }

    /// The point in its middle.
    #[inline]
    pub fn middle(&self) -> MapPoint {
        MapPoint::new(
            (self.low.x + self.high.x) / 2.0,
            (self.low.y + self.high.y) / 2.0,
        )
    }

    /// The corners, counter-clockwise from the south-west.
    pub fn corners(&self) -> [MapPoint; 4] {
        [
            self.low,
            MapPoint::new(self.high.x, self.low.y),
            self.high,
            MapPoint::new(self.low.x, self.high.y),
        ]
    }

    /// Whether both have a point in common if this box had `margin` more metres on each side.
    pub fn meets(&self, other: Self, margin: f64) -> bool {
        other.low.x <= self.high.x + margin
            && other.high.x >= self.low.x - margin
            && other.low.y <= self.high.y + margin
            && other.high.y >= self.low.y - margin
    }

    /// The part of a segment that lies in the box, as shares of its length (Liang and Barsky, *A
    /// New Concept and Method for Line Clipping*, 1984).
    pub fn clip(&self, Segment { start: a, end: b }: Segment) -> Option<Range<f64>> {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        // The segment at share t is inside an edge while t * leaving <= room.
        let edges = [
            Edge::new(-dx, a.x - self.low.x),
            Edge::new(dx, self.high.x - a.x),
            Edge::new(-dy, a.y - self.low.y),
            Edge::new(dy, self.high.y - a.y),
        ];
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for Edge { leaving, room } in edges {
            // Parallel to the edge and beyond it.
            if leaving == 0.0 && room < 0.0 {
                return None;
            }
            // Inwards: inside from that share on. Outwards: inside up to it.
            if leaving < 0.0 {
                from = from.max(room / leaving);
            } else if leaving > 0.0 {
                to = to.min(room / leaving);
            }
        }
        (from < to).then_some(from..to)
    }

    /// Metres from `point` to the box; 0 inside.
    #[inline]
    pub fn distance(&self, point: MapPoint) -> f64 {
        let dx = (self.low.x - point.x).max(point.x - self.high.x).max(0.0);
        let dy = (self.low.y - point.y).max(point.y - self.high.y).max(0.0);
        (dx * dx + dy * dy).sqrt()
    }
}

/// An edge of a box as a segment sees it.
struct Edge {
    /// How far the segment runs outwards through the edge, metres; inwards if negative.
    leaving: f64,
    /// Distance of the segment's start from the edge, metres; negative outside.
    room: f64,
}

impl Edge {
    const fn new(leaving: f64, room: f64) -> Self {
        Self { leaving, room }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_from_the_nearest_side_or_corner() {
        let bounds = Bounds {
            low: MapPoint::new(0.0, 0.0),
            high: MapPoint::new(2.0, 1.0),
        };
        assert_eq!(bounds.distance(MapPoint::new(1.0, 0.5)), 0.0);
        assert_eq!(bounds.distance(MapPoint::new(1.0, 4.0)), 3.0);
        assert_eq!(bounds.distance(MapPoint::new(5.0, -4.0)), 5.0);
    }

    #[test]
    fn a_grown_box_intersected_with_the_box_is_the_box() {
        let bounds = Bounds {
            low: MapPoint::new(0.0, 0.0),
            high: MapPoint::new(2.0, 1.0),
        };
        let grown = bounds.grown(0.5);
        assert_eq!(grown.low, MapPoint::new(-0.5, -0.5));
        assert_eq!(grown.high, MapPoint::new(2.5, 1.5));
        assert_eq!(grown.intersection(bounds), bounds);
        assert_eq!(grown.union(bounds), grown);
        assert!(bounds.holds(MapPoint::new(2.4, 1.4), 0.5));
        assert!(!bounds.holds(MapPoint::new(f64::NAN, 0.5), 0.5));
        assert!(bounds.meets(grown, 0.0));
        assert_eq!(bounds.middle(), MapPoint::new(1.0, 0.5));
    }

    #[test]
    fn a_segment_is_clipped_at_the_sides_that_it_crosses() {
        let bounds = Bounds {
            low: MapPoint::new(0.0, 0.0),
            high: MapPoint::new(10.0, 10.0),
        };
        let through = Segment::new(MapPoint::new(-5.0, 4.0), MapPoint::new(15.0, 4.0));
        assert_eq!(bounds.clip(through), Some(0.25..0.75));
        let beside = Segment::new(MapPoint::new(-5.0, 11.0), MapPoint::new(15.0, 11.0));
        assert_eq!(bounds.clip(beside), None);
    }
}
