//! LiDAR-inertial odometry with wheels, from a known start.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};
use openbench_core::{Doubt, Health, Observation, Pose2, Pose3, RobotDescription, SimTime};

use crate::Localizer;
use crate::history::History;
use crate::lio::propagation::ImuNoise;
use crate::lio::so3::hat;
use crate::lio::update::LidarNoise;
use crate::lio::{LidarInertialOdometry, Settings, Status};
use crate::wheels::Wheels;

/// A pose with a larger deviation is not to be trusted, and one with a still larger one is of no use, metres.
const DOUBTFUL_M: f64 = 0.5;
const LOST_M: f64 = 5.0;

/// Pose from LiDAR, IMU and wheels.
#[derive(Debug, Clone)]
pub struct LidarInertial {
    robot: RobotDescription,
    odometry: LidarInertialOdometry,
    start: Pose2,
    history: History,
    wheels: Wheels,
    status: Option<Status>,
    /// Of the newest estimate: of the IMU, rotation in its own frame, position in `odom`; and the pose it is of.
    covariance: Option<(Matrix6<f64>, Pose3)>,
}

impl LidarInertial {
    /// A localizer for a robot.
    pub fn new(robot: RobotDescription) -> Self {
        let odometry = LidarInertialOdometry::new(settings(&robot));
        let (start, history) = (Pose2::default(), History::from(Pose2::default()));
        let wheels = Wheels::new(&robot);
        Self {
            robot,
            odometry,
            start,
            history,
            wheels,
            status: None,
            covariance: None,
        }
    }

    /// The health of a pose of that covariance that comes from here.
    pub(crate) fn health_within(&self, covariance: Option<Matrix3<f64>>) -> Health {
        let deviation = covariance.map_or(0.0, |covariance| {
            (covariance[(0, 0)] + covariance[(1, 1)]).sqrt()
        });
        match self.status {
            Some(Status::Lost) => Health::Lost,
            // No number is no covariance.
            Some(_) if deviation.is_nan() || deviation > LOST_M => Health::Lost,
            Some(Status::Coasting) => Health::Degraded(Doubt::FewFeatures),
            Some(Status::Noisy) => Health::Degraded(Doubt::Noise),
            Some(Status::Disputed) => Health::Degraded(Doubt::Contradiction),
            Some(Status::Tracking) if deviation > DOUBTFUL_M => {
                Health::Degraded(Doubt::FewFeatures)
            }
            None | Some(Status::Tracking) => Health::Good,
        }
    }

    fn newest(&self) -> (SimTime, Pose2) {
        self.history.newest()
    }

    fn remember(&mut self, stamp: SimTime, pose: &Pose3) {
        let ahead = pose.rotation * Vector3::x();
        let yaw = libm::atan2(ahead.y, ahead.x);
        let on_map = self
            .start
            .compose(Pose2::new(pose.translation.x, pose.translation.y, yaw));
        self.history.push(stamp, on_map);
    }
}

/// The sensors of a robot: a MID-360 and the IMU in it, as their data sheets have them.
pub fn settings(robot: &RobotDescription) -> Settings {
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
        typical_speed: robot.max_forward,
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
        self.history = History::from(start);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        let speeds = observation
            .wheels
            .iter()
            .filter_map(|sample| self.wheels.take(sample));
        speeds.for_each(|speed| self.odometry.speed(speed));
        let mut estimates: Vec<_> = observation
            .imu
            .iter()
            .flat_map(|sample| self.odometry.imu(*sample))
            .collect();
        if let Some(scan) = observation.scan {
            estimates.extend(self.odometry.scan(scan.clone()));
        }
        if let Some(last) = estimates.last() {
            self.status = Some(last.status);
            self.covariance = Some((last.covariance, last.pose));
        }
        if let Some((stamp, pose)) = self.odometry.now() {
            self.remember(stamp, &pose);
        }
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.history.at(time)
    }

    fn pose(&self) -> Pose2 {
        self.newest().1
    }

    fn ready(&self) -> bool {
        self.status.is_some()
    }

    fn health(&self) -> Health {
        self.health_within(self.covariance())
    }

    fn covariance(&self) -> Option<Matrix3<f64>> {
        let (covariance, pose) = self.covariance.as_ref()?;
        let imu = pose.rotation * self.robot.imu.rotation;
        // x, y and yaw in `map`, by rotation in the IMU's frame and position in `odom`.
        let (sine, cosine) = libm::sincos(self.start.yaw);
        let upright = imu.inverse() * Vector3::z();
        let mut rows = SMatrix::<f64, 3, 6>::zeros();
        (rows[(0, 3)], rows[(0, 4)], rows[(1, 3)], rows[(1, 4)]) = (cosine, -sine, sine, cosine);
        rows.fixed_view_mut::<1, 3>(2, 0)
            .copy_from(&upright.transpose());
        // `base_link` goes along with the IMU's rotation.
        let lever = imu * self.robot.imu.inverse().translation.vector;
        let turn = -hat(lever) * imu.to_rotation_matrix().into_inner();
        for (row, [x, y]) in [(0, [cosine, -sine]), (1, [sine, cosine])] {
            let moved = turn.row(0) * x + turn.row(1) * y;
            rows.fixed_view_mut::<1, 3>(row, 0).copy_from(&moved);
        }
        Some(rows * covariance * rows.transpose())
    }
}
