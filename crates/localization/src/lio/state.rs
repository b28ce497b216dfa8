//! What the filter estimates, on its manifold.
//!
//! W. Xu, Y. Cai, D. He, J. Lin, F. Zhang, *FAST-LIO2: Fast Direct LiDAR-Inertial Odometry*, 2021,
//! equation 1: rotation, position and velocity of the IMU, biases of gyroscope and accelerometer,
//! gravity, and the LiDAR's pose on the IMU. Gravity keeps its length: two dimensions. Two more
//! dimensions of our own are the tilt of the map.

use nalgebra::{Isometry3, Matrix3, SMatrix, SVector, UnitQuaternion, Vector2, Vector3};

use crate::so3::{exp, inverse_right_jacobian, log, tangent};

/// Dimensions of an error.
pub(crate) const SIZE: usize = 25;
/// An error of a state: rotations as vectors, in the order of [`at`].
pub(crate) type Error = SVector<f64, SIZE>;
/// Covariance of an error.
pub type Covariance = SMatrix<f64, SIZE, SIZE>;

/// Where in an error each part begins.
pub(crate) mod at {
    /// Rotation of the IMU in its own frame, radians.
    pub(crate) const ROTATION: usize = 0;
    /// Position of the IMU, metres.
    pub(crate) const POSITION: usize = 3;
    /// Velocity of the IMU, m/s.
    pub(crate) const VELOCITY: usize = 6;
    /// Bias of the gyroscope, rad/s.
    pub(crate) const GYRO_BIAS: usize = 9;
    /// Bias of the accelerometer, m/s².
    pub(crate) const ACCEL_BIAS: usize = 12;
    /// Direction of gravity, radians: two components.
    pub(crate) const GRAVITY: usize = 15;
    /// Rotation of the LiDAR on the IMU, in the LiDAR's frame, radians.
    pub(crate) const MOUNT_ROTATION: usize = 17;
    /// Position of the LiDAR on the IMU, metres.
    pub(crate) const MOUNT_POSITION: usize = 20;
    /// Tilt of the map about x and y of `odom`, radians: two components.
    pub(crate) const MAP_TILT: usize = 23;
}

/// A state.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Rotation from the IMU's frame to `odom`.
    pub rotation: UnitQuaternion<f64>,
    /// Position of the IMU in `odom`, metres.
    pub position: Vector3<f64>,
    /// Velocity of the IMU in `odom`, m/s.
    pub(crate) velocity: Vector3<f64>,
    /// Bias of the gyroscope, rad/s.
    pub(crate) gyro_bias: Vector3<f64>,
    /// Bias of the accelerometer, m/s².
    pub(crate) accel_bias: Vector3<f64>,
    /// Gravity in `odom`, m/s².
    pub(crate) gravity: Vector3<f64>,
    /// Rotation from the LiDAR's frame to the IMU's.
    pub(crate) mount_rotation: UnitQuaternion<f64>,
    /// Position of the LiDAR in the IMU's frame, metres.
    pub(crate) mount_position: Vector3<f64>,
    /// Tilt of the map in view, turned about the IMU: a small rotation about x and y of `odom`. The
    /// map is seen as from exp(tilt) times `rotation`.
    pub(crate) map_tilt: Vector2<f64>,
}

impl State {
    /// The state of an IMU that rests at a pose in `odom`, without biases, with the LiDAR's frame
    /// on its own; `gravity` is in m/s².
    pub fn at_rest(imu: &Isometry3<f64>, gravity: f64) -> Self {
        Self {
            rotation: imu.rotation,
            position: imu.translation.vector,
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            gravity: Vector3::z() * -gravity,
            mount_rotation: UnitQuaternion::identity(),
            mount_position: Vector3::zeros(),
            map_tilt: Vector2::zeros(),
        }
    }

    /// This state, changed by an error: ⊞.
    #[must_use]
    pub(crate) fn plus(&self, error: &Error) -> Self {
        let part = |first: usize| -> Vector3<f64> { error.fixed_rows::<3>(first).into_owned() };
        // Along directions at right angles to gravity, whose length stays.
        let tilt = tangent(self.gravity) * error.fixed_rows::<2>(at::GRAVITY);
        Self {
            rotation: self.rotation * exp(part(at::ROTATION)),
            position: self.position + part(at::POSITION),
            velocity: self.velocity + part(at::VELOCITY),
            gyro_bias: self.gyro_bias + part(at::GYRO_BIAS),
            accel_bias: self.accel_bias + part(at::ACCEL_BIAS),
            gravity: exp(tilt) * self.gravity,
            mount_rotation: self.mount_rotation * exp(part(at::MOUNT_ROTATION)),
            mount_position: self.mount_position + part(at::MOUNT_POSITION),
            map_tilt: self.map_tilt + error.fixed_rows::<2>(at::MAP_TILT),
        }
    }

    /// The error that leads from `other` to this state: ⊟.
    pub(crate) fn minus(&self, other: &Self) -> Error {
        let mut error = Error::zeros();
        let mut set =
            |first: usize, part: Vector3<f64>| error.fixed_rows_mut::<3>(first).copy_from(&part);
        set(at::ROTATION, log(other.rotation.inverse() * self.rotation));
        set(at::POSITION, self.position - other.position);
        set(at::VELOCITY, self.velocity - other.velocity);
        set(at::GYRO_BIAS, self.gyro_bias - other.gyro_bias);
        set(at::ACCEL_BIAS, self.accel_bias - other.accel_bias);
        set(
            at::MOUNT_ROTATION,
            log(other.mount_rotation.inverse() * self.mount_rotation),
        );
        set(
            at::MOUNT_POSITION,
            self.mount_position - other.mount_position,
        );
        let turned = UnitQuaternion::rotation_between(&other.gravity, &self.gravity);
        let tilt = tangent(other.gravity).transpose() * turned.map_or_else(Vector3::zeros, log);
        error.fixed_rows_mut::<2>(at::GRAVITY).copy_from(&tilt);
        error
            .fixed_rows_mut::<2>(at::MAP_TILT)
            .copy_from(&(self.map_tilt - other.map_tilt));
        error
    }

