//! LiDAR-inertial odometry corrected by global fixes in a pose graph.
//!
//! Odometry says where the robot is in `odom`, without jumps; the graph says where `odom` is in `map`. What the graph comes to is passed on slowly, so that the pose that is told has no jumps
//! either (REP 105 lets `map -> odom` jump; planners do not like it).

use nalgebra::{Isometry2, Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};
use openbench_core::frames::wrap_angle;
use openbench_core::{Health, Observation, Pose2, RobotDescription, SimTime};

use crate::fixes::{Fix, FixSource};
use crate::graph::{Pose as _, Window};
use crate::{LidarInertial, Localizer, history};

/// Poses stand that far apart in the graph, metres or radians.
const APART: [f64; 2] = [1.0, 0.3];
/// Or the way between them is no better known than that, metres.
const UNSURE: f64 = 0.3;
/// So many of them are kept.
const KEPT: usize = 100;
/// A fix farther off than that is of no map, metres.
const NOWHERE: f64 = 1e6;
/// How well the start is known: metres, radians.
const START: [f64; 2] = [0.05, 0.01];
/// No way between two poses is known better than that: metres, radians. Floors differ, wheels sink in.
const FINEST: [f64; 2] = [1e-3, 1e-4];
/// Corrections are passed on so fast at most: m/s, rad/s.
const RATE: [f64; 2] = [0.2, 0.1];
/// And as if no more time than that had gone by between two observations, seconds.
const LONGEST: f64 = 0.2;

/// A pose of the graph in `odom`.
#[derive(Debug, Clone, Copy)]
struct Key {
    odom: Pose2,
    covariance: Matrix3<f64>,
}

/// Odometry and graph.
pub struct Fused {
    odometry: LidarInertial,
    sources: Vec<Box<dyn FixSource>>,
    window: Window<Isometry2<f64>, 3>,
    key: Option<Key>,
    /// Pose of `odom` in `map` as it is told.
    told: Isometry2<f64>,
    /// As it is believed to be.
    believed: Isometry2<f64>,
    /// When the pose was told last.
    now: SimTime,
}

impl Fused {
    /// A localizer for a robot, corrected by what these say.
    pub fn new(robot: RobotDescription, sources: Vec<Box<dyn FixSource>>) -> Self {
        let start = Isometry2::identity();
        Self {
            odometry: LidarInertial::new(robot),
            sources,
            window: window(start),
            key: None,
            told: start,
            believed: start,
            now: SimTime::ZERO,
        }
    }

    /// Fixes among the newest poses that are thought to be true, and all.
    pub fn believed_fixes(&self) -> (usize, usize) {
        self.window.believed()
    }

    /// A new pose in the graph where the robot has come far enough since the last one.
    fn go_on(&mut self) {
        let Some(covariance) = self.odometry.covariance() else {
            return;
        };
        let odom = self.odometry.pose();
        let here = Key { odom, covariance };
        let Some(last) = self.key else {
            self.window = window(self.told * isometry(odom));
            self.key = Some(here);
            return;
        };
        let turned = wrap_angle(odom.yaw - last.odom.yaw).abs();
        let far = odom.point().distance(last.odom.point()) >= APART[0] || turned >= APART[1];
        let level = |key: &Key| key.covariance[(0, 0)] + key.covariance[(1, 1)];
        if far || level(&here) > level(&last) + UNSURE * UNSURE {
            let way = isometry(last.odom).inverse() * isometry(odom);
            self.window.advance(way, information(&last, &here));
            self.key = Some(here);
        }
    }

    /// Hangs a fix on the newest pose of the graph, by the way between them, and settles; a fix that makes no sense leaves all as it was.
    fn take(&mut self, fix: &Fix) {
        let Some(key) = self.key else { return };
        let sound = fix.pose.translation.vector.iter().all(|x| x.is_finite())
            && fix.pose.rotation.angle().is_finite()
            && fix.information.iter().all(|x| x.is_finite())
            && fix.credible > 0.0;
        let near = (fix.pose.translation.vector - self.told.translation.vector).norm() < NOWHERE;
        if !sound || !near || fix.stamp > self.now || self.now.since(fix.stamp) > history::MEMORY {
            return;
        }
        let way = isometry(self.odometry.pose_at(fix.stamp)).inverse() * isometry(key.odom);
        let carried = way.adjoint();
        let information = carried.transpose() * fix.information * carried;
        let mut window = self.window.clone();
        window.fix(fix.pose * way, information, fix.credible);
        if window.settle().is_ok() {
            self.believed = window.newest() * isometry(key.odom).inverse();
            self.window = window;
        }
    }

    fn correct(&mut self, seconds: f64) {
        let odom = isometry(self.odometry.pose());
        let (told, believed) = (self.told * odom, self.believed * odom);
        let way = believed.translation.vector - told.translation.vector;
        let turn = (told.rotation.inverse() * believed.rotation).angle();
        let (far, most) = (way.norm(), RATE.map(|rate| rate * seconds));
        let way = if far > most[0] {
            way * (most[0] / far)
        } else {
            way
        };
        let turn = turn.clamp(-most[1], most[1]);
        let next = Isometry2::new(told.translation.vector + way, told.rotation.angle() + turn);
        self.told = next * odom.inverse();
    }

    fn in_map(&self, odom: Pose2) -> Pose2 {
        pose(&(self.told * isometry(odom)))
    }
}

impl Localizer for Fused {
    fn name(&self) -> &str {
        "fused"
    }

