//! What becomes of a scan: the pipeline of the odometry.
//!
//! After algorithm 1 of FAST-LIO (W. Xu, F. Zhang 2021): predict, undistort, match and update. The
//! map is VoxelMap's (C. Yuan et al. 2022). What is beyond the papers: a saturated gyroscope, scans
//! that contradict the map, degenerate scenes, a map that drifts and tilts, and a watchdog.

use std::time::Duration;

use nalgebra::{UnitQuaternion, Vector3};
use openbench_core::{LidarScan, Pose3, SimTime};

use super::belief::Belief;
use super::drift::{Drift, set_map_upright};
use super::estimate::{Estimate, Refused, Status};
use super::inertial::{GyroSaturation, Inertial, Prediction};
use super::matching::Matching;
use super::planes::PlaneMap;
use super::reckoning::Reckoned;
use super::registration::{Scene, register};
use super::scan_match::ScanMatch;
use super::settings::Settings;
use super::state::at;
use super::undistortion::{end_of, undistort, usable_points};
use super::unmeasured_turn::{UnmeasuredTurn, add_uncertainty};
use super::velocity_update::limit_velocity;
use super::watchdog::{Verdict, Watchdog};
use crate::deviation::PoseDeviation;

/// A scan is registered at most this many times while the gyroscope is saturated.
const MAX_PASSES: usize = 3;
/// Directions along which a scan that is missing or rejected measures nothing.
const ALL_DIRECTIONS: [Vector3<f64>; 3] = [
    Vector3::new(1.0, 0.0, 0.0),
    Vector3::new(0.0, 1.0, 0.0),
    Vector3::new(0.0, 0.0, 1.0),
];
/// A map that is tilted more is of no use, radians.
const MAX_MAP_TILT_RAD: f64 = 0.02;
/// The map reaches this far, metres. It is trimmed each time that the robot has come a quarter of
/// it.
const MAP_REACH_M: f64 = 150.0;

/// Weight of a new scan in the mean innovation: one over the number of scans that it is taken over.
const SCAN_WEIGHT: f64 = 1.0 / 30.0;
/// A single scan's innovation counts as no more than this.
const MAX_INNOVATION: f64 = 100.0;
/// Mean innovation above which scans and IMU contradict each other.
///
/// In a dozen seconds of turns (`tests/lio.rs`) a LiDAR that is rotated by 0.1 rad about a level
/// axis brings the mean to 22 and more, by 0.4 about the vertical one to 14. In eighteen drives
/// with right sensors it stays below 2: windows of two towns, the built-in worlds, `avenue` of
/// `benchmarks/odometry`, full turns, an IMU at its limits. Straight on nothing is noticed.
const DISPUTED_INNOVATION: f64 = 6.0;

/// How far off the pose may be after a time without the IMU.
const LOST: PoseDeviation = PoseDeviation {
    metres: 100.0,
    radians: 1.0,
};
/// How fast the robot may be then, m/s.
const LOST_M_S: f64 = 100.0;
/// How far off a pose may be that wheels and gyroscope alone reckoned,
const RECKONED: PoseDeviation = PoseDeviation {
    metres: 0.05,
    radians: 0.01,
};
/// and this share of the distance driven,
const RECKONED_PER_METRE: f64 = 0.05;
/// and this share of the angle turned.
const RECKONED_PER_RADIAN: f64 = 0.05;
/// The filter is not trusted for this time after a restart.
const SETTLING: Duration = Duration::from_secs(3);

/// The odometry between samples of the IMU and estimates.
#[derive(Debug, Clone)]
pub(super) struct Pipeline {
    pub(super) settings: Settings,
    pub(super) inertial: Inertial,
    /// What is known since the last scan; `None` before the start.
    pub(super) belief: Option<Belief>,
    pub(super) refused: Refused,
    unmeasured_turn: UnmeasuredTurn,
    map: PlaneMap,
    matching: Matching,
    drift: Drift,
    /// Directions along which the last scan measured nothing.
    degenerate: Vec<Vector3<f64>>,
    /// Where the map was trimmed last.
    trimmed_at: Vector3<f64>,
    /// Mean of [`ScanMatch::innovation`] over the last scans.
    innovation: f64,
    watchdog: Watchdog,
    /// When the filter was restarted last, since it had diverged.
    restarted: Option<SimTime>,
}

/// What is known before a scan is processed.
struct Step {
    before: Belief,
    /// Time of the scan's last point.
    end: SimTime,
    /// Whether the map is empty, so that the scan begins it.
    is_first: bool,
    /// Motion by wheels and gyroscope alone.
    reckoned: Option<Reckoned>,
}

