//! The first state: gravity from what the accelerometer shows, and the gyroscope's bias where the robot stands.

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::ImuSample;

use super::Settings;
use super::state::{Covariance, State, at};

/// Samples that the start is taken from: a second at 100 Hz.
const SAMPLES: usize = 100;
/// At rest turn rates and specific forces vary no more than that: rad/s and m/s².
const AT_REST: [f64; 2] = [0.01, 0.1];
/// Faster than that nothing of this kind moves, m/s.
const FASTEST: f64 = 3.0;

/// Sums over the first samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Start {
    samples: Vec<[Vector3<f64>; 2]>,
}

impl Start {
    /// Takes in a sample; the first state once there are enough.
    pub(super) fn take(&mut self, sample: &ImuSample, settings: &Settings) -> Option<(State, Covariance)> {
        self.samples.push([sample.gyro.into(), sample.accel.into()]);
        if self.samples.len() < SAMPLES {
            return None;
        }
        let [gyro, accel] = [0, 1].map(|i| self.mean(i));
        let at_rest = (0..2).all(|i| self.deviation(i, [gyro, accel][i]) < AT_REST[i]);
        self.samples = Vec::new();
        Some(first(gyro, accel, at_rest, settings))
    }

    fn mean(&self, i: usize) -> Vector3<f64> {
        self.samples.iter().map(|sample| sample[i]).sum::<Vector3<f64>>() / self.samples.len() as f64
    }

    fn deviation(&self, i: usize, mean: Vector3<f64>) -> f64 {
        let squares: f64 = self.samples.iter().map(|sample| (sample[i] - mean).norm_squared()).sum();
        (squares / self.samples.len() as f64).sqrt()
    }
}

/// The state with the heading 0 of the frame whose pose is told, and its origin there.
fn first(gyro: Vector3<f64>, accel: Vector3<f64>, at_rest: bool, settings: &Settings) -> (State, Covariance) {
    let up = UnitQuaternion::rotation_between(&accel, &Vector3::z()).unwrap_or_default();
    // `up` turns the IMU's frame upright about a level axis; the heading is taken out of it.
    let ahead = up * (settings.imu.rotation.inverse() * Vector3::x());
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -libm::atan2(ahead.y, ahead.x));
    let rotation = heading * up;
    let body = rotation * settings.imu.rotation.inverse();
    let state = State {
        rotation,
        position: body * settings.imu.translation.vector,
        velocity: Vector3::zeros(),
        gyro_bias: if at_rest { gyro } else { Vector3::zeros() },
        accel_bias: Vector3::zeros(),
        gravity: Vector3::z() * -accel.norm(),
        mount_rotation: settings.lidar.rotation,
        mount_position: settings.lidar.translation.vector,
    };
    let mount = if settings.estimate_lidar { [0.02, 0.02] } else { [1e-6, 1e-6] };
    let moving = |rest: f64, motion: f64| if at_rest { rest } else { motion };
    let deviations = [
        (at::ROTATION, moving(1e-4, 1e-2), 3),
        (at::POSITION, 1e-4, 3),
        (at::VELOCITY, moving(1e-3, FASTEST), 3),
        (at::GYRO_BIAS, moving(1e-3, 1e-2), 3),
        (at::ACCEL_BIAS, 0.05, 3),
        (at::GRAVITY, moving(5e-3, 0.1), 2),
        (at::MOUNT_ROTATION, mount[0], 3),
        (at::MOUNT_POSITION, mount[1], 3),
    ];
    let mut covariance = Covariance::zeros();
    for (first, deviation, size) in deviations {
        (first..first + size).for_each(|i| covariance[(i, i)] = deviation * deviation);
    }
    (state, covariance)
}
