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
//! | [`moments`] | sums over points |
//! | [`planes`] | the map: planes in cubes |
//! | [`matching`] | which points lie on which planes |
//! | [`speed`] | what wheels say |
//! | [`mod@update`] | what a scan says about the state |
//! | `start` | the first state |

pub mod matching;
pub mod moments;
pub mod planes;
pub mod propagation;
pub mod so3;
pub mod speed;
mod start;
pub mod state;
pub mod update;

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, Matrix6, Vector3};
use openbench_core::{ImuSample, LidarScan, Pose3, SimTime};

use matching::Matching;
use planes::PlaneMap;
use propagation::{ImuNoise, Node, advance, propagate};
use speed::{Speed, correct};
use start::{First, Start};
use state::{Covariance, State, at};
use update::{LidarNoise, Matched, update};

/// No step of the IMU's way is longer, so that turns in it are small: seconds.
const STEP: Duration = Duration::from_millis(20);
/// With fewer points on known planes a scan says nothing.
const FEW: usize = 60;
/// Samples of the IMU farther apart than that leave a gap.
const GAP: Duration = Duration::from_millis(50);
/// Scans that wait for the IMU at most.
const WAITING: usize = 20;
/// So long the IMU waits for a scan that began before it; then the way goes on without.
const PATIENCE: Duration = Duration::from_millis(300);
/// A scan that ends so much later than the IMU has come is of another clock.
const AHEAD: Duration = Duration::from_secs(2);
/// After so long a time without the IMU nobody knows where it has gone.
const LOST: Duration = Duration::from_secs(2);
/// How far off everything may be then: metres and m/s, radians.
const LOST_DEVIATIONS: [f64; 2] = [100.0, 1.0];
/// Velocities farther than that from an instant say nothing about it, and so many of them wait at most.
const NEAR: Duration = Duration::from_millis(20);
const SPEEDS: usize = 1000;
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
    /// The IMU was silent for so long that nobody knows how the robot moved between the estimate before and this one. Those
    /// that follow are as good as ever, but relative to this one: the map was begun anew.
    Lost,
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
    /// Velocities that are not finite, or not later than those before.
    pub speeds: usize,
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
    speeds: VecDeque<Speed>,
    map: PlaneMap,
    matching: Matching,
    /// Where the map was cut last.
    cut_at: Vector3<f64>,
    refused: Refused,
}

impl LidarInertialOdometry {
    /// Begins with nothing known.
    pub fn new(settings: Settings) -> Self {
        Self {
            map: PlaneMap::new(settings.lidar_noise.range),
            matching: Matching::default(),
            settings,
            start: Start::default(),
            state: None,
            imu: VecDeque::new(),
            scans: VecDeque::new(),
            speeds: VecDeque::new(),
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
        let lost = self.imu.back().is_some_and(|last| sample.stamp.since(last.stamp) > LOST);
        self.imu.push_back(sample);
        if lost && self.state.is_some() {
            return self.lose(sample.stamp).into_iter().collect();
        }
        if self.state.is_some() {
            return self.estimates();
        }
        let Some(first) = self.start.take(&sample, &self.settings) else { return Vec::new() };
        let mut estimates = self.begin(sample.stamp, first);
        estimates.append(&mut self.estimates());
        estimates
    }

    /// The first state. What was seen from where the robot stood makes the map's beginning; what was seen on the way to it has no place.
    fn begin(&mut self, stamp: SimTime, first: First) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        while self.scans.front().is_some_and(|scan| end(scan) <= stamp) {
            let Some(scan) = self.scans.pop_front() else { break };
            if first.at_rest.is_none_or(|since| scan.stamp < since) {
                self.refused.scans += 1;
                continue;
            }
            let points = scan.points.iter().map(|point| Vector3::from(point.xyz.map(f64::from)));
            let points: Vec<_> = points.filter(|point| self.usable(point)).collect();
            self.refused.points += scan.points.len() - points.len();
            self.matching.find(
                &first.state,
                &first.covariance,
                &points,
                &self.map,
                &self.settings.lidar_noise,
            );
            self.matching.insert(&first.state, &mut self.map);
            estimates.push(self.estimate(
                end(&scan),
                &first.state,
                &first.covariance,
                None,
                Status::Tracking,
            ));
        }
        self.state = Some((stamp, first.state, first.covariance));
        estimates
    }

