//! Where the IMU says that it moves to, and where each point of a scan was measured.
//!
//! W. Xu, F. Zhang, *FAST-LIO: A Fast, Robust LiDAR-inertial Odometry Package by Tightly-Coupled Iterated Kalman Filter*, 2021: the discrete model is its
//! equation 2, propagation 4 to 8, and going back in time for each point 9 to 10.

use nalgebra::{Isometry3, Matrix3, SMatrix, Translation3, Vector3};
use openbench_core::SimTime;

use super::so3::{exp, hat, right_jacobian, tangent};
use super::state::{Covariance, SIZE, State, at};

/// What is wrong with an IMU: densities of white noise, and of the random walk of biases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuNoise {
    /// rad/s/√Hz.
    pub gyro: f64,
    /// m/s²/√Hz.
    pub accel: f64,
    /// rad/s²/√Hz.
    pub gyro_walk: f64,
    /// m/s³/√Hz.
    pub accel_walk: f64,
}

/// Where the IMU was, and how it moved on until the next of these.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// When.
    pub stamp: SimTime,
    /// Of the IMU in `odom`.
    pub pose: Isometry3<f64>,
    velocity: Vector3<f64>,
    /// From here on, in the IMU's frame.
    rate: Vector3<f64>,
    /// From here on, in `odom`.
    acceleration: Vector3<f64>,
}

impl Node {
    /// Where the IMU was so many seconds later.
    pub fn later(&self, dt: f64) -> Isometry3<f64> {
        let position =
            self.pose.translation.vector + self.velocity * dt + self.acceleration * (0.5 * dt * dt);
        Isometry3::from_parts(
            Translation3::from(position),
            self.pose.rotation * exp(self.rate * dt),
        )
    }

    /// The same way, seen from `frame`.
    pub fn seen_from(&self, frame: &Isometry3<f64>) -> Passage {
        let pose = frame.inverse() * self.pose;
        let turn = frame.rotation.inverse();
        Passage {
            rotation: pose.rotation.to_rotation_matrix().into_inner(),
            position: pose.translation.vector,
            velocity: turn * self.velocity,
            acceleration: turn * self.acceleration,
            rate: self.rate,
        }
    }
}

/// A way of some hundredths of a second, for the many points that are measured on it.
#[derive(Debug, Clone, Copy)]
pub struct Passage {
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    rate: Vector3<f64>,
}

impl Passage {
    /// Where a point is that is at `point` in the IMU's frame `dt` seconds from here on: [`Node::later`] with the first terms of sine and cosine, which are right to
    /// 10⁻⁸ up to a third of a radian.
    pub fn at(&self, dt: f64, point: Vector3<f64>) -> Vector3<f64> {
        let turn = self.rate * dt;
        let square = turn.norm_squared();
        let sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));
        let cosine = 0.5 * (1.0 - square / 12.0 * (1.0 - square / 30.0));
        let cross = turn.cross(&point);
        let turned = point + cross * sine + turn.cross(&cross) * cosine;
        self.rotation * turned
            + self.position
            + (self.velocity + self.acceleration * (0.5 * dt)) * dt
    }
}

/// Moves a state and its covariance on until `until` by a mean turn rate and a mean specific force; returns how it went.
pub fn propagate(
    state: &mut State,
    covariance: &mut Covariance,
    noise: &ImuNoise,
    from: SimTime,
    until: SimTime,
    gyro: Vector3<f64>,
    accel: Vector3<f64>,
) -> Node {
    let (rate, force) = (gyro - state.gyro_bias, accel - state.accel_bias);
    grow(
        state,
        covariance,
        noise,
        rate,
        force,
        until.since(from).as_secs_f64(),
    );
    advance(state, from, until, gyro, accel)
}

/// Moves a state on: equation 4.
pub fn advance(
    state: &mut State,
    from: SimTime,
    until: SimTime,
    gyro: Vector3<f64>,
    accel: Vector3<f64>,
) -> Node {
    let dt = until.since(from).as_secs_f64();
    let (rate, force) = (gyro - state.gyro_bias, accel - state.accel_bias);
    let rotation = state.rotation;
    // The specific force is measured while the IMU turns: its mean direction is that of half the way.
    let halfway = rotation * exp(rate * (0.5 * dt));
    let acceleration = halfway * force + state.gravity;
    let node = Node {
        stamp: from,
        pose: Isometry3::from_parts(state.position.into(), rotation),
        velocity: state.velocity,
        rate,
        acceleration,
    };
    state.position += state.velocity * dt + acceleration * (0.5 * dt * dt);
    state.velocity += acceleration * dt;
    state.rotation = rotation * exp(rate * dt);
    node
}

/// The covariance after a step: equation 8, with the Jacobians of equation 7.
fn grow(
    state: &State,
    covariance: &mut Covariance,
    noise: &ImuNoise,
    rate: Vector3<f64>,
    force: Vector3<f64>,
    dt: f64,
) {
    let identity = Matrix3::<f64>::identity();
    let rotation = state.rotation.to_rotation_matrix().into_inner();
    let mut step = Covariance::identity();
    let mut set = |row: usize, column: usize, block: Matrix3<f64>| {
        step.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    };
    let turned = rotation * hat(force);
    set(
        at::ROTATION,
        at::ROTATION,
        exp(-rate * dt).to_rotation_matrix().into_inner(),
    );
    set(at::ROTATION, at::GYRO_BIAS, -right_jacobian(rate * dt) * dt);
    set(at::POSITION, at::VELOCITY, identity * dt);
    set(at::POSITION, at::ROTATION, -turned * (0.5 * dt * dt));
    set(at::POSITION, at::ACCEL_BIAS, -rotation * (0.5 * dt * dt));
    set(at::VELOCITY, at::ROTATION, -turned * dt);
    set(at::VELOCITY, at::ACCEL_BIAS, -rotation * dt);
    // Gravity turned by a small vector t is g + t x g.
    let tilt: SMatrix<f64, 3, 2> = -hat(state.gravity) * tangent(state.gravity);
    step.fixed_view_mut::<3, 2>(at::VELOCITY, at::GRAVITY)
        .copy_from(&(tilt * dt));
    step.fixed_view_mut::<3, 2>(at::POSITION, at::GRAVITY)
        .copy_from(&(tilt * (0.5 * dt * dt)));
    *covariance = step * *covariance * step.transpose();
    for (first, density) in [
        (at::ROTATION, noise.gyro),
        (at::VELOCITY, noise.accel),
        (at::GYRO_BIAS, noise.gyro_walk),
        (at::ACCEL_BIAS, noise.accel_walk),
    ] {
        for i in first..first + 3 {
            covariance[(i, i)] += density * density * dt;
        }
    }
    debug_assert_eq!(covariance.nrows(), SIZE);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_passage_goes_where_its_node_goes() {
        let node = Node {
            stamp: SimTime::ZERO,
            pose: Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -1.0, 0.2)),
            velocity: Vector3::new(1.0, -0.5, 0.1),
            rate: Vector3::new(3.0, -8.0, 12.0),
            acceleration: Vector3::new(0.5, 2.0, -1.0),
        };
        let frame = Isometry3::new(Vector3::new(0.5, 1.0, -3.0), Vector3::new(-0.4, 0.1, 2.0));
        let (passage, point) = (node.seen_from(&frame), Vector3::new(10.0, -20.0, 3.0));
        for dt in [0.0, 0.005, 0.02] {
            let there = frame.inverse() * (node.later(dt) * nalgebra::Point3::from(point));
            assert!((passage.at(dt, point) - there.coords).norm() < 1e-6, "{dt}");
        }
    }
}
