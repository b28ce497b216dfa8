//! Motion predicted from the IMU, and where each point of a scan was measured.
//!
//! W. Xu, F. Zhang, *FAST-LIO: A Fast, Robust LiDAR-inertial Odometry Package by Tightly-Coupled
//! Iterated Kalman Filter*, 2021: the discrete model is its equation 2, forward propagation 4 to 8,
//! backward propagation 9 to 10.

use nalgebra::{Isometry3, Matrix3, SMatrix, Vector3};
use openbench_core::SimTime;

use super::belief::Belief;
use super::noise::ImuNoise;
use super::state::{Covariance, State, at};
use crate::so3::{exp, hat, right_jacobian, tangent};

/// Mean readings of an IMU over a step, and how noisy they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    /// rad/s.
    pub(super) gyro: Vector3<f64>,
    /// m/s².
    pub(super) accel: Vector3<f64>,
    pub(super) noise: ImuNoise,
}

/// Pose and velocity of the IMU at an instant, and its motion until the next node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) stamp: SimTime,
    /// Of the IMU in `odom`.
    pose: Isometry3<f64>,
    /// In `odom`, m/s.
    velocity: Vector3<f64>,
    /// In the IMU's frame, rad/s.
    rate: Vector3<f64>,
    /// In `odom`, m/s².
    acceleration: Vector3<f64>,
}

impl Node {
    /// The same motion relative to `frame`, a pose in `odom`.
    pub(super) fn relative_to(&self, frame: &Isometry3<f64>) -> RelativeMotion {
        let pose = frame.inverse() * self.pose;
        let into_frame = frame.rotation.inverse();
        RelativeMotion {
            rotation: pose.rotation.to_rotation_matrix().into_inner(),
            position: pose.translation.vector,
            velocity: into_frame * self.velocity,
            acceleration: into_frame * self.acceleration,
            rate: self.rate,
        }
    }
}

/// Motion of the IMU after a node, prepared for the many points that are measured during it.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeMotion {
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    rate: Vector3<f64>,
}

impl RelativeMotion {
    /// Where a point is that is at `point` in the IMU's frame `dt` seconds after the node.
    ///
    /// The rotation is the exponential with the first terms of sine and cosine, which are right to
    /// 10⁻⁸ up to a third of a radian.
    pub(super) fn transform(&self, dt: f64, point: Vector3<f64>) -> Vector3<f64> {
        let turn = self.rate * dt;
        let square = turn.norm_squared();
        // sin θ / θ and (1 - cos θ) / θ².
        let sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));
        let cosine = 0.5 * (1.0 - square / 12.0 * (1.0 - square / 30.0));
        let cross = turn.cross(&point);
        let turned = point + cross * sine + turn.cross(&cross) * cosine;
        let shift = (self.velocity + self.acceleration * (0.5 * dt)) * dt;
        self.rotation * turned + self.position + shift
    }
}

/// Predicts a belief at `until`: equations 4 and 8. Returns the motion.
pub(super) fn propagate(belief: &mut Belief, reading: &Reading, until: SimTime) -> Node {
    let from = belief.stamp;
    let dt = until.since(from).as_secs_f64();
    propagate_covariance(belief, reading, dt);
    belief.stamp = until;
    propagate_state(&mut belief.state, from, dt, reading.gyro, reading.accel)
}

/// Predicts a state `dt` seconds later: equation 4. `gyro` and `accel` are mean readings, rad/s and
/// m/s². Returns the motion.
pub(super) fn propagate_state(
    state: &mut State,
    from: SimTime,
    dt: f64,
    gyro: Vector3<f64>,
    accel: Vector3<f64>,
) -> Node {
    let rate = gyro - state.gyro_bias;
    let force = accel - state.accel_bias;
    let rotation = state.rotation;
    // The IMU turns while it measures the force, whose mean direction is that at half the step.
    let halfway = rotation * exp(rate * (0.5 * dt));
    let acceleration = halfway * force + state.gravity;
    let pose = Isometry3::from_parts(state.position.into(), rotation);
    let node = Node {
        stamp: from,
        pose,
        velocity: state.velocity,
        rate,
        acceleration,
    };
    state.position += state.velocity * dt + acceleration * (0.5 * dt * dt);
    state.velocity += acceleration * dt;
    state.rotation = rotation * exp(rate * dt);
    node
}

