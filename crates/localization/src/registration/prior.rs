//! What is known about the robot's pose before buildings are compared: its start, and its way
//! since.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, Start};
use openbench_geometry::Bounds;

use super::vote::Headings;
use crate::deviation::PoseDeviation;

/// A start is never known better in a map than this, metres: the map itself may be displaced,
const LEAST_DEVIATION_M: f64 = 3.0;
/// and turned, radians.
const LEAST_DEVIATION_RAD: f64 = 3.0 * PI / 180.0;
/// Poses of more standard deviations are excluded.
const MOST_DEVIATIONS: f64 = 4.0;
/// A place is at most so far outside the given area or map, metres.
const BEYOND_M: f64 = 6.0;
/// Standard deviation of a start anywhere in the map, metres. No map reaches farther than a few of
/// these from its origin.
const ANYWHERE_M: f64 = 1e5;
/// Standard deviation of odometry's drift, as a share of the distance from the start.
const DRIFT: f64 = 0.02;

/// Where the robot started, as far as is known, and where it has moved since.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    start: Start,
    /// Of x, y and yaw of the start, if it is given as a pose.
    covariance: Matrix3<f64>,
    /// The same with the drift since, inverted.
    information: Matrix3<f64>,
    /// Pose of the robot in the frame of its start.
    motion: Pose2,
}

impl Prior {
    /// From what the briefing says; `None` if that is not finite.
    pub fn new(start: &Start) -> Option<Self> {
        let mut prior = Self {
            start: *start,
            covariance: Matrix3::zeros(),
            information: Matrix3::zeros(),
            motion: Pose2::default(),
        };
        match start {
            Start::Pose { pose, covariance } => {
                let covariance = Matrix3::from_fn(|row, column| covariance[row][column]);
                let least = Vector3::new(LEAST_DEVIATION_M, LEAST_DEVIATION_M, LEAST_DEVIATION_RAD);
                prior.covariance =
                    covariance + Matrix3::from_diagonal(&least.component_mul(&least));
                prior.information = prior.covariance.try_inverse()?;
                let deviation = prior.deviation();
                let numbers = [
                    pose.x,
                    pose.y,
                    pose.yaw,
                    deviation.metres,
                    deviation.radians,
                ];
                let is_sound = numbers.iter().all(|number| number.is_finite())
                    && prior.information.iter().all(|number| number.is_finite());
                is_sound.then_some(prior)
            }
            Start::Area { centre, radius_m } => {
                let is_sound = centre.x.is_finite() && centre.y.is_finite();
                (is_sound && *radius_m >= 0.0 && radius_m.is_finite()).then_some(prior)
            }
            Start::Anywhere => Some(prior),
        }
    }

    /// What is known about the start.
    #[cfg(test)]
    pub(super) fn start(&self) -> &Start {
        &self.start
    }

    /// The same after the robot has moved; `motion` is its pose in the frame of its start.
    #[must_use]
    pub fn after(self, motion: Pose2) -> Self {
        let moved = Self { motion, ..self };
        let Start::Pose { .. } = self.start else {
            return moved;
        };
        let variance = moved.drift() * moved.drift();
        let drift = Matrix3::from_diagonal(&Vector3::new(variance, variance, 0.0));
        let information = (self.covariance + drift).try_inverse();
        Self {
            information: information.unwrap_or(self.information),
            ..moved
        }
    }

    /// How far odometry may have drifted since the start, metres.
    fn drift(&self) -> f64 {
        DRIFT * self.motion.point().distance(MapPoint::default())
    }

    /// Whether the start is known better than to be in the map.
    pub fn is_bounded(&self) -> bool {
        !matches!(self.start, Start::Anywhere)
    }

    /// How well the start is known. A start anywhere in the map counts as known to 100 km.
    pub fn deviation(&self) -> PoseDeviation {
        let metres = match &self.start {
            Start::Pose { .. } => {
                let [x, y] = [0, 1].map(|axis| self.covariance[(axis, axis)]);
                x.max(y).sqrt()
            }
            Start::Area { radius_m, .. } => radius_m + BEYOND_M,
            Start::Anywhere => ANYWHERE_M,
        };
        let radians = match &self.start {
            Start::Pose { .. } => self.covariance[(2, 2)].sqrt(),
            _ => PI,
        };
        PoseDeviation { metres, radians }
    }

