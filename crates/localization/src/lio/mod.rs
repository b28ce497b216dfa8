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
//! | `drift` | how far off the map is by now, and how it leans |
//! | [`propagation`] | where the IMU says that it moves to |
//! | [`moments`] | sums over points |
//! | `inertial`, `limits` | what IMU and wheels said; an IMU at the end of its range |
//! | [`planes`] | the map: planes in cubes |
//! | [`matching`] | which points lie on which planes |
//! | [`speed`] | what wheels say |
//! | [`mod@update`] | what a scan says about the state |
//! | `scatter` | how noisy the LiDAR turns out to be |
//! | `start` | the first state |
//! | `watch` | whether the way is one that the robot can have gone |

mod drift;
mod inertial;
mod limits;
pub mod matching;
pub mod moments;
pub mod planes;
pub mod propagation;
mod scatter;
pub mod so3;
pub mod speed;
mod start;
pub mod state;
pub mod update;
mod watch;

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, Matrix6, Vector3};
use openbench_core::{ImuSample, LidarPoint, LidarScan, Pose3, SimTime};
use serde::Serialize;

use drift::Drift;
use inertial::{Inertial, Known};
use limits::Limits;
use matching::Matching;
use planes::PlaneMap;
use propagation::{ImuNoise, Node};
use so3::log;
use speed::Speed;
use start::{First, Start};
use state::{State, at};
use update::{LidarNoise, Matched, update};
use watch::{Reckoned, Verdict, Watch};

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
/// A scan is gone through that often where the gyroscope was at its limit: what it did not show is seen in how the scan lies.
const PASSES: usize = 3;
/// Directions of which a scan that is not there says nothing.
const UNSEEN: [Vector3<f64>; 3] = [
    Vector3::new(1.0, 0.0, 0.0),
    Vector3::new(0.0, 1.0, 0.0),
    Vector3::new(0.0, 0.0, 1.0),
];
/// Turn rate that is still unknown then, rad/s.
const UNSEEN_TURN: f64 = 0.05;
/// Turned by less than that it lies well, radians.
const LIES_WELL: f64 = 1e-3;
/// A map that leans more is of no use, radians.
const STEEPEST: f64 = 0.02;
/// Mean over about so many scans, as one over it.
const RECENT: f64 = 1.0 / 30.0;
/// [`Matched::surprise`] above which, on average, scans and IMU contradict each other, and what one
/// scan counts at most. In a dozen seconds of turns (`tests/lio.rs`) a LiDAR that is turned by
/// 0.1 rad about a level axis brings the mean to 22 and more, by 0.4 about the upright one to 14.
/// In eighteen drives with right sensors it stays below 2: windows of two towns, the built-in
/// worlds, `avenue` of `benchmarks/odometry`, full turns, an IMU at its limits. Straight on nothing
/// is noticed.
const DISPUTED: f64 = 6.0;
const SHOCK: f64 = 100.0;
/// How far off a way is that wheels and gyroscope alone reckon: metres, and the part of the way; radians, and the part of the
/// turn.
const RECKONED: [f64; 4] = [0.05, 0.05, 0.01, 0.05];
/// So long after it was begun anew the filter is not to be trusted.
const SETTLED: Duration = Duration::from_secs(3);
/// No LiDAR sees farther, metres.
const FARTHEST: f64 = 1e4;
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
    /// What the IMU can show at most, rad/s and m/s²; if that is not known, the same largest number again and again is taken for it.
    pub imu_limits: Option<[f64; 2]>,
    /// What is wrong with the LiDAR.
    pub lidar_noise: LidarNoise,
    /// How fast it drives as a rule, m/s: all there is to go by along directions of which neither scans nor wheels say anything.
    pub typical_speed: f64,
    /// Points nearer than that are of the robot itself, metres.
    pub blind: f64,
}

/// How sure the odometry is of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The scan agrees with the map.
    Tracking,
    /// The scan agrees with the map, but scans and IMU have contradicted each other for a while: a sensor sits elsewhere or is turned otherwise than is believed, has another clock, or
    /// shows other units. The pose's heading, lean and covariance are then not to be trusted.
    Disputed,
    /// The scan agrees with the map, but its points are scattered several times as widely as the LiDAR's are thought to be: they
    /// count less, and the pose is known worse.
    Noisy,
    /// The scan says nothing, or not along all directions, or it contradicts the map: the pose is the IMU's, and its covariance grows.
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
    /// Of the IMU: rotation in its own frame, position in `odom`; grows with the way, but for roll and pitch, which gravity tells.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Refused {
    /// Samples of the IMU that are not finite or larger than any IMU's, or not later than those before.
    pub imu: usize,
    /// Scans that are older than those before, or came without an IMU.
    pub scans: usize,
    /// Velocities that are not finite or faster than anything drives, or not later than those before.
    pub speeds: usize,
    /// Points that are not finite, too near or farther than any LiDAR sees.
    pub points: usize,
    /// Times without samples of the IMU.
    pub gaps: usize,
    /// Times that the filter ran away from what wheels and gyroscope say, and was begun anew by these.
    pub runaways: usize,
}

