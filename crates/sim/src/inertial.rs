//! The inertial measurement unit and the wheels' encoders.

use nalgebra::Vector3;
use openbench_core::{ImuSample, Pose3, RobotDescription, SimTime, WheelSample};

use crate::noise::Noise;
use crate::physics::Physics;

/// Time between two samples, nanoseconds: 100 Hz.
pub const SAMPLE_NS: u64 = 10_000_000;
const DT: f64 = SAMPLE_NS as f64 * 1e-9;
/// White noise of the gyroscope at 100 Hz, rad/s (4.5 mdps/√Hz, the order of an ICM-40609).
const GYRO_NOISE: f64 = 5.6e-4;
/// White noise of the accelerometer at 100 Hz, m/s² (100 µg/√Hz).
const ACCEL_NOISE: f64 = 6.9e-3;
/// Deviation of the bias at switch-on: rad/s and m/s².
const GYRO_BIAS: f64 = 4e-3;
const ACCEL_BIAS: f64 = 0.05;
/// Random walk of the bias in one sample: rad/s and m/s².
const GYRO_WALK: f64 = 2e-7;
const ACCEL_WALK: f64 = 2e-6;
const GRAVITY: f64 = 9.8;
/// Marks on an encoder's disc.
const TICKS: f64 = 2048.0;

/// IMU with noise and wandering bias.
#[derive(Debug)]
pub struct Imu {
    noise: Noise,
    mount: Pose3,
    gyro_bias: Vector3<f64>,
    accel_bias: Vector3<f64>,
    last_velocity: Vector3<f64>,
}

impl Imu {
    /// An IMU mounted on the robot as its description says.
    pub fn new(mut noise: Noise, robot: &RobotDescription) -> Self {
        let gyro_bias = normal3(&mut noise) * GYRO_BIAS;
        let accel_bias = normal3(&mut noise) * ACCEL_BIAS;
        Self { noise, mount: robot.imu, gyro_bias, accel_bias, last_velocity: Vector3::zeros() }
    }

    /// The sample at `stamp`; the specific force is the mean since the last sample.
    pub fn sample(&mut self, stamp: SimTime, physics: &Physics) -> ImuSample {
        let base = physics.base_link();
        let to_sensor = (base.rotation * self.mount.rotation).inverse();
        let velocity = physics.velocity_at(self.mount.translation.vector);
        let acceleration = (velocity - self.last_velocity) / DT + Vector3::z() * GRAVITY;
        self.last_velocity = velocity;
        self.gyro_bias += normal3(&mut self.noise) * GYRO_WALK;
        self.accel_bias += normal3(&mut self.noise) * ACCEL_WALK;
        let gyro =
            to_sensor * physics.angular_velocity() + self.gyro_bias + normal3(&mut self.noise) * GYRO_NOISE;
        let accel = to_sensor * acceleration + self.accel_bias + normal3(&mut self.noise) * ACCEL_NOISE;
        ImuSample { stamp, gyro: gyro.into(), accel: accel.into() }
    }
}

fn normal3(noise: &mut Noise) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.normal())
}

/// Encoders of the left and right wheels.
#[derive(Debug, Default)]
pub struct Encoders {
    angles: [f64; 2],
}

impl Encoders {
    /// Turns the discs with the wheels for `dt` seconds.
    pub fn turn(&mut self, speeds: [f64; 2], dt: f64) {
        for (angle, speed) in self.angles.iter_mut().zip(speeds) {
            *angle += speed * dt;
        }
    }

    /// The sample at `stamp`: angles in whole marks.
    pub fn sample(&self, stamp: SimTime) -> WheelSample {
        let mark = std::f64::consts::TAU / TICKS;
        let [left, right] = self.angles.map(|a| libm::floor(a / mark) * mark);
        WheelSample { stamp, left, right }
    }
}