    /// Where the robot can be now. `map` is the box around all of the map.
    pub fn area(&self, map: Bounds) -> Bounds {
        let way = self.motion.point().distance(MapPoint::default());
        match &self.start {
            Start::Pose { pose, .. } => {
                let deviation = self.deviation();
                let spread = (MOST_DEVIATIONS * deviation.radians).min(PI);
                let reached = |share: f64| {
                    let yaw = pose.yaw + share * spread;
                    let start = Pose2::new(pose.x, pose.y, yaw);
                    Bounds::of_point(start.transform(self.motion.x, self.motion.y))
                };
                let shares = (-8..=8).map(|i| f64::from(i) / 8.0);
                // What an arc between two of these headings reaches beyond its ends.
                let bulge = way * (1.0 - libm::cos(spread / 16.0));
                let reached = shares.map(reached).reduce(Bounds::union);
                let deviation_m = libm::hypot(deviation.metres, self.drift());
                let margin = MOST_DEVIATIONS * deviation_m + bulge;
                reached.unwrap_or(map).grown(margin)
            }
            Start::Area { centre, radius_m } => {
                Bounds::of_point(*centre).grown(radius_m + way + self.drift() + BEYOND_M)
            }
            Start::Anywhere => map.grown(BEYOND_M),
        }
    }

    /// Which headings the robot can have now, three degrees apart.
    pub fn headings(&self) -> Headings {
        let Start::Pose { pose, .. } = &self.start else {
            return Headings::ALL;
        };
        let step = Headings::ALL.step;
        let side = (MOST_DEVIATIONS * self.deviation().radians / step).ceil();
        if 2.0 * side * step >= TAU {
            return Headings::ALL;
        }
        Headings {
            first: wrap_angle(pose.yaw + self.motion.yaw) - side * step,
            step,
            count: 2 * side as usize + 1,
        }
    }

    /// The space of poses in which the robot probably is, if it is searched for in this area:
    /// square metres times the share of all headings. Its inverse is the greatest density of the
    /// prior.
    pub fn volume(&self, area: Bounds) -> f64 {
        let size = (area.high.x - area.low.x) * (area.high.y - area.low.y);
        let headings = self.headings().count as f64 / Headings::ALL.count as f64;
        let searched = size * headings;
        // Of a normal distribution over x, y and yaw.
        let density = self.information.determinant().sqrt() / (TAU * TAU.sqrt());
        if density > 0.0 {
            searched.min(1.0 / (TAU * density))
        } else {
            searched
        }
    }