/// The odometry.
#[derive(Debug, Clone)]
pub struct LidarInertialOdometry {
    settings: Settings,
    start: Start,
    known: Option<Known>,
    inertial: Inertial,
    scans: VecDeque<LidarScan>,
    /// Turn rate that the gyroscope did not show in the last scan, rad/s.
    missing: Vector3<f64>,
    map: PlaneMap,
    drift: Drift,
    matching: Matching,
    /// Directions of which the last scan said nothing.
    unseen: Vec<Vector3<f64>>,
    /// Where the map was cut last.
    cut_at: Vector3<f64>,
    /// Mean of [`Matched::surprise`] over the last scans.
    surprise: f64,
    watch: Watch,
    /// When it last began anew because it had run away.
    recovered: Option<SimTime>,
    refused: Refused,
}

impl LidarInertialOdometry {
    /// Begins with nothing known.
    pub fn new(settings: Settings) -> Self {
        Self {
            map: PlaneMap::new(settings.lidar_noise),
            drift: Drift::default(),
            matching: Matching::default(),
            inertial: Inertial::new(Limits::new(settings.imu_limits)),
            settings,
            start: Start::default(),
            known: None,
            scans: VecDeque::new(),
            missing: Vector3::zeros(),
            unseen: Vec::new(),
            cut_at: Vector3::zeros(),
            surprise: 0.0,
            watch: Watch::default(),
            recovered: None,
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
        let lost = self
            .inertial
            .newest()
            .is_some_and(|newest| sample.stamp.since(newest) > LOST);
        if !self.inertial.push(sample) {
            self.refused.imu += 1;
            return Vec::new();
        }
        if self.known.is_some() {
            return if lost {
                self.lose(sample.stamp).into_iter().collect()
            } else {
                self.estimates()
            };
        }
        let Some(first) = self.start.take(&sample, &self.settings) else {
            return Vec::new();
        };
        let mut estimates = self.begin(sample.stamp, first);
        estimates.append(&mut self.estimates());
        estimates
    }

    /// The first state. What was seen from where the robot stood makes the map's beginning; what was seen on the way to it has no place.
    fn begin(&mut self, stamp: SimTime, first: First) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        let mut known = Known {
            stamp,
            state: first.state,
            covariance: first.covariance,
        };
        while self.scans.front().is_some_and(|scan| end(scan) <= stamp) {
            let Some(scan) = self.scans.pop_front() else {
                break;
            };
            if first.at_rest.is_none_or(|since| scan.stamp < since) {
                self.refused.scans += 1;
                continue;
            }
            let points: Vec<_> = scan
                .points
                .iter()
                .map(position)
                .filter(|point| self.usable(point))
                .collect();
            self.refused.points += scan.points.len() - points.len();
            known.stamp = end(&scan);
            let noise = &self.settings.lidar_noise;
            self.matching.find(
                &known.state,
                &known.covariance,
                &points,
                &self.map,
                noise,
                f64::INFINITY,
            );
            self.matching.insert(&known.state, &mut self.map);
            estimates.push(self.estimate(&known, None, Status::Tracking));
        }
        self.known = Some(Known { stamp, ..known });
        estimates
    }

    /// Takes in a velocity, such as wheels show. It counts once the IMU and a scan have come as far.
    pub fn speed(&mut self, speed: Speed) {
        self.refused.speeds += usize::from(!self.inertial.push_speed(speed));
    }

    /// The pose that the IMU has come to since the last estimate, and when; `None` before the start.
    pub fn now(&self) -> Option<(SimTime, Pose3)> {
        let (stamp, state) = self.inertial.extrapolate(self.known.as_ref()?);
        Some((stamp, pose(&state) * self.settings.imu.inverse()))
    }