/// A scan on the map.
struct Registered {
    belief: Belief,
    /// `None` if the update had no solution.
    matched: Option<ScanMatch>,
    /// Number of points that were used.
    points: usize,
    /// Of the gyroscope during the scan.
    saturation: GyroSaturation,
    /// Rotation of the predicted pose by the scan.
    correction: UnitQuaternion<f64>,
}

impl Registered {
    /// Rotation of the predicted pose by the scan, if that had a solution.
    fn correction(&self) -> Option<UnitQuaternion<f64>> {
        self.matched.as_ref().map(|_| self.correction)
    }

    /// The match, if the scan says something and does not contradict the map.
    fn accepted(&self) -> Option<&ScanMatch> {
        self.matched.as_ref().filter(|matched| matched.is_good())
    }

    /// Whether the scan measures the position along all directions.
    fn is_complete(&self) -> bool {
        self.matched
            .as_ref()
            .is_some_and(|matched| matched.degenerate.is_empty())
    }
}

impl Pipeline {
    pub(super) fn new(settings: Settings) -> Self {
        Self {
            map: PlaneMap::new(settings.lidar_noise),
            inertial: Inertial::new(settings.imu_limits),
            settings,
            belief: None,
            refused: Refused::default(),
            unmeasured_turn: UnmeasuredTurn::default(),
            matching: Matching::default(),
            drift: Drift::default(),
            degenerate: Vec::new(),
            trimmed_at: Vector3::zeros(),
            innovation: 0.0,
            watchdog: Watchdog::default(),
            restarted: None,
        }
    }

    /// Number of cubes in the map.
    pub(super) fn map_size(&self) -> usize {
        self.map.len()
    }

    /// Pose of the robot's frame at the newest sample of the IMU, and when that was; `None` before
    /// the start.
    pub(super) fn newest_pose(&self) -> Option<(SimTime, Pose3)> {
        let (stamp, state) = self.inertial.extrapolate(self.belief.as_ref()?);
        Some((stamp, state.imu_pose() * self.settings.imu.inverse()))
    }

    /// Processes a scan; `None` if it is not later than the last.
    pub(super) fn process(&mut self, scan: &LidarScan) -> Option<Estimate> {
        let step = self.begin_step(scan)?;
        let mut registered = self.register(scan, &step);
        self.release_used_data(scan, &step, &registered);
        self.learn_noise(&registered);
        self.reject_contradiction(&step, &mut registered);
        self.note_degenerate_directions(&step, &registered);
        self.limit_unmeasured_velocity(&step, &mut registered.belief);
        self.update_map(&step, &mut registered);
        self.trim_map(&registered.belief);
        self.average_innovation(&registered);
        let verdict = self.judge(&step, &mut registered);
        let status = self.status(&step, &registered, verdict);
        Some(self.finish(registered, status))
    }

    fn begin_step(&self, scan: &LidarScan) -> Option<Step> {
        let end = end_of(scan);
        let before = self.belief.clone().filter(|belief| belief.stamp < end)?;
        let bias = before.state.gyro_bias;
        let reckoned = self
            .inertial
            .reckon(before.stamp, end, bias, &self.settings.imu);
        Some(Step {
            before,
            end,
            is_first: self.map.is_empty(),
            reckoned,
        })
    }

    /// Registers a scan. While the gyroscope is saturated, the scan shows which part of the turn
    /// was not measured, and the registration is repeated with it.
    fn register(&mut self, scan: &LidarScan, step: &Step) -> Registered {
        let mut pass = 1;
        loop {
            let registered = self.register_once(scan, step);
            let correction = registered.correction();
            let is_refined = self
                .unmeasured_turn
                .refine(&registered.saturation, correction);
            if !is_refined || pass == MAX_PASSES {
                return registered;
            }
            pass += 1;
        }
    }

    /// Predict, undistort, match and update: FAST-LIO, algorithm 1.
    fn register_once(&mut self, scan: &LidarScan, step: &Step) -> Registered {
        let mut belief = step.before.clone();
        let prediction = self.predict(&mut belief, step.end);
        let predicted = belief.state.rotation;
        let points = undistort(scan, &belief.state, &prediction.nodes, self.settings.blind);
        let scene = Scene {
            points: &points,
            map: &self.map,
            noise: &self.settings.lidar_noise,
            estimate_lidar: self.settings.estimate_lidar,
        };
        let matched = register(&mut belief, &scene, &mut self.matching);
        add_uncertainty(&mut belief, &prediction.saturation);
        Registered {
            correction: predicted.inverse() * belief.state.rotation,
            belief,
            matched,
            points: points.len(),
            saturation: prediction.saturation,
        }
    }

