//! The outline of a car: a rectangle about its pose.

use openbench_core::{MapPoint, Pose2};

/// A car as people see it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CarHull {
    pub pose: Pose2,
    /// Half length and half width, metres.
    pub half: [f64; 2],
    /// Speed forward, m/s.
    pub speed: f64,
}

impl CarHull {
    /// The point of the hull nearest to `point`, the hull stretched forward by `stretch` metres.
    pub fn nearest(&self, point: MapPoint, stretch: f64) -> MapPoint {
        let (forward, left) = self.pose.inverse_transform(point);
        let [long, wide] = self.half;
        self.pose.transform(
            forward.clamp(-long, long + stretch),
            left.clamp(-wide, wide),
        )
    }

    /// Whether the hull may be within `reach` metres of `point`: a quick look.
    pub fn is_within(&self, point: MapPoint, reach: f64) -> bool {
        let (dx, dy) = (point.x - self.pose.x, point.y - self.pose.y);
        let reach = reach + self.half[0] + self.half[1];
        dx * dx + dy * dy < reach * reach
    }

    /// Metres from `point` to the hull; 0 inside.
    #[cfg(test)]
    pub fn distance(&self, point: MapPoint) -> f64 {
        point.distance(self.nearest(point, 0.0))
    }

    /// The shift by which a disc at `point` comes out of the hull, the shortest way; zero if it is outside.
    pub fn way_out(&self, point: MapPoint, radius: f64) -> [f64; 2] {
        if !self.is_within(point, radius) {
            return [0.0; 2];
        }
        let (forward, left) = self.pose.inverse_transform(point);
        let deep = [
            self.half[0] + radius - forward.abs(),
            self.half[1] + radius - left.abs(),
        ];
        if deep[0] <= 0.0 || deep[1] <= 0.0 {
            return [0.0; 2];
        }
        let (x, y) = if deep[0] < deep[1] {
            (deep[0] * forward.signum(), 0.0)
        } else {
            (0.0, deep[1] * left.signum())
        };
        let to = Pose2::new(0.0, 0.0, self.pose.yaw).transform(x, y);
        [to.x, to.y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_comes_out_the_shortest_way() {
        let car = CarHull {
            pose: Pose2::new(1.0, 2.0, std::f64::consts::FRAC_PI_2),
            half: [2.0, 1.0],
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
