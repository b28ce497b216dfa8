//! Simulated IMU and LiDAR along a known trajectory, in a world whose ranges are known.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::{ImuSample, LidarPoint, LidarScan, Pose3, SimTime};
use openbench_localization::lio::{
    Estimate, ImuNoise, LidarInertialOdometry, LidarNoise, Settings,
};

const GRAVITY_M_S2: f64 = 9.8;
/// Time between samples of the IMU.
const IMU_MILLIS: u64 = 10;
/// Time between scans.
const SCAN_MILLIS: u64 = 100;
/// Points of a scan.
const RAYS: u64 = 4000;
/// West, south, floor, east, north, ceiling, metres.
const ROOM: [f64; 6] = [-6.0, -4.0, -0.5, 10.0, 9.0, 3.0];

/// Pose of the IMU at a time in seconds.
pub type Trajectory = fn(f64) -> Pose3;
/// Range of a ray from a place in a direction, metres.
pub type Range = fn(Vector3<f64>, Vector3<f64>) -> f64;

/// What the sensors deliver at an instant.
pub struct SensorData {
    pub millis: u64,
    pub imu: Option<ImuSample>,
    pub scan: Option<LidarScan>,
}

/// A drive with odometry.
pub struct Drive {
    pub odometry: LidarInertialOdometry,
    pub estimates: Vec<Estimate>,
}

impl Drive {
    /// Drives for so many seconds round the room. `disturb` may change the sensor data.
    pub fn new(seconds: u64, disturb: impl Fn(&mut SensorData)) -> Self {
        Self::along(circle, room, seconds, disturb)
    }

    /// Drives along another trajectory, in another world.
    pub fn along(
        trajectory: Trajectory,
        range: Range,
        seconds: u64,
        disturb: impl Fn(&mut SensorData),
    ) -> Self {
        let mut odometry = LidarInertialOdometry::new(settings());
        let mut noise = Noise(1);
        let mut estimates = Vec::new();
        for millis in (0..seconds * 1000).step_by(IMU_MILLIS as usize) {
            let is_scan = millis.is_multiple_of(SCAN_MILLIS);
            let scan = is_scan.then(|| scan(trajectory, range, millis, &mut noise));
            let imu = Some(imu(trajectory, millis, &mut noise));
            let mut data = SensorData { millis, imu, scan };
            disturb(&mut data);
            estimates.extend(data.imu.into_iter().flat_map(|sample| odometry.imu(sample)));
            estimates.extend(data.scan.into_iter().flat_map(|scan| odometry.scan(scan)));
        }
        Self {
            odometry,
            estimates,
        }
    }

    pub fn last(&self) -> &Estimate {
        &self.estimates[self.estimates.len() - 1]
    }
}

/// Noise from a seed.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        let scaled = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = scaled.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// Noise of three axes.
    fn vector(&mut self, deviation: f64) -> Vector3<f64> {
        let [x, y, z] = [(); 3].map(|()| deviation * self.normal());
        Vector3::new(x, y, z)
    }

    /// A direction, uniform on the sphere.
    fn direction(&mut self) -> Vector3<f64> {
        let up = 2.0 * self.uniform() - 1.0;
        let azimuth = TAU * self.uniform();
        let level = (1.0 - up * up).sqrt();
        Vector3::new(level * libm::cos(azimuth), level * libm::sin(azimuth), up)
    }
}

fn settings() -> Settings {
    Settings {
        imu: Pose3::identity(),
        lidar: Pose3::translation(0.1, 0.0, 0.2),
        estimate_lidar: false,
        imu_noise: ImuNoise {
            gyro: 2e-4,
            accel: 2e-3,
            gyro_walk: 1e-5,
            accel_walk: 1e-4,
        },
        imu_limits: None,
        lidar_noise: LidarNoise {
            range: 0.01,
            angle: 0.001,
        },
        typical_speed_m_s: 1.0,
        min_range_m: 0.3,
    }
}

/// At rest for one and a half seconds, then faster and faster round a circle of three metres, up to
/// 0.9 m/s.
pub fn circle(seconds: f64) -> Pose3 {
    let t = (seconds - 1.5).max(0.0);
    let angle = if t < 1.5 {
        0.1 * t * t
    } else {
        0.225 + 0.3 * (t - 1.5)
    };
    let position = Vector3::new(3.0 * libm::sin(angle), 3.0 * (1.0 - libm::cos(angle)), 0.0);
    let rotation = UnitQuaternion::from_euler_angles(0.0, 0.0, angle);
    Pose3::from_parts(position.into(), rotation)
}

/// Range to a wall of the room.
pub fn room(from: Vector3<f64>, along: Vector3<f64>) -> f64 {
    let wall = |axis: usize| ROOM[if along[axis] > 0.0 { axis + 3 } else { axis }];
    let ranges = (0..3).map(|axis| (wall(axis) - from[axis]) / along[axis]);
    ranges.fold(f64::INFINITY, f64::min)
}

fn imu(trajectory: Trajectory, millis: u64, noise: &mut Noise) -> ImuSample {
    let (t, dt) = (millis as f64 / 1e3, 1e-3);
    let [before, here, after] = [t - dt, t, t + dt].map(trajectory);
    let [p0, p1, p2] = [before, here, after].map(|pose| pose.translation.vector);
    let acceleration = (p2 - p1 * 2.0 + p0) / (dt * dt);
    let force = here.rotation.inverse() * (acceleration + Vector3::z() * GRAVITY_M_S2);
    let rate = (before.rotation.inverse() * after.rotation).scaled_axis() / (2.0 * dt);
    let gyro = rate.add_scalar(0.002) + noise.vector(5e-4);
    let accel = force.add_scalar(0.01) + noise.vector(5e-3);
    ImuSample {
        stamp: SimTime::from_millis(millis),
        gyro: gyro.into(),
        accel: accel.into(),
    }
}

fn scan(trajectory: Trajectory, range: Range, millis: u64, noise: &mut Noise) -> LidarScan {
    let mut points = Vec::new();
    for ray in 0..RAYS {
        let offset_ns = (SCAN_MILLIS * 1_000_000 * ray / RAYS) as u32;
        let seconds = millis as f64 / 1e3 + f64::from(offset_ns) * 1e-9;
        let lidar = trajectory(seconds) * settings().lidar;
        let direction = noise.direction();
        let exact = range(lidar.translation.vector, lidar.rotation * direction);
        let measured = exact + 0.01 * noise.normal();
        if measured.is_finite() {
            let xyz = (direction * measured).map(|x| x as f32).into();
            points.push(LidarPoint {
                xyz,
                offset_ns,
                reflectivity: 100,
                line: 0,
            });
        }
    }
    LidarScan {
        stamp: SimTime::from_millis(millis),
        points,
    }
}
