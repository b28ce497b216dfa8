//! Where the robot is by all fixes so far, carried on by odometry: a Kalman filter of one pose.

use nalgebra::{Matrix3, Vector3};
use openbench_core::Pose2;
use openbench_core::frames::wrap_angle;

use super::prior::relative;

/// Odometry errs by this share of the way,
const DRIFT: f64 = 0.01;
/// and turns by so many radians on each metre of it.
const DRIFT_RAD_PER_M: f64 = 4e-4;
/// A measured pose of more standard deviations contradicts the estimate.
const CREDIBLE: f64 = 4.0;
/// What is known of a direction that nothing measures: a kilometre, and any heading.
const NOTHING: [f64; 3] = [1e-6, 1e-6, 0.1];

/// A pose in `map` with its covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The pose of the robot.
    pub pose: Pose2,
    /// Covariance of x, y of `map`, and yaw.
    pub covariance: Matrix3<f64>,
    /// Pose of the robot in `odom` there.
    here: Pose2,
}

impl Estimate {
    /// From a measured pose and the information about it; `here` is the pose in `odom`. `None` if
    /// they are not finite.
    pub fn new(pose: Pose2, information: Matrix3<f64>, here: Pose2) -> Option<Self> {
        let covariance = (information + Matrix3::from_diagonal(&NOTHING.into())).try_inverse()?;
        covariance.iter().all(|x| x.is_finite()).then_some(Self {
            pose,
            covariance,
            here,
        })
    }

    /// The same after the robot has moved.
    #[must_use]
    pub fn carried(self, here: Pose2) -> Self {
        let motion = relative(self.here, here);
        let pose = self.pose.compose(motion);
        let (dx, dy) = (pose.x - self.pose.x, pose.y - self.pose.y);
        // An error of the heading displaces what lies ahead.
        let lever = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let way = libm::hypot(dx, dy);
        let (metres, radians) = (DRIFT * way, DRIFT_RAD_PER_M * way);
        let drift = Vector3::new(metres * metres, metres * metres, radians * radians);
        Self {
            pose,
            covariance: lever * self.covariance * lever.transpose()
                + Matrix3::from_diagonal(&drift),
            here,
        }
    }

    /// The same with a pose that was measured here. `None` if that contradicts it.
    pub fn with(self, measured: Pose2, information: Matrix3<f64>) -> Option<Self> {
        let own = Self::new(measured, information, self.here)?;
        let turn = wrap_angle(measured.yaw - self.pose.yaw);
        let error = Vector3::new(measured.x - self.pose.x, measured.y - self.pose.y, turn);
        let expected = (self.covariance + own.covariance).try_inverse()?;
        let gain = self.covariance * expected;
        let is_credible = error.dot(&(expected * error)) <= CREDIBLE * CREDIBLE;
        if !is_credible {
            return None;
        }
        let change = gain * error;
        let covariance = (Matrix3::identity() - gain) * self.covariance;
        Some(Self {
            pose: Pose2::new(
                self.pose.x + change.x,
                self.pose.y + change.y,
                wrap_angle(self.pose.yaw + change.z),
            ),
            covariance: 0.5 * (covariance + covariance.transpose()),
            ..self
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(metres: f64) -> Matrix3<f64> {
        let information = 1.0 / (metres * metres);
        Matrix3::from_diagonal(&[information, information, 1e4].into())
    }

    #[test]
    fn two_measurements_of_a_metre_are_worth_one_of_seven_decimetres() {
        let first = Estimate::new(Pose2::new(0.0, 0.0, 0.0), level(1.0), Pose2::default());
        let both = first
            .unwrap()
            .with(Pose2::new(1.0, 0.0, 0.0), level(1.0))
            .unwrap();
        assert!((both.pose.x - 0.5).abs() < 1e-3, "{both:?}");
        assert!((both.covariance[(0, 0)] - 0.5).abs() < 1e-3);
    }

    #[test]
    fn what_a_street_does_not_measure_stays_as_it_was() {
        let known = Estimate::new(Pose2::new(0.0, 0.0, 0.0), level(0.3), Pose2::default());
        let ahead = known.unwrap().carried(Pose2::new(20.0, 0.0, 0.0));
        // Walls along the street measure sideways, and heading.
        let sideways = Matrix3::from_diagonal(&[0.0, 4.0, 1e4].into());
        let fused = ahead.with(Pose2::new(28.0, 0.4, 0.0), sideways).unwrap();
        assert!((fused.pose.x - 20.0).abs() < 0.1, "{fused:?}");
        assert!(fused.pose.y > 0.05);
    }

    #[test]
    fn a_pose_that_contradicts_is_not_believed() {
        let known = Estimate::new(Pose2::default(), level(0.3), Pose2::default()).unwrap();
        assert_eq!(known.with(Pose2::new(3.0, 0.0, 0.0), level(0.3)), None);
        assert_eq!(known.with(Pose2::new(f64::NAN, 0.0, 0.0), level(0.3)), None);
    }
}