    /// Takes in a velocity, such as wheels show. It counts once the IMU and a scan have come as far.
    pub fn speed(&mut self, speed: Speed) {
        let late = self.speeds.back().is_some_and(|last| speed.stamp <= last.stamp);
        if !speed.is_sound() || late || self.speeds.len() == SPEEDS {
            self.refused.speeds += 1;
            return;
        }
        self.speeds.push_back(speed);
    }

    /// The pose that the IMU has come to since the last estimate, and when; `None` before the start.
    pub fn now(&self) -> Option<(SimTime, Pose3)> {
        let (stamp, state, _) = self.state.as_ref()?;
        let (mut stamp, mut state) = (*stamp, state.clone());
        for (before, behind) in self.imu.iter().zip(self.imu.iter().skip(1)) {
            if behind.stamp > stamp {
                advance(
                    &mut state,
                    stamp,
                    behind.stamp,
                    mean(before.gyro, behind.gyro),
                    mean(before.accel, behind.accel),
                );
                stamp = behind.stamp;
            }
        }
        Some((stamp, pose(&state) * self.settings.imu.inverse()))
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

    /// Goes on from where the robot was, though it may be elsewhere by now.
    fn lose(&mut self, stamp: SimTime) -> Option<Estimate> {
        let (_, mut state, mut covariance) = self.state.take()?;
        state.velocity = Vector3::zeros();
        let [far, turned] = LOST_DEVIATIONS;
        for (first, deviation) in [(at::ROTATION, turned), (at::POSITION, far), (at::VELOCITY, far)] {
            (first..first + 3).for_each(|i| covariance[(i, i)] += deviation * deviation);
        }
        self.map = PlaneMap::new(self.settings.lidar_noise.range);
        self.imu.drain(..self.imu.len() - 1);
        self.refused.gaps += 1;
        self.refused.scans += self.scans.len();
        self.scans.clear();
        self.speeds.clear();
        let estimate = self.estimate(stamp, &state, &covariance, None, Status::Lost);
        self.state = Some((stamp, state, covariance));
        Some(estimate)
    }

    fn estimates(&mut self) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        while let (Some(scan), Some(imu)) = (self.scans.front(), self.imu.back()) {
            if end(scan) <= imu.stamp + AHEAD {
                break;
            }
            self.scans.pop_front();
            self.refused.scans += 1;
        }
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
        estimates.extend(self.without_scans());
        estimates
    }

    /// Where no scan comes, the way goes on by IMU and wheels.
    fn without_scans(&mut self) -> Option<Estimate> {
        let newest = self.imu.back()?.stamp;
        let (mut stamp, mut state, mut covariance) = self.state.take()?;
        let waited = newest.since(stamp) > PATIENCE && self.scans.is_empty();
        let estimate = waited.then(|| {
            self.travel(&mut stamp, &mut state, &mut covariance, newest);
            self.estimate(stamp, &state, &covariance, None, Status::Coasting)
        });
        self.state = Some((stamp, state, covariance));
        estimate
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
        let first = self.map.is_empty();
        let matched = update(
            &mut state,
            &mut covariance,
            &points,
            &self.map,
            &self.settings.lidar_noise,
            self.settings.estimate_lidar,
            &mut self.matching,
        );
        let good = matched.as_ref().is_some_and(|matched| matched.points >= FEW);
        if good || first {
            self.matching.insert(&state, &mut self.map);
        }
        if (state.position - self.cut_at).amax() > REACH / 4.0 {
            self.map.forget(state.position, REACH);
            self.cut_at = state.position;
        }
        let firm = matched.as_ref().is_some_and(|matched| matched.loose.is_empty());
        let status = if first || good && firm { Status::Tracking } else { Status::Coasting };
        let estimate = self.estimate(stamp, &state, &covariance, matched, status);
        self.state = Some((stamp, state, covariance));
        Some(estimate)
    }

