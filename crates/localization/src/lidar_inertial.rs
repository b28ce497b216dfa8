//! LiDAR-inertial odometry with wheels, from a known start.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};
use openbench_core::{Doubt, Health, Observation, Pose2, Pose3, RobotDescription, SimTime};

use crate::Localizer;
use crate::history::History;
use crate::lio::{ImuNoise, LidarInertialOdometry, LidarNoise, Settings, Status};
use crate::so3::hat;
use crate::track::Track;
use crate::wheels::Wheels;

/// A pose with a larger standard deviation is degraded, metres.
const DEGRADED_M: f64 = 0.5;
/// A pose with a larger standard deviation is of no use, metres.
const LOST_M: f64 = 5.0;

/// Pose from LiDAR, IMU and wheels.
#[derive(Debug, Clone)]
pub struct LidarInertial {
    robot: RobotDescription,
    odometry: LidarInertialOdometry,
    start: Pose2,
    history: History,
    wheels: Wheels,
    last: Option<LastEstimate>,
    /// The newest pose in `odom`.
    newest: Pose3,
}

/// What the odometry said last.
#[derive(Debug, Clone)]
struct LastEstimate {
    status: Status,
    /// In `odom`.
    pose: Pose3,
    /// Of the IMU: rotation in its own frame, position in `odom`.
    covariance: Matrix6<f64>,
}

impl LidarInertial {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        Self {
            odometry: LidarInertialOdometry::new(sensor_settings(&robot)),
            start: Pose2::default(),
            history: History::from(Pose2::default()),
            wheels: Wheels::new(&robot),
            last: None,
            newest: Pose3::identity(),
            robot,
        }
    }

    /// Health of a pose that comes from this localizer and has this covariance: x, y and yaw.
    pub(crate) fn health_within(&self, covariance: Option<Matrix3<f64>>) -> Health {
        let Some(last) = &self.last else {
            return Health::Good;
        };
        let variance = covariance.map_or(0.0, |covariance| covariance[(0, 0)] + covariance[(1, 1)]);
        let deviation = variance.sqrt();
        // A covariance that contains NaN says nothing.
        let is_useless = deviation.is_nan() || deviation > LOST_M;
        match last.status {
            Status::Lost => Health::Lost,
            _ if is_useless => Health::Lost,
            Status::Coasting => Health::Degraded(Doubt::FewFeatures),
            Status::Noisy => Health::Degraded(Doubt::Noise),
            Status::Disputed => Health::Degraded(Doubt::Contradiction),
            Status::Tracking if deviation > DEGRADED_M => Health::Degraded(Doubt::FewFeatures),
            Status::Tracking => Health::Good,
        }
    }

    fn remember(&mut self, stamp: SimTime, pose: &Pose3) {
        let ahead = pose.rotation * Vector3::x();
        let yaw = libm::atan2(ahead.y, ahead.x);
        let in_odom = Pose2::new(pose.translation.x, pose.translation.y, yaw);
        self.newest = *pose;
        self.history.push(stamp, self.start.compose(in_odom));
    }

    /// How x, y and yaw in `map` change with the IMU's rotation in its own frame and its position
    /// in `odom`; `pose` is the robot's.
    fn map_jacobian(&self, pose: &Pose3) -> SMatrix<f64, 3, 6> {
        let (sine, cosine) = libm::sincos(self.start.yaw);
        let imu = pose.rotation * self.robot.imu.rotation;
        // The robot's frame moves with the IMU's rotation.
        let lever = imu * self.robot.imu.inverse().translation.vector;
        let moved = -hat(lever) * imu.to_rotation_matrix().into_inner();
        // Yaw changes by the part of the rotation about the vertical, which is this in the IMU's
        // frame.
        let upright = imu.inverse() * Vector3::z();
        let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
        for (row, [x, y]) in [[cosine, -sine], [sine, cosine]].into_iter().enumerate() {
            let by_rotation = moved.row(0) * x + moved.row(1) * y;
            jacobian
                .fixed_view_mut::<1, 3>(row, 0)
                .copy_from(&by_rotation);
            jacobian[(row, 3)] = x;
            jacobian[(row, 4)] = y;
        }
        jacobian
            .fixed_view_mut::<1, 3>(2, 0)
            .copy_from(&upright.transpose());
        jacobian
    }
}

/// The sensors of a robot: a MID-360 and the IMU in it, as their data sheets describe them.
pub fn sensor_settings(robot: &RobotDescription) -> Settings {
    Settings {
        imu: robot.imu,
        lidar: robot.imu.inverse() * robot.lidar,
        estimate_lidar: false,
        imu_noise: ImuNoise {
            gyro: 2e-4,
            accel: 2e-3,
            gyro_walk: 1e-5,
            accel_walk: 1e-4,
        },
        imu_limits: None,
        lidar_noise: LidarNoise {
            range: 0.02,
            angle: 0.001,
        },
        typical_speed_m_s: robot.max_forward,
        min_range_m: 0.3,
    }
}

impl Track for LidarInertial {
    /// The pose at an instant, with the height and the tilt of the newest pose, in the frame in
    /// which the start was given.
    fn pose3_at(&self, time: SimTime) -> Pose3 {
        let level = self.history.at(time);
        let tilt = Pose2::from_pose3(&self.newest)
            .to_pose3(0.0)
            .rotation
            .inverse()
            * self.newest.rotation;
        let mut pose = level.to_pose3(self.newest.translation.z);
        pose.rotation *= tilt;
        pose
    }

    fn pose_covariance(&self) -> Option<Matrix3<f64>> {
        self.covariance()
    }
}

impl Localizer for LidarInertial {
    fn name(&self) -> &str {
        "lidar-inertial"
    }

    fn reset(&mut self, start: Pose2) {
        *self = Self::new(self.robot.clone());
        self.start = start;
        self.history = History::from(start);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        // In this order, since the IMU sets off the prediction up to a waiting scan. Velocities
        // must be there by then.
        for sample in observation.wheels {
            if let Some(speed) = self.wheels.take(sample) {
                self.odometry.speed(speed);
            }
        }
        let mut estimates = Vec::new();
        for sample in observation.imu {
            estimates.extend(self.odometry.imu(*sample));
        }
        if let Some(scan) = observation.scan {
            estimates.extend(self.odometry.scan(scan.clone()));
        }
        // Estimates are in the order of their stamps: the last one is the newest.
        if let Some(last) = estimates.pop() {
            let (status, pose, covariance) = (last.status, last.pose, last.covariance);
            self.last = Some(LastEstimate {
                status,
                pose,
                covariance,
            });
        }
        if let Some((stamp, pose)) = self.odometry.newest_pose() {
            self.remember(stamp, &pose);
        }
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.history.at(time)
    }

    fn pose(&self) -> Pose2 {
        self.history.newest().pose
    }

    fn ready(&self) -> bool {
        self.last.is_some()
    }

    fn health(&self) -> Health {
        self.health_within(self.covariance())
    }

    fn covariance(&self) -> Option<Matrix3<f64>> {
        let last = self.last.as_ref()?;
        let jacobian = self.map_jacobian(&last.pose);
        Some(jacobian * last.covariance * jacobian.transpose())
    }
}