    fn predict(&self, belief: &mut Belief, until: SimTime) -> Prediction {
        let unmeasured = self.unmeasured_turn.rate();
        self.inertial
            .predict(belief, until, &self.settings, unmeasured)
    }

    /// Drops what the scan has used up, and counts what it could not use.
    fn release_used_data(&mut self, scan: &LidarScan, step: &Step, registered: &Registered) {
        self.refused.gaps += self.inertial.forget(step.end);
        self.refused.points += scan.points.len() - registered.points;
    }

    fn learn_noise(&mut self, registered: &Registered) {
        if let Some(matched) = &registered.matched {
            self.matching.noise_scale.learn(matched);
        }
    }

    /// A scan that contradicts the map is not trusted: the prediction stays.
    fn reject_contradiction(&self, step: &Step, registered: &mut Registered) {
        if registered.accepted().is_none() {
            registered.belief = step.before.clone();
            self.predict(&mut registered.belief, step.end);
        }
    }

    /// Notes along which directions the scan measured nothing. Where all directions are measured
    /// again, the map of meanwhile stays as uncertain as the position was.
    fn note_degenerate_directions(&mut self, step: &Step, registered: &Registered) {
        let accepted = registered.accepted();
        let degenerate = accepted.map_or(&ALL_DIRECTIONS[..], |matched| &matched.degenerate);
        let unknown = std::mem::replace(&mut self.degenerate, degenerate.to_vec());
        if accepted.is_some() && self.degenerate.is_empty() && !unknown.is_empty() {
            self.drift.keep(&step.before, &registered.belief, &unknown);
        }
    }

    fn limit_unmeasured_velocity(&self, step: &Step, belief: &mut Belief) {
        let since = step.end.since(step.before.stamp);
        for direction in &self.degenerate {
            limit_velocity(belief, direction, self.settings.typical_speed, since);
        }
    }

    /// Puts the scan into the map. A map that is tilted too far is begun anew: its points were put
    /// in at another tilt than they are seen at now.
    fn update_map(&mut self, step: &Step, registered: &mut Registered) {
        let is_accepted = registered.accepted().is_some();
        let belief = &mut registered.belief;
        if belief.state.map_tilt.norm() > MAX_MAP_TILT_RAD {
            self.begin_map();
            set_map_upright(belief);
        } else if is_accepted || step.is_first {
            let new_share = self.matching.insert(&belief.state, &mut self.map);
            self.drift.grow(belief, new_share, &self.degenerate);
        }
    }

    fn begin_map(&mut self) {
        self.map = PlaneMap::new(self.settings.lidar_noise);
    }

    /// Drops what is far away, now and then.
    fn trim_map(&mut self, belief: &Belief) {
        let position = belief.state.position;
        if (position - self.trimmed_at).amax() > MAP_REACH_M / 4.0 {
            self.map.forget(position, MAP_REACH_M);
            self.trimmed_at = position;
        }
    }

    fn average_innovation(&mut self, registered: &Registered) {
        if let Some(matched) = registered.accepted() {
            let innovation = matched.innovation.min(MAX_INNOVATION);
            self.innovation += (innovation - self.innovation) * SCAN_WEIGHT;
        }
    }

    /// Compares the trajectory with wheels and gyroscope. A filter that has diverged is restarted.
    fn judge(&mut self, step: &Step, registered: &mut Registered) -> Verdict {
        let Some(reckoned) = &step.reckoned else {
            return Verdict::Sound;
        };
        let is_supported = step.is_first || registered.accepted().is_some();
        let belief = &mut registered.belief;
        let verdict = self
            .watchdog
            .judge(belief, reckoned, is_supported, &self.settings.imu);
        if verdict == Verdict::Diverged
            && let Some(restarted) = self.restart(reckoned)
        {
            *belief = restarted;
        }
        verdict
    }

