//! LiDAR-inertial odometry: where the sensors have moved to since the start, from an IMU and the points of a LiDAR.
//!
//! After FAST-LIO2 (W. Xu et al. 2021) and FAST-LIO (W. Xu, F. Zhang 2021) for the filter, and VoxelMap (C. Yuan et al. 2022) for the map: the IMU says where each point
//! was measured and what to expect; the points' distances from the planes of a map correct it, in an iterated Kalman filter on the manifold of the
//! state.
//!
//! | module | its one job |
//! |---|---|
//! | [`so3`] | rotations as vectors |
//! | [`state`] | what is estimated, on its manifold |
//! | [`propagation`] | where the IMU says that it moves to |
//! | [`planes`] | the map: planes in cubes |
//! | [`mod@update`] | what a scan says about the state |
//! | `start` | the first state |

pub mod planes;
pub mod propagation;
pub mod so3;
mod start;
pub mod state;
pub mod update;

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, Matrix6, Translation3, Vector3};
use openbench_core::{ImuSample, LidarScan, Pose3, SimTime};

use planes::PlaneMap;
use propagation::{ImuNoise, Node, propagate};
use start::Start;
use state::{Covariance, State};
use update::{LidarNoise, update};

/// Points of a scan that correct the state, and that are added to the map, at most: evenly chosen.
const CORRECTING: usize = 4000;
const MAPPED: usize = 6000;
/// With fewer points on known planes a scan says nothing.
const FEW: usize = 60;
/// Samples of the IMU farther apart than that leave a gap.
const GAP: Duration = Duration::from_millis(50);
/// Scans that wait for the IMU at most.
const WAITING: usize = 20;
/// The map reaches that far, metres, and is cut to it each time that the IMU has come a quarter of it.
const REACH: f64 = 150.0;

/// What the sensors are like.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The IMU in the frame whose pose is told, such as `base_link`.
    pub imu: Pose3,
    /// The LiDAR in the IMU's frame.
    pub lidar: Pose3,
    /// Whether that is estimated too, from there.
    pub estimate_lidar: bool,
    /// What is wrong with the IMU.
    pub imu_noise: ImuNoise,
    /// What is wrong with the LiDAR.
    pub lidar_noise: LidarNoise,
    /// Points nearer than that are of the robot itself, metres.
    pub blind: f64,
}

/// How sure the odometry is of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The scan agrees with the map.
    Tracking,
    /// The scan says nothing, or not along all directions: the pose is the IMU's, and its covariance grows.
    Coasting,
}

/// A pose, and how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// When: the last point of a scan.
    pub stamp: SimTime,
    /// In `odom`, whose origin and heading are those at the start and whose z is up.
    pub pose: Pose3,
    /// Of the IMU in `odom`, m/s.
    pub velocity: Vector3<f64>,
    /// Of the IMU: rotation in its own frame, position in `odom`.
    pub covariance: Matrix6<f64>,
    /// Whether it can be trusted.
    pub status: Status,
    /// Directions along which the scan said little.
    pub loose: Vec<Vector3<f64>>,
    /// Points that lay on known planes.
    pub points: usize,
    /// Mean square of their residuals in deviations.
    pub fit: f64,
}

/// What came in that could not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refused {
    /// Samples of the IMU that are not finite, or not later than those before.
    pub imu: usize,
    /// Scans that are older than those before, or came without an IMU.
    pub scans: usize,
    /// Points that are not finite or too near.
    pub points: usize,
    /// Times without samples of the IMU.
    pub gaps: usize,
}

/// The odometry.
#[derive(Debug, Clone)]
pub struct LidarInertialOdometry {
    settings: Settings,
    start: Start,
    state: Option<(SimTime, State, Covariance)>,
    imu: VecDeque<ImuSample>,
    scans: VecDeque<LidarScan>,
    map: PlaneMap,
    /// Where the map was cut last.
    cut_at: Vector3<f64>,
    refused: Refused,
}

