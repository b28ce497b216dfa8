//! Kalman updates by what is known of the velocity.

use std::time::Duration;

use nalgebra::{Matrix3, SMatrix, Vector3};
use openbench_core::Pose3;

use super::belief::Belief;
use super::speed::Speed;
use super::state::{Covariance, Error, SIZE, at};
use crate::so3::hat;

/// An innovation of more standard deviations than this inflates the measurement's noise: wheels
/// slip.
const GATE: f64 = 3.0;
/// A robot keeps its velocity for about this long, seconds.
const CORRELATION_TIME_S: f64 = 30.0;
/// No shorter time counts as one without measurements, seconds.
const MIN_TIME_S: f64 = 1e-3;

/// Corrects a belief by a velocity of the robot's frame. `imu` is the IMU's pose in that frame, and
/// `gyro` the gyroscope's reading, rad/s.
pub(super) fn apply_speed(belief: &mut Belief, imu: &Pose3, gyro: Vector3<f64>, speed: &Speed) {
    let state = &belief.state;
    // The origin of the robot's frame as seen from the IMU: in a turn it moves along another arc.
    let lever = imu.inverse().translation.vector;
    let from_imu = imu.rotation.to_rotation_matrix().into_inner();
    let velocity_of_imu = state.rotation.inverse() * state.velocity;
    let expected = from_imu * (velocity_of_imu + (gyro - state.gyro_bias).cross(&lever));
    let residual = speed.velocity - expected;
    let into_imu = state.rotation.inverse().to_rotation_matrix().into_inner();
    // By R exp(δ): Rᵀ v becomes Rᵀ v + (Rᵀ v) × δ. By a larger bias b: -b × lever = lever × b.
    let mut jacobian = SMatrix::<f64, 3, SIZE>::zeros();
    for (first, block) in [
        (at::ROTATION, from_imu * hat(velocity_of_imu)),
        (at::VELOCITY, from_imu * into_imu),
        (at::GYRO_BIAS, from_imu * hat(lever)),
    ] {
        jacobian.fixed_view_mut::<3, 3>(0, first).copy_from(&block);
    }
    let predicted = jacobian * belief.covariance * jacobian.transpose();
    let mut noise = Matrix3::from_diagonal(&speed.deviation.map(|x| x * x));
    let Some(inverse) = (predicted + noise).try_inverse() else {
        return;
    };
    let excess = (residual.transpose() * inverse * residual)[0] / (GATE * GATE);
    if excess > 1.0 {
        // Rejected measurements would leave a filter alone that is wrong itself; with more noise
        // they still pull it.
        noise *= excess;
    }
    update(belief, &jacobian, &residual, &noise);
}

/// Corrects a belief by the rule that a robot does not drive faster than it usually does.
///
/// It applies along a direction in `odom` of which no other measurement was made for `unmeasured`;
/// `typical_speed_m_s` is in m/s. Without this rule the velocity error that an accelerometer's bias
/// causes would grow without bound.
pub(super) fn limit_velocity(
    belief: &mut Belief,
    direction: &Vector3<f64>,
    typical_speed_m_s: f64,
    unmeasured: Duration,
) {
    let mut jacobian = SMatrix::<f64, 1, SIZE>::zeros();
    jacobian
        .fixed_view_mut::<1, 3>(0, at::VELOCITY)
        .copy_from(&direction.transpose());
    let residual = SMatrix::<f64, 1, 1>::new(-direction.dot(&belief.state.velocity));
    // All updates of one correlation time together count as one measurement.
    let seconds = unmeasured.as_secs_f64().max(MIN_TIME_S);
    let variance = typical_speed_m_s * typical_speed_m_s * CORRELATION_TIME_S / seconds;
    let noise = SMatrix::<f64, 1, 1>::new(variance);
    update(belief, &jacobian, &residual, &noise);
}

/// The Kalman filter's update, in the form that keeps the covariance positive (Joseph's).
fn update<const M: usize>(
    belief: &mut Belief,
    jacobian: &SMatrix<f64, M, SIZE>,
    residual: &SMatrix<f64, M, 1>,
    noise: &SMatrix<f64, M, M>,
) {
    let before = belief.covariance;
    let innovation = jacobian * before * jacobian.transpose() + noise;
    let Some(inverse) = innovation.try_inverse() else {
        return;
    };
    let gain = before * jacobian.transpose() * inverse;
    let step: Error = gain * residual;
    let rest = Covariance::identity() - gain * jacobian;
    let after = rest * before * rest.transpose() + gain * noise * gain.transpose();
    let state = belief.state.plus(&step);
    // A step that is not finite leaves the belief as it was.
    if state.is_finite() {
        belief.state = state;
        belief.covariance = (after + after.transpose()) * 0.5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lio::state::State;
    use nalgebra::UnitQuaternion;
    use openbench_core::SimTime;

    fn moving(covariance: Covariance) -> Belief {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, -0.2, 1.3));
        let state = State {
            velocity: Vector3::new(0.3, 0.1, -0.2),
            gyro_bias: Vector3::new(0.01, 0.0, -0.02),
            ..State::at_rest(&Pose3::from_parts(Vector3::zeros().into(), rotation), 9.8)
        };
        Belief {
            stamp: SimTime::ZERO,
            state,
            covariance,
        }
    }

    fn speed(velocity: Vector3<f64>, deviation: f64) -> Speed {
        let deviation = Vector3::repeat(deviation);
        Speed {
            stamp: SimTime::ZERO,
            velocity,
            deviation,
            turn: 0.0,
        }
    }

    #[test]
    fn a_certain_velocity_is_adopted() {
        let imu = Pose3::new(Vector3::new(0.4, -0.1, 0.2), Vector3::new(0.0, 0.3, 0.5));
        let mut belief = moving(Covariance::identity());
        // Turns are known, the velocity is not.
        for i in (0..3).chain(at::GYRO_BIAS..at::GYRO_BIAS + 3) {
            belief.covariance[(i, i)] = 1e-12;
        }
        let gyro = Vector3::new(0.2, -0.5, 1.0);
        let velocity = Vector3::new(0.5, 0.0, 0.1);
        apply_speed(&mut belief, &imu, gyro, &speed(velocity, 1e-4));
        let state = &belief.state;
        let base = state.rotation * imu.rotation.inverse();
        let rate = base.inverse() * (state.rotation * (gyro - state.gyro_bias));
        // The IMU moves with the frame's origin and with its turn: v + ω × r.
        let expected = base * (velocity + rate.cross(&imu.translation.vector));
        assert!(
            (expected - state.velocity).norm() < 1e-3,
            "{expected} {}",
            state.velocity
        );
        assert!(belief.covariance[(at::VELOCITY, at::VELOCITY)] < 1e-6);
    }

    #[test]
    fn an_impossible_velocity_counts_little() {
        let mut belief = moving(Covariance::identity() * 1e-6);
        let before = belief.state.velocity;
        let impossible = speed(Vector3::new(50.0, 0.0, 0.0), 1e-2);
        apply_speed(
            &mut belief,
            &Pose3::identity(),
            Vector3::zeros(),
            &impossible,
        );
        assert!((belief.state.velocity - before).norm() < 0.01);
    }
}