    /// Restarts from the last state that agreed with everything, moved on by wheels and gyroscope.
    /// The map is begun anew: the old one may hold scans of the wrong trajectory.
    fn restart(&mut self, reckoned: &Reckoned) -> Option<Belief> {
        let restart = self.watchdog.recover(&self.settings.imu)?;
        let deviation = PoseDeviation {
            metres: RECKONED.metres + RECKONED_PER_METRE * restart.metres,
            radians: RECKONED.radians + RECKONED_PER_RADIAN * restart.radians,
        };
        let mut belief = restart.belief;
        let robot = belief.state.rotation * self.settings.imu.rotation.inverse();
        belief.state.velocity = robot * reckoned.velocity;
        belief.add_deviation(at::ROTATION, RECKONED.radians);
        // The same number, in m/s.
        belief.add_deviation(at::VELOCITY, deviation.metres);
        self.drift.lose(&mut belief, deviation);
        self.begin_map();
        self.watchdog.restart(&belief, &self.settings.imu);
        self.innovation = 0.0;
        self.restarted = Some(belief.stamp);
        self.refused.runaways += 1;
        Some(belief)
    }

    fn status(&self, step: &Step, registered: &Registered, verdict: Verdict) -> Status {
        let is_tracking =
            step.is_first || registered.accepted().is_some() && registered.is_complete();
        if !is_tracking {
            Status::Coasting
        } else if self.is_disputed(step, verdict) {
            Status::Disputed
        } else if self.matching.noise_scale.is_noisy() {
            Status::Noisy
        } else {
            Status::Tracking
        }
    }

    /// Whether the sensors contradict each other, or the filter has not settled after a restart.
    fn is_disputed(&self, step: &Step, verdict: Verdict) -> bool {
        let is_settling = self
            .restarted
            .is_some_and(|at| step.end.since(at) < SETTLING);
        is_settling || verdict == Verdict::Contradicted || self.innovation > DISPUTED_INNOVATION
    }

    /// Adopts what became of a scan.
    fn finish(&mut self, registered: Registered, status: Status) -> Estimate {
        let estimate = self.estimate(&registered.belief, registered.matched, status);
        self.belief = Some(registered.belief);
        estimate
    }

    /// Begins the map with a scan from where the robot rests; `belief` is what is known then.
    pub(super) fn begin_map_with(&mut self, belief: &mut Belief, scan: &LidarScan) -> Estimate {
        let points = usable_points(scan, self.settings.blind);
        self.refused.points += scan.points.len() - points.len();
        belief.stamp = end_of(scan);
        let Belief {
            state, covariance, ..
        } = &*belief;
        let noise = &self.settings.lidar_noise;
        self.matching
            .find(state, covariance, &points, &self.map, noise, f64::INFINITY);
        self.matching.insert(state, &mut self.map);
        self.estimate(belief, None, Status::Tracking)
    }

    /// Goes on without a scan, by IMU and wheels.
    pub(super) fn coast(&mut self, until: SimTime) -> Option<Estimate> {
        let mut belief = self.belief.take()?;
        let since = until.since(belief.stamp);
        self.inertial
            .predict(&mut belief, until, &self.settings, &Vector3::zeros());
        for direction in &ALL_DIRECTIONS {
            limit_velocity(&mut belief, direction, self.settings.typical_speed, since);
        }
        self.refused.gaps += self.inertial.forget(until);
        let estimate = self.estimate(&belief, None, Status::Coasting);
        self.belief = Some(belief);
        Some(estimate)
    }

    /// Goes on from where the robot was, though it may be elsewhere by now: the IMU was silent.
    pub(super) fn lose(&mut self, stamp: SimTime) -> Option<Estimate> {
        let mut belief = self.belief.take()?;
        belief.stamp = stamp;
        belief.state.velocity = Vector3::zeros();
        belief.add_deviation(at::ROTATION, LOST.radians);
        belief.add_deviation(at::POSITION, LOST.metres);
        belief.add_deviation(at::VELOCITY, LOST_M_S);
        self.drift.lose(&mut belief, LOST);
        self.begin_map();
        self.inertial.clear();
        self.watchdog.clear();
        self.refused.gaps += 1;
        let estimate = self.estimate(&belief, None, Status::Lost);
        self.belief = Some(belief);
        Some(estimate)
    }

    fn estimate(&self, belief: &Belief, matched: Option<ScanMatch>, status: Status) -> Estimate {
        let (points, fit) = matched
            .as_ref()
            .map_or((0, 0.0), |matched| (matched.points, matched.fit));
        Estimate {
            stamp: belief.stamp,
            pose: belief.state.imu_pose() * self.settings.imu.inverse(),
            velocity: belief.state.velocity,
            covariance: self.drift.pose_covariance(belief),
            status,
            degenerate: matched.map_or(Vec::new(), |matched| matched.degenerate),
            points,
            fit,
        }
    }
}
