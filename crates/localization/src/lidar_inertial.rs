//! LiDAR-inertial odometry with wheels, from a known start.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::Vector3;
use openbench_core::frames::wrap_angle;
use openbench_core::{Observation, Pose2, Pose3, RobotDescription, SimTime};

use crate::Localizer;
use crate::lio::propagation::ImuNoise;
use crate::lio::update::LidarNoise;
use crate::lio::{LidarInertialOdometry, Settings, Status};
use crate::wheels::Wheels;

/// Poses of this long are remembered.
const MEMORY: Duration = Duration::from_millis(1000);
/// Pose from LiDAR, IMU and wheels.
#[derive(Debug, Clone)]
pub struct LidarInertial {
    robot: RobotDescription,
    odometry: LidarInertialOdometry,
    start: Pose2,
    history: VecDeque<(SimTime, Pose2)>,
    wheels: Wheels,
    status: Option<Status>,
}

impl LidarInertial {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        let odometry = LidarInertialOdometry::new(settings(&robot));
        let (start, history) = (Pose2::default(), VecDeque::from([(SimTime::ZERO, Pose2::default())]));
        let wheels = Wheels::new(&robot);
        Self { robot, odometry, start, history, wheels, status: None }
    }

    fn newest(&self) -> (SimTime, Pose2) {
        self.history.back().copied().unwrap_or_default()
    }

    fn remember(&mut self, stamp: SimTime, pose: &Pose3) {
        let ahead = pose.rotation * Vector3::x();
        let yaw = libm::atan2(ahead.y, ahead.x);
        let on_map = self.start.compose(Pose2::new(pose.translation.x, pose.translation.y, yaw));
        if stamp <= self.newest().0 {
            self.history.pop_back();
        }
        self.history.push_back((stamp, on_map));
        while self.history.len() > 2 && stamp.since(self.history[1].0) > MEMORY {
            self.history.pop_front();
        }
    }
}

/// The sensors of a robot: a MID-360 and the IMU in it, as their data sheets have them.
pub fn settings(robot: &RobotDescription) -> Settings {
    Settings {
        imu: robot.imu,
        lidar: robot.imu.inverse() * robot.lidar,
        estimate_lidar: false,
        imu_noise: ImuNoise { gyro: 2e-4, accel: 2e-3, gyro_walk: 1e-5, accel_walk: 1e-4 },
        imu_limits: None,
        lidar_noise: LidarNoise { range: 0.02, angle: 0.001 },
        blind: 0.3,
    }
}

impl Localizer for LidarInertial {
    fn name(&self) -> &str {
        "lidar-inertial"
    }

    fn reset(&mut self, start: Pose2) {
        *self = Self::new(self.robot.clone());
        self.start = start;
        self.history = VecDeque::from([(SimTime::ZERO, start)]);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        let speeds = observation.wheels.iter().filter_map(|sample| self.wheels.take(sample));
        speeds.for_each(|speed| self.odometry.speed(speed));
        let mut estimates: Vec<_> =
            observation.imu.iter().flat_map(|sample| self.odometry.imu(*sample)).collect();
        if let Some(scan) = observation.scan {
            estimates.extend(self.odometry.scan(scan.clone()));
        }
        if let Some(last) = estimates.last() {
            self.status = Some(last.status);
        }
        if let Some((stamp, pose)) = self.odometry.now() {
            self.remember(stamp, &pose);
        }
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        let after = self.history.partition_point(|(t, _)| *t < time);
        let Some(&(t1, b)) = self.history.get(after) else { return self.newest().1 };
        let Some(&(t0, a)) = after.checked_sub(1).and_then(|i| self.history.get(i)) else { return b };
        let s = time.since(t0).as_secs_f64() / t1.since(t0).as_secs_f64().max(1e-9);
        Pose2::new(a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.yaw + s * wrap_angle(b.yaw - a.yaw))
    }

    fn pose(&self) -> Pose2 {
        self.newest().1
    }

    fn ready(&self) -> bool {
        self.status.is_some()
    }
}
