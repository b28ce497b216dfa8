//! What becomes of a scan: the pipeline of the odometry.
//!
//! After algorithm 1 of FAST-LIO (W. Xu, F. Zhang 2021): predict, undistort, match and update. The
//! map is VoxelMap's (C. Yuan et al. 2022). What is beyond the papers: a saturated gyroscope, scans
//! that contradict the map, degenerate scenes, a map that drifts and tilts, and a watchdog.
//! `without_scan` says what happens where no scan comes.

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
use super::trust::Trust;
use super::undistortion::{end_of, undistort, usable_points};
use super::unmeasured_turn::{UnmeasuredTurn, add_uncertainty};
use super::velocity_update::limit_velocity;
use super::watchdog::Verdict;

/// A scan is registered at most this many times while the gyroscope is saturated.
const MAX_PASSES: usize = 3;
/// Directions along which a scan that is missing or rejected measures nothing.
pub(super) const ALL_DIRECTIONS: [Vector3<f64>; 3] = [
    Vector3::new(1.0, 0.0, 0.0),
    Vector3::new(0.0, 1.0, 0.0),
    Vector3::new(0.0, 0.0, 1.0),
];
/// A map that is tilted more is of no use, radians.
const MAX_MAP_TILT_RAD: f64 = 0.02;
/// The map reaches this far, metres. It is trimmed each time that the robot has come a quarter of
/// it.
const MAP_REACH_M: f64 = 150.0;

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
    pub(super) drift: Drift,
    /// Directions along which the last scan measured nothing.
    degenerate: Vec<Vector3<f64>>,
    /// Where the map was trimmed last.
    trimmed_at: Vector3<f64>,
    pub(super) trust: Trust,
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
            trust: Trust::default(),
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
        self.limit_unmeasured_velocity(&step, &mut registered);
        self.update_map(&step, &mut registered);
        let status = self.judge(&step, &mut registered);
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
        let points = undistort(
            scan,
            &belief.state,
            &prediction.nodes,
            self.settings.min_range_m,
        );
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
            // The update has overwritten the prediction, so that is made again.
            registered.belief = step.before.clone();
            self.predict(&mut registered.belief, step.end);
        }
    }

    /// Bounds the velocity along directions in which neither this scan nor wheels measure it.
    fn limit_unmeasured_velocity(&mut self, step: &Step, registered: &mut Registered) {
        self.note_degenerate_directions(step, registered);
        let since = step.end.since(step.before.stamp);
        let typical_speed = self.settings.typical_speed_m_s;
        for direction in &self.degenerate {
            limit_velocity(&mut registered.belief, direction, typical_speed, since);
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

    /// Puts the scan into the map. A map that is tilted too far is begun anew: its points were put
    /// in at another tilt than they are seen at now.
    fn update_map(&mut self, step: &Step, registered: &mut Registered) {
        let is_accepted = registered.accepted().is_some();
        let belief = &mut registered.belief;
        if belief.state.map_tilt.norm() > MAX_MAP_TILT_RAD {
            // The next scan begins the new map: this one was matched to the old one.
            self.begin_map();
            set_map_upright(belief);
        } else if is_accepted || step.is_first {
            let new_share = self.matching.insert(&belief.state, &mut self.map);
            self.drift.grow(belief, new_share, &self.degenerate);
        }
        self.trim_map(registered.belief.state.position);
    }

    pub(super) fn begin_map(&mut self) {
        self.map = PlaneMap::new(self.settings.lidar_noise);
    }

    /// Drops what is far away, now and then.
    fn trim_map(&mut self, position: Vector3<f64>) {
        if (position - self.trimmed_at).amax() > MAP_REACH_M / 4.0 {
            self.map.forget(position, MAP_REACH_M);
            self.trimmed_at = position;
        }
    }

    /// How far the estimate can be trusted. A filter that has diverged is restarted.
    fn judge(&mut self, step: &Step, registered: &mut Registered) -> Status {
        if let Some(matched) = registered.accepted() {
            self.trust.note_innovation(matched);
        }
        let verdict = self.compare_with_reckoning(step, registered);
        self.status(step, registered, verdict)
    }

    /// Compares the trajectory with wheels and gyroscope; without these, nothing contradicts it.
    fn compare_with_reckoning(&mut self, step: &Step, registered: &mut Registered) -> Verdict {
        let Some(reckoned) = &step.reckoned else {
            return Verdict::Sound;
        };
        let is_supported = step.is_first || registered.accepted().is_some();
        let imu = &self.settings.imu;
        let verdict = self
            .trust
            .judge(&registered.belief, reckoned, is_supported, imu);
        if verdict == Verdict::Diverged
            && let Some(restarted) = self.trust.restart(reckoned, imu, &mut self.drift)
        {
            registered.belief = restarted;
            // The old map may contain scans of the wrong trajectory.
            self.begin_map();
            self.refused.restarts += 1;
        }
        verdict
    }

    fn status(&self, step: &Step, registered: &Registered, verdict: Verdict) -> Status {
        let is_tracking =
            step.is_first || registered.accepted().is_some() && registered.is_complete();
        // In the order of severity: only the worst is reported.
        if !is_tracking {
            Status::Coasting
        } else if self.trust.is_disputed(step.end, verdict) {
            Status::Disputed
        } else if self.matching.noise_scale.is_noisy() {
            Status::Noisy
        } else {
            Status::Tracking
        }
    }

    /// Adopts what became of a scan.
    fn finish(&mut self, registered: Registered, status: Status) -> Estimate {
        let estimate = self.estimate(&registered.belief, registered.matched, status);
        self.belief = Some(registered.belief);
        estimate
    }

    /// Begins the map with a scan from where the robot rests; `belief` is what is known then.
    pub(super) fn begin_map_with(&mut self, belief: &mut Belief, scan: &LidarScan) -> Estimate {
        let points = usable_points(scan, self.settings.min_range_m);
        self.refused.points += scan.points.len() - points.len();
        belief.stamp = end_of(scan);
        let Belief {
            state, covariance, ..
        } = &*belief;
        let noise = &self.settings.lidar_noise;
        self.matching
            // The pose is not corrected: the search only sorts the points into cubes.
            .find(state, covariance, &points, &self.map, noise, f64::INFINITY);
        self.matching.insert(state, &mut self.map);
        self.estimate(belief, None, Status::Tracking)
    }

    pub(super) fn estimate(
        &self,
        belief: &Belief,
        matched: Option<ScanMatch>,
        status: Status,
    ) -> Estimate {
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