    fn estimate(
        &self,
        stamp: SimTime,
        state: &State,
        covariance: &Covariance,
        matched: Option<Matched>,
        status: Status,
    ) -> Estimate {
        let (points, fit) = matched.as_ref().map_or((0, 0.0), |matched| (matched.points, matched.fit));
        Estimate {
            stamp,
            pose: pose(state) * self.settings.imu.inverse(),
            velocity: state.velocity,
            covariance: covariance.fixed_view::<6, 6>(0, 0).into_owned(),
            status,
            loose: matched.map_or(Vec::new(), |matched| matched.loose),
            points,
            fit,
        }
    }

    /// Whether a point is none of the robot itself.
    fn usable(&self, point: &Vector3<f64>) -> bool {
        point.iter().all(|x| x.is_finite()) && point.norm() >= self.settings.blind
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
            let next = next.min(*stamp + STEP);
            let speed = self.speeds.iter().map(|speed| speed.stamp).find(|speed| *speed > *stamp);
            let next = speed.map_or(next, |speed| next.min(speed));
            let gap = behind.stamp.since(before.stamp) > GAP;
            let (gyro, accel) = (mean(before.gyro, behind.gyro), mean(before.accel, behind.accel));
            let mut noise = self.settings.imu_noise;
            if gap {
                // Whatever happened in between.
                (noise.gyro, noise.accel) = (0.3, 1.0);
                self.refused.gaps += usize::from(next == behind.stamp);
            }
            nodes.push(propagate(state, covariance, &noise, *stamp, next, gyro, accel));
            *stamp = next;
            while self.speeds.front().is_some_and(|speed| speed.stamp <= next) {
                let speed = self.speeds.pop_front().filter(|speed| next.since(speed.stamp) < NEAR);
                speed
                    .into_iter()
                    .for_each(|speed| correct(state, covariance, &self.settings.imu, gyro, &speed));
            }
        }
        nodes
    }

    /// The points of a scan in the LiDAR's frame of its end: FAST-LIO, equation 10.
    fn undistorted(&mut self, scan: &LidarScan, state: &State, nodes: &[Node]) -> Vec<Vector3<f64>> {
        let mount = Isometry3::from_parts(state.mount_position.into(), state.mount_rotation);
        let at_end = pose(state) * mount;
        let passages: Vec<_> = nodes.iter().map(|node| node.seen_from(&at_end)).collect();
        let turn = mount.rotation.to_rotation_matrix();
        let (mut points, mut node) = (Vec::with_capacity(scan.points.len()), 0);
        let Some(first) = nodes.first() else { return points };
        for point in &scan.points {
            let raw = Vector3::from(point.xyz.map(f64::from));
            if !self.usable(&raw) {
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
            let since = stamp.since(nodes[node].stamp).as_secs_f64();
            points.push(passages[node].at(since, turn * raw + mount.translation.vector));
        }
        points
    }
}

fn mean(a: [f64; 3], b: [f64; 3]) -> Vector3<f64> {
    (Vector3::from(a) + Vector3::from(b)) * 0.5
}

/// The IMU's pose in `odom`.
fn pose(state: &State) -> Isometry3<f64> {
    Isometry3::from_parts(state.position.into(), state.rotation)
}

/// When the last point of a scan was measured.
fn end(scan: &LidarScan) -> SimTime {
    let last = scan.points.iter().map(|point| point.offset_ns).max().unwrap_or_default();
    scan.stamp + Duration::from_nanos(last.into())
}
