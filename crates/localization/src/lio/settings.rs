//! What the sensors are like.

use openbench_core::Pose3;

use super::noise::{ImuNoise, LidarNoise};

/// The largest magnitudes that an IMU can show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuLimits {
    /// Of a turn rate about one axis, rad/s.
    pub gyro: f64,
    /// Of a specific force along one axis, m/s².
    pub accel: f64,
}

/// What the sensors are like.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Pose of the IMU in the frame whose pose is estimated, such as `base_link`.
    pub imu: Pose3,
    /// Pose of the LiDAR in the IMU's frame.
    pub lidar: Pose3,
    /// Whether the filter estimates that pose, too, beginning with [`lidar`](Self::lidar).
    pub estimate_lidar: bool,
    /// Noise of the IMU.
    pub imu_noise: ImuNoise,
    /// Limits of the IMU. If they are unknown, the same largest reading several times in a row
    /// counts as a limit.
    pub imu_limits: Option<ImuLimits>,
    /// Noise of the LiDAR.
    pub lidar_noise: LidarNoise,
    /// Usual speed of the robot, m/s. It bounds the velocity along directions that neither scans
    /// nor wheels observe.
    pub typical_speed_m_s: f64,
    /// Points nearer than this belong to the robot itself, metres.
    pub min_range_m: f64,
}
