//! Straight segments on the ground, with the measures that walls, roads and barriers share.

use std::f64::consts::FRAC_PI_2;

use openbench_core::{MapPoint, Pose2};
use openbench_osm::polygon;

use crate::triangulate::turn;

/// A directed segment in the `map` frame. Of a building's wall, the building lies on the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    /// Where it begins.
    pub a: MapPoint,
    /// Where it ends.
    pub b: MapPoint,
}

/// Where another segment crosses a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// Share of the crossed segment at which the crossing lies, 0 to 1.
    pub share: f64,
    /// Sine of the angle between the two, 0 to 1.
    pub sine: f64,
}

impl Segment {
    pub const fn new(a: MapPoint, b: MapPoint) -> Self {
        Self { a, b }
    }

    /// The line across a pose's heading, `forward` metres before it and `half` metres to each side.
    /// It runs from the pose's right to its left, as a wall does that the pose faces away from.
    pub fn across(pose: Pose2, forward: f64, half: f64) -> Self {
        Self::new(
            pose.transform(forward, -half),
            pose.transform(forward, half),
        )
    }

    /// Metres.
    pub fn length(self) -> f64 {
        self.a.distance(self.b)
    }

    /// Direction from `a` to `b`: radians, counter-clockwise from east.
    pub fn bearing(self) -> f64 {
        self.a.bearing_to(self.b)
    }

    /// Direction to the right, which leads out of a building's wall: radians.
    pub fn outward(self) -> f64 {
        self.bearing() - FRAC_PI_2
    }

    /// The point at a share of the length; outside 0 to 1 it lies beyond the ends.
    pub fn at(self, share: f64) -> MapPoint {
        let Self { a, b } = self;
        MapPoint::new(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share)
    }

    pub fn middle(self) -> MapPoint {
        self.at(0.5)
    }

    /// The part between two shares of the length.
    pub fn part(self, from: f64, to: f64) -> Self {
        Self::new(self.at(from), self.at(to))
    }

    /// At `a`, looking along the segment.
    pub fn pose(self) -> Pose2 {
        Pose2::new(self.a.x, self.a.y, self.bearing())
    }

    /// At a share of the length, looking to the right: away from the building of a wall.
    pub fn facing_out(self, share: f64) -> Pose2 {
        let p = self.at(share);
        Pose2::new(p.x, p.y, self.outward())
    }

    /// Distance from a point, metres.
    pub fn distance_to_point(self, p: MapPoint) -> f64 {
        let Self { a, b } = self;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let squared = dx * dx + dy * dy;
        let share = if squared > 0.0 {
            (((p.x - a.x) * dx + (p.y - a.y) * dy) / squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance(self.at(share))
    }

    /// Distance from another segment, metres; 0 where they cross.
    pub fn distance_to(self, other: Self) -> f64 {
        let (Self { a, b }, Self { a: c, b: d }) = (self, other);
        if turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0 {
            return 0.0;
        }
        let ends = [
            other.distance_to_point(a),
            other.distance_to_point(b),
            self.distance_to_point(c),
            self.distance_to_point(d),
        ];
        ends.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Where `other` crosses or touches this segment.
    pub fn crossing(self, other: Self) -> Option<Crossing> {
        let (Self { a, b }, Self { a: c, b: d }) = (self, other);
        let (from, to) = (turn(c, d, a), turn(c, d, b));
        let touches = from * to <= 0.0 && turn(a, b, c) * turn(a, b, d) <= 0.0 && from != to;
        touches.then(|| Crossing {
            share: from / (from - to),
            sine: (from - to).abs() / (self.length() * other.length()).max(1e-9),
        })
    }
}

impl From<polygon::Segment> for Segment {
    fn from(side: polygon::Segment) -> Self {
        Self::new(side.start, side.end)
    }
}

/// The segments of a line, in its order.
pub(super) fn segments(line: &[MapPoint]) -> impl Iterator<Item = Segment> + Clone + '_ {
    line.windows(2).map(|pair| Segment::new(pair[0], pair[1]))
}

/// The sides of a closed ring, the last from its last corner to its first.
pub(super) fn sides(ring: &[MapPoint]) -> impl Iterator<Item = Segment> + '_ {
    (0..ring.len()).map(|i| Segment::new(ring[i], ring[(i + 1) % ring.len()]))
}

#[cfg(test)]
mod tests {
    use super::*;

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
