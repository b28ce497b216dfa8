//! What waits for what: scans for the IMU, and the IMU for the start.

use std::collections::VecDeque;
use std::time::Duration;

use openbench_core::{ImuSample, LidarScan, Pose3, SimTime};

use super::estimate::{Estimate, Refused};
use super::pipeline::Pipeline;
use super::settings::Settings;
use super::speed::Speed;
use super::start::{First, Start};
use super::undistortion::end_of;

/// At most this many scans wait for the IMU.
const MAX_WAITING: usize = 20;
/// The IMU waits for a scan for this time; then the odometry goes on without.
const PATIENCE: Duration = Duration::from_millis(300);
/// A scan that ends this much later than the newest sample of the IMU has another clock.
const MAX_AHEAD: Duration = Duration::from_secs(2);
/// After this time without the IMU it is unknown where the robot has gone.
const MAX_SILENCE: Duration = Duration::from_secs(2);

/// LiDAR-inertial odometry.
///
/// It is given samples of the IMU, scans and the wheels' velocities as they come, in any order, and
/// returns an estimate for each scan once the IMU has come as far. The first second of the IMU
/// shows which way is up.
///
/// # Example
///
/// A robot that rests for three seconds before two walls:
///
/// ```
/// use openbench_core::{ImuSample, LidarPoint, LidarScan, RobotDescription, SimTime};
/// use openbench_localization::lidar_inertial::sensor_settings;
/// use openbench_localization::lio::{LidarInertialOdometry, Status};
///
/// // Ground half a metre below the LiDAR, a wall 4 m to the left, one 5 m ahead.
/// let point = |i: u32| {
///     let a = (i / 3 % 40) as f32 * 0.1 - 2.0;
///     let b = (i / 120) as f32 * 0.1 - 0.4;
///     let xyz = match i % 3 {
///         0 => [a, b, -0.5],
///         1 => [a, 4.0, b],
///         _ => [5.0, a, b],
///     };
///     LidarPoint { xyz, offset_ns: i * 30_000, reflectivity: 100, line: 0 }
/// };
/// let points: Vec<LidarPoint> = (0..3000).map(point).collect();
///
/// let mut odometry = LidarInertialOdometry::new(sensor_settings(&RobotDescription::sentry()));
/// let mut estimates = Vec::new();
/// for i in 0..300 {
///     let stamp = SimTime::from_millis(10 * i);
///     let imu = ImuSample { stamp, gyro: [0.0; 3], accel: [0.0, 0.0, 9.81] };
///     estimates.extend(odometry.imu(imu));
///     if i % 10 == 0 {
///         estimates.extend(odometry.scan(LidarScan { stamp, points: points.clone() }));
///     }
/// }
/// let last = estimates.last().unwrap();
/// assert_eq!(last.status, Status::Tracking);
/// assert!(last.pose.translation.vector.norm() < 0.01, "{}", last.pose);
/// ```
#[derive(Debug, Clone)]
pub struct LidarInertialOdometry {
    start: Start,
    scans: VecDeque<LidarScan>,
    pipeline: Pipeline,
}

impl LidarInertialOdometry {
    /// Begins with nothing known.
    pub fn new(settings: Settings) -> Self {
        Self {
            start: Start::default(),
            scans: VecDeque::new(),
            pipeline: Pipeline::new(settings),
        }
    }

    /// How much input could not be used so far.
    pub fn refused(&self) -> Refused {
        self.pipeline.refused
    }

    /// Number of cubes in the map.
    pub fn map_size(&self) -> usize {
        self.pipeline.map_size()
    }

    /// Pose at the newest sample of the IMU, and when that was; `None` before the start.
    pub fn newest_pose(&self) -> Option<(SimTime, Pose3)> {
        self.pipeline.newest_pose()
    }

    /// Takes in a sample of the IMU. Returns estimates for scans that waited for it.
    pub fn imu(&mut self, sample: ImuSample) -> Vec<Estimate> {
        // Before the sample is taken in, and is the newest itself.
        let newest = self.pipeline.inertial.newest();
        let was_silent = newest.is_some_and(|newest| sample.stamp.since(newest) > MAX_SILENCE);
        if !self.pipeline.inertial.push(sample) {
            self.pipeline.refused.imu += 1;
            return Vec::new();
        }
        if self.pipeline.belief.is_some() {
            return if was_silent {
                self.lose(sample.stamp)
            } else {
                self.estimates()
            };
        }
        let Some(first) = self.start.take(&sample, &self.pipeline.settings) else {
            return Vec::new();
        };
        let mut estimates = self.begin(first);
        estimates.append(&mut self.estimates());
        estimates
    }

    /// Takes in a velocity, such as wheels show. It counts once the IMU and a scan have come as
    /// far.
    pub fn speed(&mut self, speed: Speed) {
        let is_usable = self.pipeline.inertial.push_speed(speed);
        self.pipeline.refused.speeds += usize::from(!is_usable);
    }

    /// Takes in a scan. Returns estimates for it and those before it, as far as the IMU has come.
    pub fn scan(&mut self, scan: LidarScan) -> Vec<Estimate> {
        let last_waiting = self.scans.back().map(|last| last.stamp);
        let last_done = self.pipeline.belief.as_ref().map(|belief| belief.stamp);
        // A scan that waits is later than any that was processed.
        let is_late = last_waiting
            .or(last_done)
            .is_some_and(|last| end_of(&scan) <= last);
        if is_late || self.scans.len() == MAX_WAITING {
            self.pipeline.refused.scans += 1;
            return Vec::new();
        }
        self.scans.push_back(scan);
        self.estimates()
    }

    /// Begins with the first state. Scans from where the robot rests begin the map; those from
    /// before have no known pose.
    fn begin(&mut self, first: First) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        let start = first.belief.stamp;
        let mut belief = first.belief;
        while let Some(scan) = self.scans.pop_front_if(|scan| end_of(scan) <= start) {
            if first.at_rest.is_none_or(|since| scan.stamp < since) {
                self.pipeline.refused.scans += 1;
            } else {
                estimates.push(self.pipeline.begin_map_with(&mut belief, &scan));
            }
        }
        // Each scan above has set it to its own end.
        belief.stamp = start;
        self.pipeline.belief = Some(belief);
        estimates
    }

    /// Estimates for all scans that the IMU has come up to.
    fn estimates(&mut self) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        let Some(newest) = self.pipeline.inertial.newest() else {
            return estimates;
        };
        while self
            .scans
            .pop_front_if(|scan| end_of(scan) > newest + MAX_AHEAD)
            .is_some()
        {
            self.pipeline.refused.scans += 1;
        }
        while self.pipeline.belief.is_some()
            && let Some(scan) = self.scans.pop_front_if(|scan| end_of(scan) <= newest)
        {
            match self.pipeline.process(&scan) {
                Some(estimate) => estimates.push(estimate),
                None => self.pipeline.refused.scans += 1,
            }
        }
        estimates.extend(self.without_scans(newest));
        estimates
    }

    /// An estimate without a scan, if none has come for long.
    fn without_scans(&mut self, newest: SimTime) -> Option<Estimate> {
        let last = self.pipeline.belief.as_ref()?.stamp;
        if newest.since(last) <= PATIENCE || !self.scans.is_empty() {
            return None;
        }
        self.pipeline.coast(newest)
    }

    /// Begins anew after the IMU was silent. Scans that wait for it are of the time before.
    fn lose(&mut self, stamp: SimTime) -> Vec<Estimate> {
        self.pipeline.refused.scans += self.scans.len();
        self.scans.clear();
        self.pipeline.lose(stamp).into_iter().collect()
    }
}
