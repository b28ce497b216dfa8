//! The outline of a car: a rectangle about its pose.

use openbench_core::{MapPoint, Pose2};

/// Half the length of a car, metres: that of the longest drawn one, a van.
pub(crate) const CAR_HALF_LENGTH_M: f64 = 2.22;
/// Half the width of a car, metres, its wheels included.
pub(crate) const CAR_HALF_WIDTH_M: f64 = 0.89;

/// A car as people see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CarHull {
    pub pose: Pose2,
    /// Half the length, metres.
    pub half_length: f64,
    /// Half the width, metres.
    pub half_width: f64,
    /// Speed forward, m/s.
    pub speed: f64,
}

impl CarHull {
    /// A car of the usual size.
    pub fn new(pose: Pose2, speed: f64) -> Self {
        Self {
            pose,
            half_length: CAR_HALF_LENGTH_M,
            half_width: CAR_HALF_WIDTH_M,
            speed,
        }
    }

    /// The point of the hull nearest to `point`, with the hull stretched forward by `stretch`
    /// metres.
    pub fn nearest(&self, point: MapPoint, stretch: f64) -> MapPoint {
        let (forward, left) = self.pose.inverse_transform(point);
        let (long, wide) = (self.half_length, self.half_width);
        self.pose.transform(
            forward.clamp(-long, long + stretch),
            left.clamp(-wide, wide),
        )
    }

    /// Whether the hull may be within `reach` metres of `point`: a cheap test that never misses.
    pub fn may_reach(&self, point: MapPoint, reach: f64) -> bool {
        let (dx, dy) = (point.x - self.pose.x, point.y - self.pose.y);
        // The sum of two sides is more than the diagonal, which is the farthest corner.
        let reach = reach + self.half_length + self.half_width;
        dx * dx + dy * dy < reach * reach
    }

    /// Metres from `point` to the hull; 0 inside.
    #[cfg(test)]
    pub fn distance(&self, point: MapPoint) -> f64 {
        point.distance(self.nearest(point, 0.0))
    }

    /// The shortest shift that moves a disc at `point` out of the hull, metres in `map`; zero if it
    /// is outside.
    pub fn way_out(&self, point: MapPoint, radius: f64) -> [f64; 2] {
        if !self.may_reach(point, radius) {
            return [0.0; 2];
        }
        let (forward, left) = self.pose.inverse_transform(point);
        let depth_along = self.half_length + radius - forward.abs();
        let depth_across = self.half_width + radius - left.abs();
        if depth_along <= 0.0 || depth_across <= 0.0 {
            return [0.0; 2];
        }
        // Along the axis on which less is missing. Corners count as square, so a disc may be moved
        // a little too far there.
        let (x, y) = if depth_along < depth_across {
            (depth_along * forward.signum(), 0.0)
        } else {
            (0.0, depth_across * left.signum())
        };
        // A shift has a direction and no place: it is turned, and not moved.
        let to = Pose2::new(0.0, 0.0, self.pose.yaw).transform(x, y);
        [to.x, to.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_leaves_the_hull_by_the_shortest_shift() {
        let pose = Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
        let car = CarHull {
            pose,
            half_length: 2.0,
            half_width: 1.0,
            speed: 0.0,
        };
        let inside = MapPoint::new(1.8, 2.5);
        let [x, y] = car.way_out(inside, 0.3);
        assert!((x - 0.5).abs() < 1e-12 && y.abs() < 1e-12, "{x} {y}");
        assert_eq!(car.distance(inside), 0.0);
        assert!((car.distance(MapPoint::new(3.0, 2.0)) - 1.0).abs() < 1e-12);
        assert_eq!(car.way_out(MapPoint::new(2.4, 2.0), 0.3), [0.0; 2]);
    }
}
