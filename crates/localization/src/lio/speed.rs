//! What wheels say: a velocity in the robot's own frame.

use nalgebra::{SMatrix, Vector3};
use openbench_core::{Pose3, SimTime};

use super::so3::hat;
use super::state::{Covariance, Error, SIZE, State, at};

/// A velocity farther than that from what is expected, in deviations, counts as less sure than it says: wheels slip.
const GATE: f64 = 3.0;
/// Nothing drives faster, and nothing is known better, m/s.
const FASTEST: f64 = 1e4;
const BEST: f64 = 1e-6;
/// A drive goes on in one way for so long, seconds.
const LASTING: f64 = 30.0;

/// A velocity of the frame whose pose is told, such as `base_link`, in that frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed {
    /// When.
    pub stamp: SimTime,
    /// m/s.
    pub velocity: Vector3<f64>,
    /// Its deviations along the frame's axes, m/s.
    pub deviation: Vector3<f64>,
    /// How fast the frame turns about its upright axis, rad/s: skidding wheels know it roughly.
    pub turn: f64,
}

impl Speed {
    /// Whether it can be used.
    pub(super) fn is_sound(&self) -> bool {
        self.velocity.iter().all(|x| x.abs() <= FASTEST)
            && self.deviation.iter().all(|x| (BEST..=FASTEST).contains(x))
            && self.turn.abs() <= FASTEST
    }
}

/// Corrects a state by a velocity; `imu` is the IMU's pose in the frame that it is of, and `gyro` what the gyroscope shows.
pub(super) fn correct(
    state: &mut State,
    covariance: &mut Covariance,
    imu: &Pose3,
    gyro: Vector3<f64>,
    speed: &Speed,
) {
    let lever = imu.inverse().translation.vector;
    let turned = imu.rotation.to_rotation_matrix().into_inner();
    let on_imu = state.rotation.inverse() * state.velocity;
    let expected = turned * (on_imu + (gyro - state.gyro_bias).cross(&lever));
    let residual = speed.velocity - expected;
    let mut jacobian = SMatrix::<f64, 3, SIZE>::zeros();
    let rotation = state.rotation.inverse().to_rotation_matrix().into_inner();
    for (first, block) in [
        (at::ROTATION, turned * hat(on_imu)),
        (at::VELOCITY, turned * rotation),
        (at::GYRO_BIAS, turned * hat(lever)),
    ] {
        jacobian.fixed_view_mut::<3, 3>(0, first).copy_from(&block);
    }
    let known = jacobian * *covariance * jacobian.transpose();
    let mut noise = nalgebra::Matrix3::from_diagonal(&speed.deviation.map(|x| x * x));
    let Some(inverse) = (known + noise).try_inverse() else {
        return;
    };
    let far = (residual.transpose() * inverse * residual)[0] / (GATE * GATE);
    if far > 1.0 {
        noise *= far;
    }
    believe(state, covariance, &jacobian, &residual, &noise);
}

/// Corrects a state by the rule that what drives about does not do so faster than it does, where for so many seconds nothing else has said how fast it goes along a direction in
/// `odom`. Without it, what an accelerometer's bias comes to would grow for ever.
pub(super) fn temper(
    state: &mut State,
    covariance: &mut Covariance,
    direction: &Vector3<f64>,
    typical: f64,
    seconds: f64,
) {
    let mut jacobian = SMatrix::<f64, 1, SIZE>::zeros();
    jacobian
        .fixed_view_mut::<1, 3>(0, at::VELOCITY)
        .copy_from(&direction.transpose());
    let residual = SMatrix::<f64, 1, 1>::new(-direction.dot(&state.velocity));
    // What is said each time adds up to one such measurement in the time for which a drive goes on in one way.
    let noise = SMatrix::<f64, 1, 1>::new(typical * typical * LASTING / seconds.max(1e-3));
    believe(state, covariance, &jacobian, &residual, &noise);
}

/// The Kalman filter's update, in the form that keeps the covariance positive (Joseph's).
fn believe<const M: usize>(
    state: &mut State,
    covariance: &mut Covariance,
    jacobian: &SMatrix<f64, M, SIZE>,
    residual: &SMatrix<f64, M, 1>,
    noise: &SMatrix<f64, M, M>,
) {
    let Some(inverse) = (jacobian * *covariance * jacobian.transpose() + noise).try_inverse()
    else {
        return;
    };
    let gain = *covariance * jacobian.transpose() * inverse;
    let step: Error = gain * residual;
    let left = Covariance::identity() - gain * jacobian;
    let after = left * *covariance * left.transpose() + gain * noise * gain.transpose();
    let there = state.plus(&step);
    if there.is_finite() {
        *state = there;
        *covariance = (after + after.transpose()) * 0.5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::so3::exp;

    fn moving() -> State {
        State {
            rotation: exp(Vector3::new(0.1, -0.2, 1.3)),
            position: Vector3::zeros(),
            velocity: Vector3::new(0.3, 0.1, -0.2),
            gyro_bias: Vector3::new(0.01, 0.0, -0.02),
            accel_bias: Vector3::zeros(),
            gravity: Vector3::z() * -9.8,
            mount_rotation: exp(Vector3::zeros()),
            mount_position: Vector3::zeros(),
            map_tilt: nalgebra::Vector2::zeros(),
        }
    }

    #[test]
    fn a_velocity_that_is_sure_is_taken_over() {
        let imu = Pose3::new(Vector3::new(0.4, -0.1, 0.2), Vector3::new(0.0, 0.3, 0.5));
        let (mut state, mut covariance) = (moving(), Covariance::identity());
        // Turns are known, velocity is not.
        for i in (0..3).chain(at::GYRO_BIAS..at::GYRO_BIAS + 3) {
            covariance[(i, i)] = 1e-12;
        }
        let gyro = Vector3::new(0.2, -0.5, 1.0);
        let velocity = Vector3::new(0.5, 0.0, 0.1);
        let speed = Speed {
            stamp: SimTime::ZERO,
            velocity,
            deviation: Vector3::repeat(1e-4),
            turn: 0.0,
        };
        correct(&mut state, &mut covariance, &imu, gyro, &speed);
        let base = state.rotation * imu.rotation.inverse();
        let rate = base.inverse() * (state.rotation * (gyro - state.gyro_bias));
        // The IMU moves as the frame's origin does and with its turn: v + ω × r.
        let there = base * (velocity + rate.cross(&imu.translation.vector));
        assert!(
            (there - state.velocity).norm() < 1e-3,
            "{there} {}",
            state.velocity
        );
        assert!(covariance[(at::VELOCITY, at::VELOCITY)] < 1e-6);
    }

    #[test]
    fn a_velocity_that_cannot_be_counts_little() {
        let (mut state, mut covariance) = (moving(), Covariance::identity() * 1e-6);
        let velocity = Vector3::new(50.0, 0.0, 0.0);
        let speed = Speed {
            stamp: SimTime::ZERO,
            velocity,
            deviation: Vector3::repeat(1e-2),
            turn: 0.0,
        };
        correct(
            &mut state,
            &mut covariance,
            &Pose3::identity(),
            Vector3::zeros(),
            &speed,
        );
        assert!((state.velocity - moving().velocity).norm() < 0.01);
    }
}
