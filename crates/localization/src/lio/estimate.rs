//! What the odometry reports.

use nalgebra::{Matrix6, Vector3};
use openbench_core::{Pose3, SimTime};
use serde::Serialize;

/// How far an estimate can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The scan agrees with the map.
    Tracking,
    /// The scan agrees with the map, but scans, IMU and wheels have contradicted each other for a
    /// while. A sensor is mounted elsewhere or otherwise than configured, has another clock, or
    /// reports other units. The pose's heading, tilt and covariance are then unreliable.
    Disputed,
    /// The scan agrees with the map, but its points are scattered several times as widely as the
    /// LiDAR's noise explains. They count less, and the pose is less certain.
    Noisy,
    /// The scan is empty, degenerate or contradicts the map. The pose is predicted from the IMU,
    /// and its covariance grows.
    Coasting,
    /// The IMU was silent for so long that the motion since the estimate before is unknown. Later
    /// estimates are as good as ever, but relative to this one: the map was begun anew.
    Lost,
}

/// A pose, and how certain it is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Time of the last point of a scan.
    pub stamp: SimTime,
    /// In `odom`: its origin and heading are those at the start, and its z axis points up.
    pub pose: Pose3,
    /// Velocity of the IMU in `odom`, m/s.
    pub velocity: Vector3<f64>,
    /// Covariance of the IMU's pose: rotation in its own frame, then position in `odom`; rad² and
    /// m². It grows with the distance driven, except for roll and pitch, which gravity shows.
    pub covariance: Matrix6<f64>,
    /// How far the pose can be trusted.
    pub status: Status,
    /// Directions in `odom` along which the scan said little about the position: unit vectors.
    pub degenerate: Vec<Vector3<f64>>,
    /// Points that lay on known planes.
    pub points: usize,
    /// Mean square of their residuals, in standard deviations.
    pub fit: f64,
}

/// How much input could not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Refused {
    /// Samples of the IMU that are not finite, larger than any IMU's, or not later than the last.
    pub imu: usize,
    /// Scans that are older than the last, or came without an IMU.
    pub scans: usize,
    /// Velocities that are not finite, faster than anything drives, or not later than the last.
    pub speeds: usize,
    /// Points that are not finite, too near, or farther than any LiDAR sees.
    pub points: usize,
    /// Gaps between samples of the IMU.
    pub gaps: usize,
    /// How often the filter diverged from wheels and gyroscope, and was restarted from these.
    #[serde(rename = "runaways")]
    pub restarts: usize,
}
