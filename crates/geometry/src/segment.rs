//! Line segments, with the measures that walls, roads and paths share.

use std::f64::consts::FRAC_PI_2;

use openbench_core::{MapPoint, Pose2};

use crate::turn::turn;

/// A directed straight line between two points of the `map` frame. A building lies to the left of
/// its walls.
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

/// Where another segment crosses a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Share of the crossed segment at which the crossing lies, 0 to 1.
    pub share: f64,
    /// Sine of the angle between the two, 0 to 1.
    pub sine: f64,
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
    /// use openbench_geometry::Segment;
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
        // Without a length the quotient is NaN or infinite, and the start is the nearest point.
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

    /// The line across a pose's heading, `forward` metres before it and `half` metres to each side.
    /// It runs from the pose's right to its left, as a wall does that the pose faces away from.
    pub fn across(pose: Pose2, forward: f64, half: f64) -> Self {
        Self::new(
            pose.transform(forward, -half),
            pose.transform(forward, half),
        )
    }

    /// Direction from start to end: radians, counter-clockwise from east.
    pub fn bearing(self) -> f64 {
        self.start.bearing_to(self.end)
    }

    /// Direction to the right, which leads out of a building's wall: radians.
    pub fn outward(self) -> f64 {
        self.bearing() - FRAC_PI_2
    }

    /// The point at a share of the length; outside 0 to 1 it lies beyond the ends.
    #[inline]
    pub fn at(self, share: f64) -> MapPoint {
        let Self { start: a, end: b } = self;
        MapPoint::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share)
    }

    /// The point half-way.
    pub fn middle(self) -> MapPoint {
        self.at(0.5)
    }

    /// The part between two shares of the length.
    pub fn part(self, from: f64, to: f64) -> Self {
        Self::new(self.at(from), self.at(to))
    }

    /// At the start, heading along the segment.
    pub fn pose(self) -> Pose2 {
        Pose2::new(self.start.x, self.start.y, self.bearing())
    }

    /// At a share of the length, heading to the right: away from the building of a wall.
    pub fn facing_out(self, share: f64) -> Pose2 {
        let p = self.at(share);
        Pose2::new(p.x, p.y, self.outward())
    }

    /// Distance from a point, metres.
    pub fn distance_to_point(self, point: MapPoint) -> f64 {
        point.distance(self.nearest_point(point).point)
    }

    /// Distance from another segment, metres; 0 where they cross.
    pub fn distance_to(self, other: Self) -> f64 {
        if self.crosses(other) {
            return 0.0;
        }
        // Segments that do not cross are nearest at an end of one of them. Touching ones have an
        // end on the other, at distance 0.
        let ends = [
            other.distance_to_point(self.start),
            other.distance_to_point(self.end),
            self.distance_to_point(other.start),
            self.distance_to_point(other.end),
        ];
        ends.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether the segments cross at a point inside both. Segments that only touch do not.
    ///
    /// ```
    /// use openbench_core::MapPoint;
    /// use openbench_geometry::Segment;
    ///
    /// let road = Segment::new(MapPoint::new(0.0, 0.0), MapPoint::new(10.0, 0.0));
    /// let path = Segment::new(MapPoint::new(4.0, -3.0), MapPoint::new(4.0, 3.0));
    /// assert!(road.crosses(path));
    /// assert_eq!(road.crossing(path).map(|crossing| crossing.share), Some(0.4));
    /// ```
    #[inline]
    pub fn crosses(self, other: Self) -> bool {
        let (Self { start: a, end: b }, Self { start: c, end: d }) = (self, other);
        // Strict on both sides: segments that share an end, as sides of a ring do, do not cross.
        turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
    }

    /// Where `other` crosses or touches this segment.
    pub fn crossing(self, other: Self) -> Option<Crossing> {
        let (Self { start: a, end: b }, Self { start: c, end: d }) = (self, other);
        // Signed distances of both ends from the line of `other`, times its length. The crossing
        // divides this segment in their ratio; equal ones mean parallel lines.
        let (from, to) = (turn(c, d, a), turn(c, d, b));
        let touches = from * to <= 0.0 && turn(a, b, c) * turn(a, b, d) <= 0.0 && from != to;
        touches.then(|| Crossing {
            share: from / (from - to),
            // `from - to` is the cross product of both directions, |self| |other| sine.
            sine: (from - to).abs() / (self.length() * other.length()).max(1e-9),
        })
    }
}

/// The segments of a line, in its order.
pub fn segments(line: &[MapPoint]) -> impl Iterator<Item = Segment> + Clone + '_ {
    line.windows(2).map(|pair| Segment::new(pair[0], pair[1]))
}

/// The sides of a ring whose first point is not repeated at its end.
#[inline]
pub fn sides(ring: &[MapPoint]) -> impl Iterator<Item = Segment> + '_ {
    // The last side leads back to the first point.
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

    fn segment(a: (f64, f64), b: (f64, f64)) -> Segment {
        Segment::new(MapPoint::new(a.0, a.1), MapPoint::new(b.0, b.1))
    }

    #[test]
    fn the_nearest_point_of_a_segment_may_be_its_end() {
        let distance =
            segment((0.0, 0.0), (4.0, 0.0)).distance_to(segment((6.0, -1.0), (6.0, 5.0)));
        assert!((distance - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_crossing_has_a_share_and_an_angle() {
        let wall = segment((0.0, 0.0), (10.0, 0.0));
        let crossing = wall.crossing(segment((4.0, -1.0), (4.0, 5.0))).unwrap();
        assert!((crossing.share - 0.4).abs() < 1e-12 && (crossing.sine - 1.0).abs() < 1e-12);
        assert_eq!(wall.crossing(segment((4.0, 1.0), (4.0, 5.0))), None);
        assert_eq!(wall.crossing(segment((0.0, 1.0), (10.0, 1.0))), None);
    }

    #[test]
    fn outward_is_to_the_right() {
        let pose = segment((0.0, 0.0), (10.0, 0.0)).facing_out(0.5);
        assert!(pose.transform(1.0, 0.0).distance(MapPoint::new(5.0, -1.0)) < 1e-12);
    }
}
