//! The first state: gravity from what the accelerometer shows, and the gyroscope's bias where the robot stands.

use std::time::Duration;

use nalgebra::{UnitQuaternion, Vector2, Vector3};
use openbench_core::{ImuSample, SimTime};

use super::Settings;
use super::drift::UPRIGHT;
use super::state::{Covariance, State, at};

/// The start is taken from so long a time, and from so many samples at least and at most.
const TIME: Duration = Duration::from_secs(1);
const SAMPLES: [usize; 2] = [20, 10_000];
/// The first part of it may be the robot being put down: rest is what the other three quarters show.
const PUT_DOWN: usize = 4;
/// At rest turn rates and specific forces vary no more than that: rad/s and m/s².
const AT_REST: [f64; 2] = [0.01, 0.1];
/// Faster than that nothing of this kind moves, m/s.
const FASTEST: f64 = 3.0;

/// The first samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Start {
    samples: Vec<ImuSample>,
}

/// What a robot begins with.
#[derive(Debug)]
pub(super) struct First {
    pub(super) state: State,
    pub(super) covariance: Covariance,
    /// Since when it has stood still; `None` in motion.
    pub(super) at_rest: Option<SimTime>,
}

impl Start {
    /// Takes in a sample; the first state once there are enough.
    pub(super) fn take(&mut self, sample: &ImuSample, settings: &Settings) -> Option<First> {
        self.samples.push(*sample);
        let long = sample.stamp.since(self.samples[0].stamp) >= TIME;
        if !(long && self.samples.len() >= SAMPLES[0] || self.samples.len() >= SAMPLES[1]) {
            return None;
        }
        let samples = std::mem::take(&mut self.samples);
        let settled = &samples[samples.len() / PUT_DOWN..];
        let at_rest = deviation(settled, |s| s.gyro) < AT_REST[0]
            && deviation(settled, |s| s.accel) < AT_REST[1];
        let counted = if at_rest { settled } else { &samples[..] };
        let (state, covariance) = first(
            mean(counted, |s| s.gyro),
            mean(counted, |s| s.accel),
            at_rest,
            settings,
        );
        Some(First {
            state,
            covariance,
            at_rest: at_rest.then(|| settled[0].stamp),
        })
    }
}

fn mean(samples: &[ImuSample], part: impl Fn(&ImuSample) -> [f64; 3]) -> Vector3<f64> {
    samples
        .iter()
        .map(|sample| Vector3::from(part(sample)))
        .sum::<Vector3<f64>>()
        / samples.len() as f64
}

fn deviation(samples: &[ImuSample], part: impl Fn(&ImuSample) -> [f64; 3]) -> f64 {
    let mean = mean(samples, &part);
    let squares = samples
        .iter()
        .map(|sample| (Vector3::from(part(sample)) - mean).norm_squared());
    (squares.sum::<f64>() / samples.len() as f64).sqrt()
}

/// The state with the heading 0 of the frame whose pose is told, and its origin there.
fn first(
    gyro: Vector3<f64>,
    accel: Vector3<f64>,
    at_rest: bool,
    settings: &Settings,
) -> (State, Covariance) {
    let up = UnitQuaternion::rotation_between(&accel, &Vector3::z()).unwrap_or_default();
    // `up` turns the IMU's frame upright about a level axis; the heading is taken out of it.
    let ahead = up * (settings.imu.rotation.inverse() * Vector3::x());
    let heading =
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -libm::atan2(ahead.y, ahead.x));
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
        map_tilt: Vector2::zeros(),
    };
    let mount = if settings.estimate_lidar {
        [0.02, 0.02]
    } else {
        [1e-6, 1e-6]
    };
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
        (at::MAP_TILT, UPRIGHT, 2),
    ];
    let mut covariance = Covariance::zeros();
    for (first, deviation, size) in deviations {
        (first..first + size).for_each(|i| covariance[(i, i)] = deviation * deviation);
    }
    (state, covariance)
}