/// Predicts the covariance `dt` seconds later: equation 8, with the Jacobians of equation 7.
fn propagate_covariance(belief: &mut Belief, reading: &Reading, dt: f64) {
    let jacobian = transition_jacobian(&belief.state, reading, dt);
    belief.covariance = jacobian * belief.covariance * jacobian.transpose();
    let noise = &reading.noise;
    for (first, density) in [
        (at::ROTATION, noise.gyro),
        (at::VELOCITY, noise.accel),
        (at::GYRO_BIAS, noise.gyro_walk),
        (at::ACCEL_BIAS, noise.accel_walk),
    ] {
        for i in first..first + 3 {
            // White noise of density σ adds σ² dt to the variance of its integral. As in F_w of
            // equation 7 the position gets its part by way of the velocity.
            belief.covariance[(i, i)] += density * density * dt;
        }
    }
}

/// How the error after a step changes with the one before: F of equation 7.
fn transition_jacobian(state: &State, reading: &Reading, dt: f64) -> Covariance {
    let rate = reading.gyro - state.gyro_bias;
    let force = reading.accel - state.accel_bias;
    let identity = Matrix3::<f64>::identity();
    let rotation = state.rotation.to_rotation_matrix().into_inner();
    let turned_force = rotation * hat(force);
    // Gravity turned by a small vector t is g + t × g.
    let tilt: SMatrix<f64, 3, 2> = -hat(state.gravity) * tangent(state.gravity);
    let turned_back = exp(-rate * dt).to_rotation_matrix().into_inner();
    let mut jacobian = Covariance::identity();
    for (row, column, block) in [
        (at::ROTATION, at::ROTATION, turned_back),
        (at::ROTATION, at::GYRO_BIAS, -right_jacobian(rate * dt) * dt),
        (at::POSITION, at::VELOCITY, identity * dt),
        (at::POSITION, at::ROTATION, -turned_force * (0.5 * dt * dt)),
        (at::POSITION, at::ACCEL_BIAS, -rotation * (0.5 * dt * dt)),
        (at::VELOCITY, at::ROTATION, -turned_force * dt),
        (at::VELOCITY, at::ACCEL_BIAS, -rotation * dt),
    ] {
        jacobian
            .fixed_view_mut::<3, 3>(row, column)
            .copy_from(&block);
    }
    let velocity = tilt * dt;
    let position = tilt * (0.5 * dt * dt);
    jacobian
        .fixed_view_mut::<3, 2>(at::VELOCITY, at::GRAVITY)
        .copy_from(&velocity);
    jacobian
        .fixed_view_mut::<3, 2>(at::POSITION, at::GRAVITY)
        .copy_from(&position);
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;

    /// Pose of the IMU `dt` seconds after a node.
    fn later(node: &Node, dt: f64) -> Isometry3<f64> {
        let shift = node.velocity * dt + node.acceleration * (0.5 * dt * dt);
        let position = node.pose.translation.vector + shift;
        let rotation = node.pose.rotation * exp(node.rate * dt);
        Isometry3::from_parts(Translation3::from(position), rotation)
    }

    #[test]
    fn relative_motion_is_that_of_its_node() {
        let node = Node {
            stamp: SimTime::ZERO,
            pose: Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -1.0, 0.2)),
            velocity: Vector3::new(1.0, -0.5, 0.1),
            rate: Vector3::new(3.0, -8.0, 12.0),
            acceleration: Vector3::new(0.5, 2.0, -1.0),
        };
        let frame = Isometry3::new(Vector3::new(0.5, 1.0, -3.0), Vector3::new(-0.4, 0.1, 2.0));
        let motion = node.relative_to(&frame);
        let point = Vector3::new(10.0, -20.0, 3.0);
        for dt in [0.0, 0.005, 0.02] {
            let expected = frame.inverse() * (later(&node, dt) * nalgebra::Point3::from(point));
            assert!(
                (motion.transform(dt, point) - expected.coords).norm() < 1e-6,
                "{dt}"
            );
        }
    }
}
