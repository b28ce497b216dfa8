//! Line segments.

use openbench_core::MapPoint;

/// A straight line between two points of the `map` frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// Where it begins.
    pub start: MapPoint,
    /// Where it ends.
    pub end: MapPoint,
}

/// A point of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FootPoint {
    /// Its position.
    pub point: MapPoint,
    /// The share of the segment before it: 0 at the start, 1 at the end.
    pub share: f64,
}

impl Segment {
    /// The segment from `start` to `end`.
    #[inline]
    pub const fn new(start: MapPoint, end: MapPoint) -> Self {
        Self { start, end }
    }

    /// Its length, metres.
    #[inline]
    pub fn length(self) -> f64 {
        self.start.distance(self.end)
    }

    /// The point of the segment nearest to `point`. The start, if the segment has no length.
    ///
    /// ```
    /// use openbench_core::MapPoint;
    /// use openbench_osm::polygon::Segment;
    ///
    /// // A wall of 10 m along the east axis, and a robot 2 m north of it.
    /// let wall = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(10.0, 0.0));
    /// let foot = wall.nearest_point(MapPoint::new(2.5, 2.0));
    /// assert_eq!(foot.point, MapPoint::new(2.5, 0.0));
    /// assert_eq!(foot.share, 0.25);
    /// ```
    #[inline]
    pub fn nearest_point(self, point: MapPoint) -> FootPoint {
        let Self { start: a, end: b } = self;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let squared = dx * dx + dy * dy;
        let t = ((point.x - a.x) * dx + (point.y - a.y) * dy) / squared;
        let t = if squared > 0.0 {
            t.clamp(0.0, 1.0)
        } else {
            0.0
        };
        FootPoint {
            point: MapPoint::new(a.x + t * dx, a.y + t * dy),
            share: t,
        }
    }
}

/// The sides of a ring whose first point is not repeated at its end.
#[inline]
pub(super) fn sides(ring: &[MapPoint]) -> impl Iterator<Item = Segment> + '_ {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(start, end)| Segment::new(*start, *end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_stays_on_the_segment() {
        let wall = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(10.0, 0.0));
        assert_eq!(wall.nearest_point(MapPoint::new(-3.0, 1.0)).share, 0.0);
        assert_eq!(wall.nearest_point(MapPoint::new(13.0, 1.0)).point, wall.end);
        let point = MapPoint::new(1.0, 1.0);
        assert_eq!(
            Segment::new(point, point).nearest_point(wall.start).point,
            point
        );
    }
}
