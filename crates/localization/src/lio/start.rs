//! The first state: gravity from the accelerometer, and the gyroscope's bias if the robot rests.

use std::time::Duration;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use openbench_core::{ImuSample, SimTime};

use super::belief::Belief;
use super::drift::UPRIGHT_RAD;
use super::settings::Settings;
use super::state::{Covariance, State, at};

/// The start is estimated from samples of this time,
const DURATION: Duration = Duration::from_secs(1);
/// and from at least this many,
const MIN_SAMPLES: usize = 20;
/// and at most this many.
const MAX_SAMPLES: usize = 10_000;
/// The first sample in this many may be of the robot being put down: the rest of them shows whether
/// it rests.
const PUT_DOWN: usize = 4;
/// At rest, turn rates vary by less than this (one standard deviation), rad/s,
const MAX_REST_GYRO_RAD_S: f64 = 0.01;
/// and specific forces by less than this, m/s².
const MAX_REST_ACCEL_M_S2: f64 = 0.1;

/// Standard deviations of what rest shows.
struct Deviations {
    /// Radians.
    rotation: f64,
    /// m/s.
    velocity: f64,
    /// rad/s.
    gyro_bias: f64,
    /// As an angle, radians.
    gravity: f64,
}

const AT_REST: Deviations = Deviations {
    rotation: 1e-4,
    velocity: 1e-3,
    gyro_bias: 1e-3,
    gravity: 5e-3,
};
/// Nothing of this kind moves faster than 3 m/s.
const MOVING: Deviations = Deviations {
    rotation: 1e-2,
    velocity: 3.0,
    gyro_bias: 1e-2,
    gravity: 0.1,
};
/// The origin of `odom` is where the robot begins, metres.
const POSITION_M: f64 = 1e-4;
const ACCEL_BIAS_M_S2: f64 = 0.05;
/// The LiDAR's pose on the IMU if it is estimated, radians and metres.
const ESTIMATED_MOUNT: f64 = 0.02;
/// The same if it is known.
const KNOWN_MOUNT: f64 = 1e-6;

/// Collects the first samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Start {
    samples: Vec<ImuSample>,
}

/// What a robot begins with.
#[derive(Debug)]
pub(super) struct First {
    pub(super) belief: Belief,
    /// Since when it has rested; `None` in motion.
    pub(super) at_rest: Option<SimTime>,
}

impl Start {
    /// Takes in a sample; returns the first state once there are enough.
    pub(super) fn take(&mut self, sample: &ImuSample, settings: &Settings) -> Option<First> {
        self.samples.push(*sample);
        if !self.is_complete(sample) {
            return None;
        }
        let samples = std::mem::take(&mut self.samples);
        let settled = &samples[samples.len() / PUT_DOWN..];
        let is_at_rest = is_at_rest(settled);
        let used = if is_at_rest { settled } else { &samples[..] };
        let belief = Belief {
            stamp: sample.stamp,
            state: first_state(used, is_at_rest, settings),
            covariance: first_covariance(is_at_rest, settings),
        };
        Some(First {
            belief,
            at_rest: is_at_rest.then(|| settled[0].stamp),
        })
    }

    fn is_complete(&self, newest: &ImuSample) -> bool {
        let is_long = newest.stamp.since(self.samples[0].stamp) >= DURATION;
        is_long && self.samples.len() >= MIN_SAMPLES || self.samples.len() >= MAX_SAMPLES
    }
}

/// Whether neither turn rates nor specific forces vary.
fn is_at_rest(samples: &[ImuSample]) -> bool {
    deviation(samples, |sample| sample.gyro) < MAX_REST_GYRO_RAD_S
        && deviation(samples, |sample| sample.accel) < MAX_REST_ACCEL_M_S2
}

fn mean(samples: &[ImuSample], part: impl Fn(&ImuSample) -> [f64; 3]) -> Vector3<f64> {
    let sum = samples
        .iter()
        .map(|sample| Vector3::from(part(sample)))
        .sum::<Vector3<f64>>();
    sum / samples.len() as f64
}

fn deviation(samples: &[ImuSample], part: impl Fn(&ImuSample) -> [f64; 3]) -> f64 {
    let mean = mean(samples, &part);
    let squares = samples
        .iter()
        .map(|sample| (Vector3::from(part(sample)) - mean).norm_squared());
    (squares.sum::<f64>() / samples.len() as f64).sqrt()
}

/// The state in which the robot's frame has the heading 0 and is at the origin.
fn first_state(samples: &[ImuSample], is_at_rest: bool, settings: &Settings) -> State {
    let gyro = mean(samples, |sample| sample.gyro);
    let accel = mean(samples, |sample| sample.accel);
    // The specific force of a body at rest points up.
    let up = UnitQuaternion::rotation_between(&accel, &Vector3::z()).unwrap_or_default();
    // `up` turns the IMU's frame upright about a level axis; the robot's heading is taken out.
    let ahead = up * (settings.imu.rotation.inverse() * Vector3::x());
    let heading = -libm::atan2(ahead.y, ahead.x);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading) * up;
    let robot = rotation * settings.imu.rotation.inverse();
    let position = robot * settings.imu.translation.vector;
    let pose = Isometry3::from_parts(position.into(), rotation);
    State {
        gyro_bias: if is_at_rest { gyro } else { Vector3::zeros() },
        mount_rotation: settings.lidar.rotation,
        mount_position: settings.lidar.translation.vector,
        // The length of gravity is what this accelerometer shows of it.
        ..State::at_rest(&pose, accel.norm())
    }
}

fn first_covariance(is_at_rest: bool, settings: &Settings) -> Covariance {
    let deviations = if is_at_rest { AT_REST } else { MOVING };
    let mount = if settings.estimate_lidar {
        ESTIMATED_MOUNT
    } else {
        KNOWN_MOUNT
    };
    let mut covariance = Covariance::zeros();
    set_deviation::<3>(&mut covariance, at::ROTATION, deviations.rotation);
    set_deviation::<3>(&mut covariance, at::POSITION, POSITION_M);
    set_deviation::<3>(&mut covariance, at::VELOCITY, deviations.velocity);
    set_deviation::<3>(&mut covariance, at::GYRO_BIAS, deviations.gyro_bias);
    set_deviation::<3>(&mut covariance, at::ACCEL_BIAS, ACCEL_BIAS_M_S2);
    set_deviation::<2>(&mut covariance, at::GRAVITY, deviations.gravity);
    set_deviation::<3>(&mut covariance, at::MOUNT_ROTATION, mount);
    set_deviation::<3>(&mut covariance, at::MOUNT_POSITION, mount);
    set_deviation::<2>(&mut covariance, at::MAP_TILT, UPRIGHT_RAD);
    covariance
}

/// Sets the standard deviation of `N` components of the error, which begin at `first`.
fn set_deviation<const N: usize>(covariance: &mut Covariance, first: usize, deviation: f64) {
    for i in first..first + N {
        covariance[(i, i)] = deviation * deviation;
    }
}