    fn reset(&mut self, start: Pose2) {
        self.odometry.reset(Pose2::default());
        self.sources.iter_mut().for_each(|source| source.reset());
        let start = isometry(start);
        (self.told, self.believed, self.window) = (start, start, window(start));
        (self.key, self.now) = (None, SimTime::ZERO);
    }

    fn update(&mut self, observation: &Observation<'_>) {
        self.odometry.update(observation);
        let seconds = observation.time.since(self.now).as_secs_f64();
        self.now = self.now.max(observation.time);
        self.go_on();
        let near = self.pose();
        let fixes: Vec<Fix> = self
            .sources
            .iter_mut()
            .filter_map(|source| source.update(observation, near))
            .collect();
        fixes.iter().for_each(|fix| self.take(fix));
        self.correct(seconds.min(LONGEST));
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
        // Odometry's own covariance is of the way since the start; fixes may know the place better.
        let size = |covariance: &Matrix3<f64>| covariance[(0, 0)] + covariance[(1, 1)];
        let known = [self.odometry.covariance(), self.covariance()]
            .into_iter()
            .flatten();
        self.odometry
            .health_within(known.min_by(|a, b| size(a).total_cmp(&size(b))))
    }

    fn odom(&self) -> Pose2 {
        pose(&self.told)
    }

    /// What the graph says of its newest pose and odometry of the way from there; and what is still to be passed on.
    fn covariance(&self) -> Option<Matrix3<f64>> {
        let key = self.key?;
        let here = Key {
            odom: self.odometry.pose(),
            covariance: self.odometry.covariance()?,
        };
        let way = isometry(key.odom).inverse() * isometry(here.odom);
        let carried = way.inverse().adjoint();
        let since = information(&key, &here).try_inverse()?;
        let own = carried * self.window.covariance()? * carried.transpose() + since;
        let turn = turned(self.pose().yaw);
        let off = self.pending_way();
        Some(turn * own * turn.transpose() + off * off.transpose())
    }

    fn pending(&self) -> f64 {
        self.pending_way().xy().norm()
    }
}

impl Fused {
    /// From the pose that is told to the one that is believed: x, y, yaw in `map`.
    fn pending_way(&self) -> Vector3<f64> {
        let odom = isometry(self.odometry.pose());
        let (told, believed) = (self.told * odom, self.believed * odom);
        let way: Vector2<f64> = believed.translation.vector - told.translation.vector;
        way.push((told.rotation.inverse() * believed.rotation).angle())
    }
}

fn window(start: Isometry2<f64>) -> Window<Isometry2<f64>, 3> {
    let [level, turn] = START.map(|deviation| 1.0 / (deviation * deviation));
    Window::new(
        start,
        Matrix3::from_diagonal(&[level, level, turn].into()),
        KEPT,
    )
}

/// One over the covariance of the way between two poses in the frame of its end: by how much the odometry's covariance grew.
fn information(from: &Key, to: &Key) -> Matrix3<f64> {
    let (dx, dy) = (to.odom.x - from.odom.x, to.odom.y - from.odom.y);
    let carried = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
    let grown = to.covariance - carried * from.covariance * carried.transpose();
    let turn = turned(to.odom.yaw);
    let mut eigen = SymmetricEigen::new(turn.transpose() * grown * turn);
    // Where a pose is better known later, as when a scan fits the map again, odometry took back by so much what it had said between.
    eigen.eigenvalues.apply(|value| *value = value.abs());
    let [level, angle] = FINEST.map(|deviation| deviation * deviation);
    let covariance = eigen.recompose() + Matrix3::from_diagonal(&[level, level, angle].into());
    covariance
        .try_inverse()
        .filter(|known| known.iter().all(|x| x.is_finite()))
        .unwrap_or_else(Matrix3::zeros)
}

/// Turns x and y, leaves yaw.
fn turned(yaw: f64) -> Matrix3<f64> {
    let (sine, cosine) = libm::sincos(yaw);
    let mut turn = Matrix3::identity();
    turn.fixed_view_mut::<2, 2>(0, 0)
        .copy_from(&Matrix2::new(cosine, -sine, sine, cosine));
    turn
}

fn isometry(pose: Pose2) -> Isometry2<f64> {
    let (sine, cosine) = libm::sincos(pose.yaw);
    let turn = nalgebra::UnitComplex::from_cos_sin_unchecked(cosine, sine);
    Isometry2::from_parts(Vector2::new(pose.x, pose.y).into(), turn)
}

fn pose(isometry: &Isometry2<f64>) -> Pose2 {
    let turn = isometry.rotation;
    Pose2::new(
        isometry.translation.x,
        isometry.translation.y,
        libm::atan2(turn.im, turn.re),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(x: f64, deviation: f64) -> Key {
        let square = deviation * deviation;
        let covariance = Matrix3::from_diagonal(&[square, square, 1e-6].into());
        Key {
            odom: Pose2::new(x, 0.0, 0.5),
            covariance,
        }
    }

    #[test]
    fn a_way_is_no_better_known_than_what_its_ends_differ_by() {
        let of = |from, to| 1.0 / information(&from, &to).try_inverse().unwrap()[(0, 0)].sqrt();
        // Coasting makes a pose uncertain, and so is the way to it; a scan that fits again takes it back, and the way from there is as uncertain.
        let (out, back) = (
            of(key(0.0, 0.1), key(1.0, 2.0)),
            of(key(1.0, 2.0), key(2.0, 0.1)),
        );
        assert!(
            (out - 0.5).abs() < 0.01 && (back - 0.5).abs() < 0.01,
            "{out} {back}"
        );
        assert!(
            of(key(0.0, 0.1), key(1.0, 0.1)) > 10.0,
            "a way that nothing is wrong with"
        );
    }
}