    /// What a pose of the robot costs, nats; infinite where it cannot be.
    pub fn cost(&self, robot: Pose2) -> f64 {
        let start = robot.compose(Pose2::default().seen_from(self.motion));
        match &self.start {
            Start::Pose { pose, .. } => {
                let turn = wrap_angle(start.yaw - pose.yaw);
                let error = Vector3::new(start.x - pose.x, start.y - pose.y, turn);
                let squares = error.dot(&(self.information * error));
                if squares > MOST_DEVIATIONS * MOST_DEVIATIONS {
                    f64::INFINITY
                } else {
                    0.5 * squares
                }
            }
            Start::Area { centre, radius_m } => {
                let beyond = BEYOND_M + self.drift();
                let is_inside = start.point().distance(*centre) <= radius_m + beyond;
                if is_inside { 0.0 } else { f64::INFINITY }
            }
            Start::Anywhere => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const MAP: Bounds = Bounds {
        low: MapPoint::new(-100.0, -50.0),
        high: MapPoint::new(200.0, 50.0),
    };

    fn given(pose: Pose2, metres: f64, radians: f64) -> Prior {
        let mut covariance = [[0.0; 3]; 3];
        for (axis, deviation) in [metres, metres, radians].into_iter().enumerate() {
            covariance[axis][axis] = deviation * deviation;
        }
        Prior::new(&Start::Pose { pose, covariance }).unwrap()
    }

    proptest! {
        #[test]
        fn what_costs_little_is_in_the_area(
            x in -20.0..20.0_f64, y in -20.0..20.0_f64, yaw in -3.1..3.1_f64,
            forward in -40.0..40.0_f64, left in -40.0..40.0_f64, turn in -3.0..3.0_f64,
        ) {
            let prior = given(Pose2::new(5.0, 6.0, 1.0), 5.0, 0.35);
            let motion = Pose2::new(forward, left, turn);
            let prior = prior.after(motion);
            let robot = Pose2::new(x, y, yaw).compose(motion);
            if prior.cost(robot).is_finite() {
                prop_assert!(prior.area(MAP).holds(robot.point(), 0.0));
                let headings = prior.headings();
                let last = headings.step * (headings.count - 1) as f64;
                let after = (robot.yaw - headings.first + 0.5).rem_euclid(TAU) - 0.5;
                prop_assert!((-0.01..=last + 0.01).contains(&after));
            }
        }
    }

    #[test]
    fn no_start_is_known_better_than_to_three_metres_and_three_degrees() {
        let exact = given(Pose2::default(), 0.0, 0.0).deviation();
        assert!((exact.metres - 3.0).abs() < 1e-9, "{exact:?}");
        assert!((exact.radians.to_degrees() - 3.0).abs() < 1e-9, "{exact:?}");
        let worse = given(Pose2::default(), 4.0, 0.0).deviation();
        assert!((worse.metres - 5.0).abs() < 1e-9, "{worse:?}");
    }

    #[test]
    fn drift_widens_what_is_known() {
        let far = Pose2::new(200.0, 0.0, 0.0);
        let start = given(Pose2::default(), 0.0, 0.0);
        // Six standard deviations of the start, and less than three with the drift of 200 m.
        let (near, beside) = (Pose2::new(0.0, 18.0, 0.0), Pose2::new(200.0, 14.0, 0.0));
        assert!(start.cost(near).is_infinite());
        assert!(start.after(far).cost(beside).is_finite());
        let inside = Prior::new(&Start::Area {
            centre: MapPoint::default(),
            radius_m: 10.0,
        });
        let inside = inside.unwrap().after(far);
        assert_eq!(inside.cost(Pose2::new(219.0, 0.0, 0.0)), 0.0);
        assert!(inside.cost(Pose2::new(221.0, 0.0, 0.0)).is_infinite());
    }

    #[test]
    fn an_exact_start_is_known_to_three_metres_in_a_map() {
        let prior = given(Pose2::new(5.0, 6.0, 1.0), 0.0, 0.0);
        let at = |x| prior.cost(Pose2::new(x, 6.0, 1.0));
        assert_eq!(at(5.0), 0.0);
        assert!((at(8.0) - 0.5).abs() < 1e-9);
        assert_eq!(at(18.0), f64::INFINITY);
        assert!(prior.headings().count < 12);
    }

    #[test]
    fn the_volume_of_a_known_start_grows_with_its_deviations_up_to_what_is_searched() {
        // What adds to the least deviations is chosen so that the sums are these.
        let rest = |sum: f64, least: f64| (sum * sum - least * least).sqrt();
        let volume = |metres: f64, radians: f64| {
            let metres = rest(metres, LEAST_DEVIATION_M);
            given(Pose2::default(), metres, rest(radians, LEAST_DEVIATION_RAD)).volume(MAP)
        };
        let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 1e-9;
        // 10 m by 10 m, and 0.1 of TAU.
        assert!(near(volume(10.0, 0.2), 10.0 * 10.0 * 0.2 * TAU.sqrt()));
        assert!(near(volume(1000.0, 3.0), 300.0 * 100.0));
        assert!(near(
            Prior::new(&Start::Anywhere).unwrap().volume(MAP),
            30_000.0
        ));
    }

    #[test]
    fn an_area_moves_with_the_robot_whatever_its_heading() {
        let start = Start::Area {
            centre: MapPoint::new(10.0, 0.0),
            radius_m: 75.0,
        };
        let prior = Prior::new(&start)
            .unwrap()
            .after(Pose2::new(30.0, 0.0, 0.0));
        assert_eq!(prior.headings(), Headings::ALL);
        assert_eq!(prior.cost(Pose2::new(110.0, 0.0, 0.0)), 0.0);
        assert_eq!(prior.cost(Pose2::new(110.0, 0.0, PI)), f64::INFINITY);
        assert!(prior.area(MAP).holds(MapPoint::new(110.0, 0.0), 0.0));
    }

    #[test]
    fn nothing_is_known_of_a_start_that_is_not_finite() {
        let nan = Start::exact(Pose2::new(f64::NAN, 0.0, 0.0));
        assert_eq!(Prior::new(&nan), None);
        let covariance = [[f64::INFINITY, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        let pose = Pose2::default();
        assert_eq!(Prior::new(&Start::Pose { pose, covariance }), None);
        let radius_m = f64::NAN;
        let centre = MapPoint::default();
        assert_eq!(Prior::new(&Start::Area { centre, radius_m }), None);
        assert!(Prior::new(&Start::Anywhere).is_some());
    }
}