    /// Takes in a scan; estimates for it and those before it, as far as the IMU has come.
    pub fn scan(&mut self, scan: LidarScan) -> Vec<Estimate> {
        let newest = self
            .scans
            .back()
            .map(|last| last.stamp)
            .or(self.known.as_ref().map(|known| known.stamp));
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
        let mut known = self.known.take()?;
        known.stamp = stamp;
        known.state.velocity = Vector3::zeros();
        let [far, turned] = LOST_DEVIATIONS;
        for (first, deviation) in [
            (at::ROTATION, turned),
            (at::POSITION, far),
            (at::VELOCITY, far),
        ] {
            (first..first + 3).for_each(|i| known.covariance[(i, i)] += deviation * deviation);
        }
        self.drift.lose(&mut known, turned, far);
        self.map = PlaneMap::new(self.settings.lidar_noise);
        self.inertial.clear();
        self.watch.clear();
        self.refused.gaps += 1;
        self.refused.scans += self.scans.len();
        self.scans.clear();
        let estimate = self.estimate(&known, None, Status::Lost);
        self.known = Some(known);
        Some(estimate)
    }

    fn estimates(&mut self) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        let Some(newest) = self.inertial.newest() else {
            return estimates;
        };
        while self
            .scans
            .front()
            .is_some_and(|scan| end(scan) > newest + AHEAD)
        {
            self.scans.pop_front();
            self.refused.scans += 1;
        }
        while self.scans.front().is_some_and(|scan| end(scan) <= newest) && self.known.is_some() {
            let Some(scan) = self.scans.pop_front() else {
                break;
            };
            match self.process(&scan) {
                Some(estimate) => estimates.push(estimate),
                None => self.refused.scans += 1,
            }
        }
        estimates.extend(self.without_scans(newest));
        estimates
    }

    /// Where no scan comes, the way goes on by IMU and wheels.
    fn without_scans(&mut self, newest: SimTime) -> Option<Estimate> {
        let known = self.known.as_mut()?;
        if newest.since(known.stamp) <= PATIENCE || !self.scans.is_empty() {
            return None;
        }
        let since = newest.since(known.stamp);
        self.inertial
            .travel(known, newest, &self.settings, Vector3::zeros());
        known.temper(&UNSEEN, &self.settings, since);
        self.refused.gaps += self.inertial.forget(newest);
        let known = self.known.as_ref()?;
        Some(self.estimate(known, None, Status::Coasting))
    }

    fn process(&mut self, scan: &LidarScan) -> Option<Estimate> {
        let until = end(scan);
        let before = self.known.clone().filter(|known| known.stamp < until)?;
        let (first, since) = (self.map.is_empty(), before.stamp);
        let (mut known, mut matched, mut used) = (before.clone(), None, 0);
        let step = self
            .inertial
            .reckon(since, until, before.state.gyro_bias, &self.settings.imu);
        let noise = self.settings.lidar_noise;
        for _ in 0..PASSES {
            known = before.clone();
            let way = self
                .inertial
                .travel(&mut known, until, &self.settings, self.missing);
            let points = self.undistorted(scan, &known.state, &way.nodes);
            used = points.len();
            let expected = known.state.rotation;
            let mount = self.settings.estimate_lidar;
            matched = update(
                &mut known,
                &points,
                &self.map,
                &noise,
                mount,
                &mut self.matching,
            );
            let unseen = UNSEEN_TURN * way.blind.as_secs_f64();
            (0..3).filter(|axis| way.axes[*axis]).for_each(|axis| {
                known.covariance[(at::ROTATION + axis, at::ROTATION + axis)] += unseen * unseen
            });
            if way.blind.is_zero() {
                self.missing = Vector3::zeros();
                break;
            }
            let turned = log(expected.inverse() * known.state.rotation);
            if matched.is_none() || turned.norm() < LIES_WELL {
                break;
            }
            let rate = turned / way.blind.as_secs_f64();
            (0..3)
                .filter(|axis| way.axes[*axis])
                .for_each(|axis| self.missing[axis] += rate[axis]);
        }
        self.refused.gaps += self.inertial.forget(until);
        self.refused.points += scan.points.len() - used;
        let good = matched.as_ref().is_some_and(Matched::is_good);
        matched
            .iter()
            .for_each(|matched| self.matching.scatter.look(matched));
        if !good {
            // What contradicts the map is not believed.
            known = before.clone();
            self.inertial
                .travel(&mut known, until, &self.settings, self.missing);
        }
        let unseen = matched
            .as_ref()
            .filter(|_| good)
            .map_or(&UNSEEN[..], |matched| &matched.loose)
            .to_vec();
        let expected = std::mem::replace(&mut self.unseen, unseen);
        if good && self.unseen.is_empty() && !expected.is_empty() {
            self.drift.keep(&before, &known, &expected);
        }
        known.temper(&self.unseen, &self.settings, until.since(since));
        if known.state.map_tilt.norm() > STEEPEST {
            // Its points were put in at another lean than they are seen at now: it is begun anew.
            self.map = PlaneMap::new(self.settings.lidar_noise);
            drift::upright(&mut known);
        } else if good || first {
            let new = self.matching.insert(&known.state, &mut self.map);
            self.drift.grow(&mut known, new, &self.unseen);
        }
        self.cut(known.state.position);
        let firm = matched
            .as_ref()
            .is_some_and(|matched| matched.loose.is_empty());
        if let Some(matched) = matched.as_ref().filter(|_| good) {
            self.surprise += (matched.surprise.min(SHOCK) - self.surprise) * RECENT;
        }
        let verdict = step.map_or(Verdict::Sound, |step| {
            self.watch
                .look(&known, &step, first || good, &self.settings.imu)
        });
        if let (Verdict::RunAway, Some(step)) = (verdict, step) {
            known = self.recover(&step).unwrap_or(known);
        }
        let shaken = self.recovered.is_some_and(|at| until.since(at) < SETTLED);
        let disputed = shaken || verdict == Verdict::Contradicted || self.surprise > DISPUTED;
        let status = match first || good && firm {
            true if disputed => Status::Disputed,
            true if self.matching.scatter.is_wide() => Status::Noisy,
            true => Status::Tracking,
            false => Status::Coasting,
        };
        let estimate = self.estimate(&known, matched, status);
        self.known = Some(known);
        Some(estimate)
    }

    /// Begins anew from the last state that agreed with everything, moved on by wheels and gyroscope, with a new map: the
    /// old one may have been put in on the way that was none.
    fn recover(&mut self, step: &Reckoned) -> Option<Known> {
        let (mut known, metres, turned) = self.watch.recover(&self.settings.imu)?;
        let base = known.state.rotation * self.settings.imu.rotation.inverse();
        known.state.velocity = base * step.velocity;
        let [level, turn] = [
            RECKONED[0] + RECKONED[1] * metres,
            RECKONED[2] + RECKONED[3] * turned,
        ];
        for (first, deviation) in [(at::ROTATION, RECKONED[2]), (at::VELOCITY, level)] {
            (first..first + 3).for_each(|i| known.covariance[(i, i)] += deviation * deviation);
        }
        self.drift.lose(&mut known, turn, level);
        self.map = PlaneMap::new(self.settings.lidar_noise);
        self.watch.restart(&known, &self.settings.imu);
        self.surprise = 0.0;
        self.recovered = Some(known.stamp);
        self.refused.runaways += 1;
        Some(known)
    }

    /// Forgets what is far away, now and then.
    fn cut(&mut self, position: Vector3<f64>) {
        if (position - self.cut_at).amax() > REACH / 4.0 {
            self.map.forget(position, REACH);
            self.cut_at = position;
        }
    }

    fn estimate(&self, known: &Known, matched: Option<Matched>, status: Status) -> Estimate {
        let (points, fit) = matched
            .as_ref()
            .map_or((0, 0.0), |matched| (matched.points, matched.fit));
        Estimate {
            stamp: known.stamp,
            pose: pose(&known.state) * self.settings.imu.inverse(),
            velocity: known.state.velocity,
            covariance: self.drift.told(known),
            status,
            loose: matched.map_or(Vec::new(), |matched| matched.loose),
            points,
            fit,
        }
    }

    /// Whether a point is none of the robot itself.
    fn usable(&self, point: &Vector3<f64>) -> bool {
        (self.settings.blind..=FARTHEST).contains(&point.norm())
    }

    /// The points of a scan in the LiDAR's frame of its end: FAST-LIO, equation 10.
    fn undistorted(&self, scan: &LidarScan, state: &State, nodes: &[Node]) -> Vec<Vector3<f64>> {
        let mount = Isometry3::from_parts(state.mount_position.into(), state.mount_rotation);
        let at_end = pose(state) * mount;
        let passages: Vec<_> = nodes.iter().map(|node| node.seen_from(&at_end)).collect();
        let turn = mount.rotation.to_rotation_matrix();
        let (mut points, mut node) = (Vec::with_capacity(scan.points.len()), 0);
        let Some(first) = nodes.first() else {
            return points;
        };
        for point in &scan.points {
            let raw = position(point);
            if !self.usable(&raw) {
                continue;
            }
            let stamp =
                (scan.stamp + Duration::from_nanos(point.offset_ns.into())).max(first.stamp);
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

fn position(point: &LidarPoint) -> Vector3<f64> {
    Vector3::from(point.xyz.map(f64::from))
}

/// The IMU's pose in `odom`.
fn pose(state: &State) -> Isometry3<f64> {
    Isometry3::from_parts(state.position.into(), state.rotation)
}

/// When the last point of a scan was measured.
fn end(scan: &LidarScan) -> SimTime {
    let last = scan
        .points
        .iter()
        .map(|point| point.offset_ns)
        .max()
        .unwrap_or_default();
    scan.stamp + Duration::from_nanos(last.into())
}
