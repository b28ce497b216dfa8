//! LiDAR-inertial odometry corrected by global fixes in a pose graph.
//!
//! Odometry gives the pose in `odom`, without jumps. The graph gives the pose of `odom` in `map`.
//! Its corrections are applied slowly, so that the published pose has no jumps either. (REP 105
//! lets `map -> odom` jump; planners suffer from it.)

use std::time::Duration;

use nalgebra::{Isometry2, Matrix3, UnitComplex, Vector2, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{Doubt, Health, MapComparison, Observation, Pose2, RobotDescription, SimTime};

use crate::deviation::PoseDeviation;
use crate::fixes::{Fix, FixSource};
use crate::graph::{FixCount, Pose as _, Window};
use crate::history;
use crate::reckoned::{Reckoned, level_variance, rotating};
use crate::registration::BuildingOffset;
use crate::{LidarInertial, Localizer};

/// A new pose comes into the graph after this distance, metres,
const KEY_DISTANCE_M: f64 = 1.0;
/// or this turn, radians,
const KEY_TURN_RAD: f64 = 0.3;
/// or once the motion since the last one is known no better than this, metres.
const KEY_DEVIATION_M: f64 = 0.3;
/// This many poses are kept.
const WINDOW_POSES: usize = 100;
/// A fix farther away is of no map, metres.
const MAX_FIX_DISTANCE_M: f64 = 1e6;
/// How well the start is known.
const START: PoseDeviation = PoseDeviation {
    metres: 0.05,
    radians: 0.01,
};
/// How well a pose is known of which nothing is known.
const NOWHERE: PoseDeviation = PoseDeviation {
    metres: 1e5,
    radians: std::f64::consts::PI,
};
/// A robot whose start is known no better than this is searched for first, metres.
const LOCATED_M: f64 = 4.0;
/// The heading of a found robot is known better than this, radians.
const LOCATED_RAD: f64 = 0.2;
/// No motion between two poses is known better: floors differ, wheels sink in.
const FINEST: PoseDeviation = PoseDeviation {
    metres: 1e-3,
    radians: 1e-4,
};
/// While the robot is not located, the published pose jumps to a new one that is farther away than
/// this, metres,
const JUMP_M: f64 = 1.0;
/// or turned by more than this, radians.
const JUMP_RAD: f64 = 0.1;
/// Corrections move the published pose no faster than this, m/s,
const MAX_CORRECTION_M_S: f64 = 0.2;
/// and turn it no faster than this, rad/s.
const MAX_CORRECTION_RAD_S: f64 = 0.1;
/// Odometry that contradicts itself for so long may be elsewhere.
const MISLEADING_TIME: Duration = Duration::from_secs(1);
/// No longer time counts between two observations, seconds.
const MAX_INTERVAL_S: f64 = 0.2;

/// Odometry and graph.
pub struct Fused {
    odometry: LidarInertial,
    sources: Vec<Box<dyn FixSource>>,
    window: Window<Isometry2<f64>, 3>,
    /// The newest pose of the graph.
    key: Option<Reckoned>,
    is_located: bool,
    /// Whether `published` is what a source presumes.
    is_presumed: bool,
    /// Pose of `odom` in `map` as published.
    published: Isometry2<f64>,
    /// The same as the graph estimates it.
    estimated: Isometry2<f64>,
    /// Fixes that came before the graph began.
    early: Vec<Fix>,
    /// Time of the newest observation.
    now: SimTime,
    /// Since when odometry contradicts itself.
    contradicted: Option<SimTime>,
}

impl Fused {
    /// A localizer for a robot, corrected by the fixes of these sources.
    pub fn new(robot: RobotDescription, sources: Vec<Box<dyn FixSource>>) -> Self {
        let start = Isometry2::identity();
        Self {
            odometry: LidarInertial::new(robot),
            window: window(start, known(&sources)),
            is_located: known(&sources).metres < LOCATED_M,
            is_presumed: false,
            sources,
            key: None,
            published: start,
            estimated: start,
            early: Vec::new(),
            now: SimTime::ZERO,
            contradicted: None,
        }
    }

    /// How many fixes of the newest poses are accepted.
    pub fn accepted_fixes(&self) -> FixCount {
        self.window.fix_count()
    }

    /// Adds a pose to the graph where the robot has come far enough since the last one.
    fn extend_graph(&mut self) {
        let Some(covariance) = self.odometry.covariance() else {
            return;
        };
        let here = Reckoned {
            pose: self.odometry.pose(),
            covariance,
        };
        match self.key {
            // Odometry has a covariance from its first scan on, and the graph begins where the
            // robot is then.
            None => {
                let start = self.published * isometry(here.pose);
                self.window = window(start, known(&self.sources));
            }
            Some(last) if is_key_after(&last, &here) => {
                let motion = isometry(last.pose).inverse() * isometry(here.pose);
                self.window.advance(motion, information(&last, &here));
            }
            Some(_) => return,
        }
        self.key = Some(here);
    }

    /// Tells sources when a contradiction is over that lasted.
    fn notice_contradiction(&mut self) {
        if self.odometry.health_within(None) == Health::Degraded(Doubt::Contradiction) {
            self.contradicted.get_or_insert(self.now);
            return;
        }
        let since = self.contradicted.take();
        if since.is_some_and(|since| self.now.since(since) >= MISLEADING_TIME) {
            self.sources.iter_mut().for_each(|source| source.distrust());
        }
    }

    /// Where a source can find the robot again, it is searched for as soon as that source or
    /// odometry says that it is elsewhere.
    fn notice_loss(&mut self) {
        let is_found_again = self.sources.iter().any(|source| source.finds());
        if !is_found_again {
            return;
        }
        let was_located = self.is_located;
        let is_thought_somewhere = was_located || self.is_presumed;
        if is_thought_somewhere && self.health() == Health::Lost {
            self.sources.iter_mut().for_each(|source| source.lose());
            (self.is_located, self.is_presumed) = (false, false);
        }
        self.is_located &= !self.sources.iter().any(|source| source.is_lost());
        if was_located && !self.is_located {
            self.forget();
        }
    }

    /// Begins the graph anew without knowing where the robot is. By what was known before, all
    /// fixes elsewhere would be outliers.
    fn forget(&mut self) {
        let Some(key) = self.key else { return };
        self.window = window(self.published * isometry(key.pose), NOWHERE);
    }

    /// Applies fixes, or keeps them until the graph begins: a robot may find itself by its first
    /// scans, before odometry says how exact it is.
    fn take(&mut self, mut fixes: Vec<Fix>) {
        if self.key.is_none() {
            fixes.retain(|fix| self.is_recent(fix));
            self.early = fixes;
        } else {
            fixes.iter().for_each(|fix| self.apply(fix));
        }
    }

    /// Attaches a fix to the newest pose of the graph, by the motion between them, and solves the
    /// graph. A fix that makes no sense, or an unsolvable graph, leaves all as it was.
    fn apply(&mut self, fix: &Fix) {
        let Some(key) = self.key else { return };
        let is_far = self.is_located && !self.is_near(fix);
        if !fix.is_sound() || is_far || !self.is_recent(fix) {
            return;
        }
        let at_fix = isometry(self.odometry.pose_at(fix.stamp));
        let motion = at_fix.inverse() * isometry(key.pose);
        // An error of the key pose, in its own frame, is the adjoint times it in the fix's frame.
        let carried = motion.adjoint();
        let information = carried.transpose() * fix.information * carried;
        let covariance = information.try_inverse();
        if !self.is_located && covariance.is_some_and(|covariance| is_place(&covariance)) {
            self.begin_at(fix.pose * motion, information);
            return;
        }
        // On a copy, since a solution that fails leaves the fix in the window.
        let mut window = self.window.clone();
        window.fix(fix.pose * motion, information, fix.max_deviations);
        if window.settle().is_ok() {
            self.window = window;
            self.take_over(key);
        }
    }

    /// Takes over the newest pose of the graph. If the robot is not located yet, that locates it as
    /// soon as the graph knows position and heading; several partial fixes can do so together.
    fn take_over(&mut self, key: Reckoned) {
        let estimated = self.window.newest() * isometry(key.pose).inverse();
        if self.is_located {
            self.estimated = estimated;
            return;
        }
        let covariance = self.window.covariance();
        if covariance.is_some_and(|covariance| is_place(&covariance)) {
            self.move_to(estimated);
            (self.is_located, self.is_presumed) = (true, false);
        }
    }

    /// Begins the graph anew at the newest key pose: what was known before is worth nothing.
    fn begin_at(&mut self, pose: Isometry2<f64>, information: Matrix3<f64>) {
        let Some(key) = self.key else { return };
        let start = start_information(known(&self.sources));
        self.window = Window::new(pose, information + start, WINDOW_POSES);
        self.move_to(pose * isometry(key.pose).inverse());
        (self.is_located, self.is_presumed) = (true, false);
    }

    /// Goes on with what a source presumes, until the robot is found.
    fn presume(&mut self) {
        let presumption = self.sources.iter().find_map(|source| source.presumption());
        let Some(presumption) = presumption.filter(|_| !self.is_located) else {
            return;
        };
        self.move_to(isometry(presumption.map) * isometry(presumption.odom).inverse());
        self.is_presumed = true;
    }

    /// Sets a new estimate. The published pose jumps to it, unless a presumed one is near: that is
    /// corrected slowly.
    fn move_to(&mut self, estimated: Isometry2<f64>) {
        self.estimated = estimated;
        let pending = self.pending_motion();
        let is_near = pending.xy().norm() < JUMP_M && pending.z.abs() < JUMP_RAD;
        if !(self.is_presumed && is_near) {
            self.published = estimated;
        }
    }

    fn is_near(&self, fix: &Fix) -> bool {
        let away = fix.pose.translation.vector - self.published.translation.vector;
        away.norm() < MAX_FIX_DISTANCE_M
    }

    fn is_recent(&self, fix: &Fix) -> bool {
        fix.stamp <= self.now && self.now.since(fix.stamp) <= history::MEMORY
    }

    /// Moves the published pose towards the estimated one, as far as is allowed in so many seconds.
    fn correct(&mut self, seconds: f64) {
        let odom = isometry(self.odometry.pose());
        let published = self.published * odom;
        let pending = self.pending_motion();
        let max_distance = MAX_CORRECTION_M_S * seconds;
        let max_turn = MAX_CORRECTION_RAD_S * seconds;
        // Measured where the robot is. About the origin of `odom`, a small turn would move a
        // distant robot by metres.
        let shift = pending.xy();
        let distance = shift.norm();
        let shift = if distance > max_distance {
            shift * (max_distance / distance)
        } else {
            shift
        };
        let turn = pending.z.clamp(-max_turn, max_turn);
        let position = published.translation.vector + shift;
        let next = Isometry2::new(position, published.rotation.angle() + turn);
        self.published = next * odom.inverse();
    }

    /// From the published pose to the estimated one: x, y, yaw in `map`.
    fn pending_motion(&self) -> Vector3<f64> {
        let odom = isometry(self.odometry.pose());
        let published = self.published * odom;
        let estimated = self.estimated * odom;
        let shift: Vector2<f64> = estimated.translation.vector - published.translation.vector;
        shift.push((published.rotation.inverse() * estimated.rotation).angle())
    }

    fn in_map(&self, odom: Pose2) -> Pose2 {
        pose(&(self.published * isometry(odom)))
    }
}

impl Localizer for Fused {
    fn name(&self) -> &str {
        "fused"
    }

    fn reset(&mut self, start: Pose2) {
        // Odometry begins at its own origin. Where that is in `map` is said by `published`.
        self.odometry.reset(Pose2::default());
        self.sources.iter_mut().for_each(|source| source.reset());
        let start = isometry(start);
        self.published = start;
        self.estimated = start;
        self.window = window(start, known(&self.sources));
        self.is_located = known(&self.sources).metres < LOCATED_M;
        self.is_presumed = false;
        self.key = None;
        self.early.clear();
        self.now = SimTime::ZERO;
        self.contradicted = None;
    }

    fn is_located(&self) -> bool {
        self.is_located
    }

    fn is_presumed(&self) -> bool {
        self.is_presumed
    }

    fn update(&mut self, observation: &Observation<'_>) {
        self.odometry.update(observation);
        let seconds = observation.time.since(self.now).as_secs_f64();
        self.now = self.now.max(observation.time);
        self.extend_graph();
        let near = self.pose();
        let mut fixes = std::mem::take(&mut self.early);
        for source in &mut self.sources {
            fixes.extend(source.update(observation, near, &self.odometry));
        }
        self.take(fixes);
        self.notice_contradiction();
        self.notice_loss();
        self.presume();
        self.correct(seconds.min(MAX_INTERVAL_S));
    }

    fn pose_at(&self, time: SimTime) -> Pose2 {
        self.in_map(self.odometry.pose_at(time))
    }

    fn pose(&self) -> Pose2 {
        self.in_map(self.odometry.pose())
    }

    fn ready(&self) -> bool {
        self.odometry.ready()
    }

    fn health(&self) -> Health {
        if !self.is_located {
            // The pose on the map is not known; of odometry it matters only whether it works.
            return self.odometry.health_within(None);
        }
        // Odometry's own covariance is that of all motion since the start; fixes may be better.
        let known = [self.odometry.covariance(), self.covariance()]
            .into_iter()
            .flatten();
        let best = known.min_by(|a, b| level_variance(a).total_cmp(&level_variance(b)));
        self.odometry.health_within(best)
    }

    fn odom(&self) -> Pose2 {
        pose(&self.published)
    }

    /// Of the graph's newest pose, of the motion since then, and of what is still to be applied.
    fn covariance(&self) -> Option<Matrix3<f64>> {
        let key = self.key?;
        let here = Reckoned {
            pose: self.odometry.pose(),
            covariance: self.odometry.covariance()?,
        };
        let motion = isometry(key.pose).inverse() * isometry(here.pose);
        // From the frame of the key pose to that of the newest pose.
        let carried = motion.inverse().adjoint();
        let since = information(&key, &here).try_inverse()?;
        let own = carried * self.window.covariance()? * carried.transpose() + since;
        let turn = rotating(self.pose().yaw);
        let pending = self.pending_motion();
        // What is pending is a known error of the published pose. As an outer product it counts
        // like one standard deviation.
        Some(turn * own * turn.transpose() + pending * pending.transpose())
    }

    fn map_registrations(&self) -> u64 {
        let all = self.sources.iter().map(|source| source.map_registrations());
        all.sum()
    }

    fn comparison(&self) -> Option<MapComparison> {
        self.sources.iter().find_map(|source| source.comparison())
    }

    fn building_offsets(&self) -> &[BuildingOffset] {
        for source in &self.sources {
            let offsets = if self.is_presumed {
                source.presumed_offsets()
            } else if self.is_located {
                // Not those of a presumption: a start that is known well is not given up for one.
                source.building_offsets()
            } else {
                &[]
            };
            if !offsets.is_empty() {
                return offsets;
            }
        }
        &[]
    }

    fn pending(&self) -> f64 {
        self.pending_motion().xy().norm()
    }
}

/// How well the start is known in the map that the sources of fixes use.
fn known(sources: &[Box<dyn FixSource>]) -> PoseDeviation {
    let worse = |known: PoseDeviation, other: PoseDeviation| PoseDeviation {
        metres: known.metres.max(other.metres),
        radians: known.radians.max(other.radians),
    };
    let deviations = sources.iter().filter_map(|source| source.start_deviation());
    deviations.fold(START, worse)
}

/// Whether a pose of this covariance says where the robot is, and where it heads: not so a position
/// alone.
fn is_place(covariance: &Matrix3<f64>) -> bool {
    let metres = libm::sqrt(level_variance(covariance));
    let radians = libm::sqrt(covariance[(2, 2)]);
    metres < LOCATED_M && radians < LOCATED_RAD
}

/// A graph that begins at a pose in `map`, known so well.
fn window(start: Isometry2<f64>, known: PoseDeviation) -> Window<Isometry2<f64>, 3> {
    Window::new(start, start_information(known), WINDOW_POSES)
}

fn start_information(known: PoseDeviation) -> Matrix3<f64> {
    let level = 1.0 / (known.metres * known.metres);
    let turn = 1.0 / (known.radians * known.radians);
    Matrix3::from_diagonal(&[level, level, turn].into())
}

/// Whether the robot has come far enough since the last pose of the graph, or coasted for too long.
fn is_key_after(last: &Reckoned, here: &Reckoned) -> bool {
    let distance = here.pose.point().distance(last.pose.point());
    let turn = wrap_angle(here.pose.yaw - last.pose.yaw).abs();
    let grown = here.level_variance() > last.level_variance() + KEY_DEVIATION_M * KEY_DEVIATION_M;
    distance >= KEY_DISTANCE_M || turn >= KEY_TURN_RAD || grown
}

/// Information about the motion between two poses, in the frame of its end: the inverse of how much
/// the odometry's covariance grew.
fn information(from: &Reckoned, to: &Reckoned) -> Matrix3<f64> {
    let level = FINEST.metres * FINEST.metres;
    let angle = FINEST.radians * FINEST.radians;
    let finest = Matrix3::from_diagonal(&[level, level, angle].into());
    let information = (to.growth_since(from) + finest).try_inverse();
    let finite = information.filter(|information| information.iter().all(|x| x.is_finite()));
    finite.unwrap_or_else(Matrix3::zeros)
}

fn isometry(pose: Pose2) -> Isometry2<f64> {
    let (sine, cosine) = libm::sincos(pose.yaw);
    let rotation = UnitComplex::from_cos_sin_unchecked(cosine, sine);
    Isometry2::from_parts(Vector2::new(pose.x, pose.y).into(), rotation)
}

fn pose(isometry: &Isometry2<f64>) -> Pose2 {
    let rotation = isometry.rotation;
    let yaw = libm::atan2(rotation.im, rotation.re);
    Pose2::new(isometry.translation.x, isometry.translation.y, yaw)
}

#[cfg(test)]
mod tests {
    use openbench_core::MapPoint;

    use super::*;
    use crate::Track;

    fn key(x: f64, deviation: f64) -> Reckoned {
        let square = deviation * deviation;
        let covariance = Matrix3::from_diagonal(&[square, square, 1e-6].into());
        Reckoned {
            pose: Pose2::new(x, 0.0, 0.5),
            covariance,
        }
    }

    /// Standard deviation of the motion between two poses, as its inverse.
    fn certainty(from: Reckoned, to: Reckoned) -> f64 {
        1.0 / information(&from, &to).try_inverse().unwrap()[(0, 0)].sqrt()
    }

    #[test]
    fn a_motion_is_as_uncertain_as_the_difference_of_its_ends() {
        let sound = certainty(key(0.0, 0.1), key(1.0, 0.1));
        assert!(sound > 10.0, "{sound}");
        // Coasting makes a pose uncertain, and the motion to it as well.
        let into = certainty(key(0.0, 0.1), key(1.0, 2.0));
        assert!((into - 0.5).abs() < 0.01, "{into}");
        // A scan that fits again takes the uncertainty back. The motion from there is as uncertain.
        let out_of = certainty(key(1.0, 2.0), key(2.0, 0.1));
        assert!((out_of - 0.5).abs() < 0.01, "{out_of}");
    }

    /// A source that finds the robot, and lost it.
    struct Finder;

    impl FixSource for Finder {
        fn name(&self) -> &str {
            "finder"
        }

        fn reset(&mut self) {}

        fn finds(&self) -> bool {
            true
        }

        fn is_lost(&self) -> bool {
            true
        }

        fn update(&mut self, _: &Observation<'_>, _: Pose2, _: &dyn Track) -> Option<Fix> {
            None
        }
    }

    #[test]
    fn a_robot_that_is_lost_is_where_partial_fixes_say_together() {
        let mut fused = Fused::new(RobotDescription::sentry(), vec![Box::new(Finder)]);
        fused.key = Some(key(0.0, 0.1));
        fused.notice_loss();
        let there = Isometry2::new(Vector2::new(80.0, -20.0), 1.0);
        let partial = |information: [f64; 3]| Fix {
            stamp: SimTime::ZERO,
            pose: there,
            information: Matrix3::from_diagonal(&information.into()),
            max_deviations: 4.0,
        };
        fused.apply(&partial([4.0, 0.0, 400.0]));
        assert!(!fused.is_located());
        fused.apply(&partial([0.0, 4.0, 0.0]));
        assert!(fused.is_located());
        let fixed = (there * isometry(key(0.0, 0.1).pose)).translation.vector;
        let found = (fused.estimated * isometry(key(0.0, 0.1).pose))
            .translation
            .vector;
        assert!((found - fixed).norm() < 0.1, "{found}");
    }

    #[test]
    fn a_fix_that_comes_before_the_graph_is_not_lost() {
        let mut fused = Fused::new(RobotDescription::sentry(), vec![Box::new(Finder)]);
        fused.is_located = false;
        let fix = Fix {
            stamp: SimTime::ZERO,
            pose: Isometry2::new(Vector2::new(80.0, -20.0), 1.0),
            information: Matrix3::from_diagonal(&[4.0, 4.0, 400.0].into()),
            max_deviations: 4.0,
        };
        fused.take(vec![fix.clone()]);
        assert!(!fused.is_located());
        fused.key = Some(key(0.0, 0.1));
        let early = std::mem::take(&mut fused.early);
        assert_eq!(early, [fix]);
        fused.take(early);
        assert!(fused.is_located() && fused.early.is_empty());
    }

    #[test]
    fn a_robot_that_is_lost_is_where_the_next_fix_says_at_once() {
        let mut fused = Fused::new(RobotDescription::sentry(), vec![Box::new(Finder)]);
        fused.reset(Pose2::new(3.0, 4.0, 0.0));
        fused.key = Some(key(0.0, 0.1));
        let fix = Fix {
            stamp: SimTime::ZERO,
            pose: Isometry2::new(Vector2::new(80.0, -20.0), 1.0),
            information: Matrix3::from_diagonal(&[4.0, 4.0, 400.0].into()),
            max_deviations: 4.0,
        };
        assert!(fused.is_located());
        fused.notice_loss();
        assert!(!fused.is_located());
        assert!(fused.pose().point().distance(MapPoint::new(3.0, 4.0)) < 1e-9);
        fused.apply(&fix);
        assert!(fused.is_located());
        let there = fused.estimated * isometry(key(0.0, 0.1).pose);
        let fixed = fix.pose * isometry(key(0.0, 0.1).pose);
        assert!((there.translation.vector - fixed.translation.vector).norm() < 1e-9);
        assert_eq!(fused.pending(), 0.0);
    }
}