impl LidarInertialOdometry {
    /// Begins with nothing known.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            start: Start::default(),
            state: None,
            imu: VecDeque::new(),
            scans: VecDeque::new(),
            map: PlaneMap::default(),
            cut_at: Vector3::zeros(),
            refused: Refused::default(),
        }
    }

    /// What could not be used so far.
    pub fn refused(&self) -> Refused {
        self.refused
    }

    /// Number of cubes in the map.
    pub fn map_size(&self) -> usize {
        self.map.len()
    }

    /// Takes in a sample of the IMU; estimates for scans that waited for it.
    pub fn imu(&mut self, sample: ImuSample) -> Vec<Estimate> {
        let finite = sample.gyro.iter().chain(&sample.accel).all(|x| x.is_finite());
        if !finite || self.imu.back().is_some_and(|last| sample.stamp <= last.stamp) {
            self.refused.imu += 1;
            return Vec::new();
        }
        self.imu.push_back(sample);
        if self.state.is_none() {
            let begun = self.start.take(&sample, &self.settings);
            self.state = begun.map(|(state, covariance)| (sample.stamp, state, covariance));
            if self.state.is_none() {
                return Vec::new();
            }
        }
        self.estimates()
    }

    /// Takes in a scan; estimates for it and those before it, as far as the IMU has come.
    pub fn scan(&mut self, scan: LidarScan) -> Vec<Estimate> {
        let newest =
            self.scans.back().map(|last| last.stamp).or(self.state.as_ref().map(|(stamp, ..)| *stamp));
        let late = newest.is_some_and(|newest| end(&scan) <= newest);
        if late || self.scans.len() == WAITING {
            self.refused.scans += 1;
            return Vec::new();
        }
        self.scans.push_back(scan);
        self.estimates()
    }

    fn estimates(&mut self) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        while let (Some(scan), Some(imu), Some(_)) = (self.scans.front(), self.imu.back(), &self.state) {
            if imu.stamp < end(scan) {
                break;
            }
            let Some(scan) = self.scans.pop_front() else { break };
            match self.process(&scan) {
                Some(estimate) => estimates.push(estimate),
                None => self.refused.scans += 1,
            }
        }
        estimates
    }

    fn process(&mut self, scan: &LidarScan) -> Option<Estimate> {
        let (mut stamp, mut state, mut covariance) = self.state.take()?;
        let until = end(scan);
        if until <= stamp {
            self.state = Some((stamp, state, covariance));
            return None;
        }
        let nodes = self.travel(&mut stamp, &mut state, &mut covariance, until);
        let points = self.undistorted(scan, &state, &nodes);
        let chosen = thinned(&points, CORRECTING);
        let matched = update(&mut state, &mut covariance, &chosen, &self.map, &self.settings.lidar_noise);
        let good = matched.as_ref().is_some_and(|matched| matched.points >= FEW);
        if good || self.map.is_empty() {
            for point in thinned(&points, MAPPED) {
                let on_imu = state.mount_rotation * point + state.mount_position;
                self.map.add(state.rotation * on_imu + state.position);
            }
        }
        if (state.position - self.cut_at).amax() > REACH / 4.0 {
            self.map.forget(state.position, REACH);
            self.cut_at = state.position;
        }
        let loose = matched.as_ref().map_or(Vec::new(), |matched| matched.loose.clone());
        let estimate = Estimate {
            stamp,
            pose: pose(&state) * self.settings.imu.inverse(),
            velocity: state.velocity,
            covariance: covariance.fixed_view::<6, 6>(0, 0).into_owned(),
            status: if good && loose.is_empty() { Status::Tracking } else { Status::Coasting },
            loose,
            points: matched.as_ref().map_or(0, |matched| matched.points),
            fit: matched.as_ref().map_or(0.0, |matched| matched.fit),
        };
        self.state = Some((stamp, state, covariance));
        Some(estimate)
    }

    /// Moves the state on to `until` by the samples of the IMU; how it went.
    fn travel(
        &mut self,
        stamp: &mut SimTime,
        state: &mut State,
        covariance: &mut Covariance,
        until: SimTime,
    ) -> Vec<Node> {
        let mut nodes = Vec::new();
        while *stamp < until {
            // The samples round this instant; before the first and behind the last one they hold on.
            while self.imu.len() > 2 && self.imu[1].stamp <= *stamp {
                self.imu.pop_front();
            }
            let (before, behind) = (self.imu[0], self.imu[1.min(self.imu.len() - 1)]);
            let next = if behind.stamp > *stamp { behind.stamp.min(until) } else { until };
            let gap = behind.stamp.since(before.stamp) > GAP;
            let mean = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) + Vector3::from(b)) * 0.5;
            let (gyro, accel) = (mean(before.gyro, behind.gyro), mean(before.accel, behind.accel));
            let mut noise = self.settings.imu_noise;
            if gap {
                // Whatever happened in between.
                (noise.gyro, noise.accel) = (0.3, 1.0);
                self.refused.gaps += usize::from(next == behind.stamp);
            }
            nodes.push(propagate(state, covariance, &noise, *stamp, next, gyro, accel));
            *stamp = next;
        }
        nodes
    }

    /// The points of a scan in the LiDAR's frame of its end: FAST-LIO, equation 10.
    fn undistorted(&mut self, scan: &LidarScan, state: &State, nodes: &[Node]) -> Vec<Vector3<f64>> {
        let mount = Isometry3::from_parts(Translation3::from(state.mount_position), state.mount_rotation);
        let back = (pose(state) * mount).inverse();
        let (mut points, mut node) = (Vec::with_capacity(scan.points.len()), 0);
        let Some(first) = nodes.first() else { return points };
        for point in &scan.points {
            let raw = Vector3::from(point.xyz.map(f64::from));
            if !raw.iter().all(|x| x.is_finite()) || raw.norm() < self.settings.blind {
                self.refused.points += 1;
                continue;
            }
            let stamp = (scan.stamp + Duration::from_nanos(point.offset_ns.into())).max(first.stamp);
            // Points come in the order of their time, or nearly.
            while node > 0 && nodes[node].stamp > stamp {
                node -= 1;
            }
            while nodes.get(node + 1).is_some_and(|next| next.stamp <= stamp) {
                node += 1;
            }
            let then = nodes[node].later(stamp.since(nodes[node].stamp).as_secs_f64());
            points.push((back * (then * (mount * nalgebra::Point3::from(raw)))).coords);
        }
        points
    }
}

/// The IMU's pose in `odom`.
fn pose(state: &State) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(state.position), state.rotation)
}

/// When the last point of a scan was measured.
fn end(scan: &LidarScan) -> SimTime {
    let last = scan.points.iter().map(|point| point.offset_ns).max().unwrap_or_default();
    scan.stamp + Duration::from_nanos(last.into())
}

/// So many points at most, evenly chosen.
fn thinned(points: &[Vector3<f64>], most: usize) -> Vec<Vector3<f64>> {
    let step = points.len().div_ceil(most).max(1);
    points.iter().step_by(step).copied().collect()
}