    /// Pose of the IMU in `odom`.
    pub(crate) fn imu_pose(&self) -> Isometry3<f64> {
        Isometry3::from_parts(self.position.into(), self.rotation)
    }

    /// Pose of the LiDAR in the IMU's frame.
    pub(crate) fn mount(&self) -> Isometry3<f64> {
        Isometry3::from_parts(self.mount_position.into(), self.mount_rotation)
    }

    /// Pose of the LiDAR in `odom`.
    pub(crate) fn lidar_pose(&self) -> Isometry3<f64> {
        self.imu_pose() * self.mount()
    }

    /// The state relative to the map as that is tilted: what a scan observes.
    #[must_use]
    pub(crate) fn in_map(&self) -> Self {
        let tilt = exp(self.map_tilt.push(0.0));
        Self {
            rotation: tilt * self.rotation,
            map_tilt: Vector2::zeros(),
            ..self.clone()
        }
    }

    /// Of a state [in the map](Self::in_map): how what a scan observes changes with the state. Of
    /// the `N` rows six are the IMU's pose in the map, and six more the LiDAR's on the IMU.
    pub(super) fn in_map_jacobian<const N: usize>(&self) -> SMatrix<f64, N, SIZE> {
        let mut jacobian = SMatrix::<f64, N, SIZE>::zeros();
        let observed = [
            at::ROTATION,
            at::POSITION,
            at::MOUNT_ROTATION,
            at::MOUNT_POSITION,
        ];
        let columns = observed.into_iter().flat_map(|first| first..first + 3);
        for (row, column) in columns.take(N).enumerate() {
            jacobian[(row, column)] = 1.0;
        }
        // A tilt is about axes of `odom`; the rotation's error is in the IMU's frame.
        let upright = self.rotation.inverse().to_rotation_matrix();
        let level_axes = upright.matrix().fixed_columns::<2>(0);
        jacobian
            .fixed_view_mut::<3, 2>(0, at::MAP_TILT)
            .copy_from(&level_axes);
        jacobian
    }

    /// Whether it contains neither NaN nor infinity.
    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [
            self.position,
            self.velocity,
            self.gyro_bias,
            self.accel_bias,
            self.gravity,
            self.mount_position,
        ];
        let rotations = [self.rotation, self.mount_rotation];
        vectors
            .iter()
            .flat_map(|v| v.iter())
            .chain(rotations.iter().flat_map(|q| q.coords.iter()))
            .chain(self.map_tilt.iter())
            .all(|x| x.is_finite())
    }

    /// Jacobian of an error about another state by an error about this one; `away` is the error
    /// from the other to this. It is the inverse of the Jacobian by which FAST-LIO's equation 16
    /// projects the prior.
    pub(super) fn projection(away: &Error) -> Covariance {
        let mut projection = Covariance::identity();
        for first in [at::ROTATION, at::MOUNT_ROTATION] {
            let part: Vector3<f64> = away.fixed_rows::<3>(first).into_owned();
            let block: Matrix3<f64> = inverse_right_jacobian(part);
            projection
                .fixed_view_mut::<3, 3>(first, first)
                .copy_from(&block);
        }
        projection
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn state(numbers: &[f64]) -> State {
        let part = |i: usize| Vector3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
        State {
            rotation: exp(part(0)),
            position: part(3),
            velocity: part(6),
            gyro_bias: part(9),
            accel_bias: part(12),
            gravity: Vector3::new(numbers[15], numbers[16], -9.8),
            mount_rotation: exp(part(17)),
            mount_position: part(20),
            map_tilt: Vector2::new(numbers[23], numbers[24]),
        }
    }

    proptest! {
        #[test]
        fn what_a_scan_observes_changes_as_its_jacobian_says(
            numbers in proptest::collection::vec(-1.0_f64..1.0, SIZE),
            step in proptest::collection::vec(-1e-4_f64..1e-4, SIZE),
        ) {
            let mut state = state(&numbers);
            state.map_tilt *= 0.01;
            let step = Error::from_vec(step);
            let in_map = state.in_map();
            let moved = state.plus(&step).in_map().minus(&in_map);
            let expected = in_map.in_map_jacobian::<12>() * step;
            let pose = moved.fixed_rows::<6>(at::ROTATION) - expected.fixed_rows::<6>(0);
            let mount = moved.fixed_rows::<6>(at::MOUNT_ROTATION) - expected.fixed_rows::<6>(6);
            prop_assert!(pose.norm() < 4e-6);
            prop_assert!(mount.norm() < 1e-9);
        }

        #[test]
        fn plus_and_minus_are_inverse(
            numbers in proptest::collection::vec(-1.0_f64..1.0, SIZE),
            error in proptest::collection::vec(-0.9_f64..0.9, SIZE),
        ) {
            let (state, error) = (state(&numbers), Error::from_vec(error));
            let there = state.plus(&error);
            prop_assert!((there.minus(&state) - error).norm() < 1e-9);
            prop_assert!(state.minus(&state).norm() < 1e-12);
        }
    }
}
