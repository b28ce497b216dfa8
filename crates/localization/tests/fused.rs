//! Odometry and fixes together.

mod common;

use std::cell::Cell;
use std::rc::Rc;

use common::Robot;
use nalgebra::{Isometry2, Matrix3, Vector2};
use openbench_core::{Observation, Pose2, RobotDescription, SimTime};
use openbench_localization::graph::FixCount;
use openbench_localization::{Fix, FixSource, Fused, Localizer};

/// Says once a second what stands in it.
struct Oracle {
    says: Rc<Cell<Option<Pose2>>>,
    last: SimTime,
}

impl FixSource for Oracle {
    fn name(&self) -> &str {
        "oracle"
    }

    fn reset(&mut self) {
        self.last = SimTime::ZERO;
    }

    fn update(&mut self, observation: &Observation<'_>, _near: Pose2) -> Option<Fix> {
        let pose = self
            .says
            .get()
            .filter(|_| observation.time.since(self.last).as_secs_f64() >= 1.0)?;
        self.last = observation.time;
        Some(Fix {
            stamp: observation.time,
            pose: Isometry2::new(Vector2::new(pose.x, pose.y), pose.yaw),
            information: Matrix3::from_diagonal(&[400.0, 400.0, 1e3].into()),
            credible: 3.0,
        })
    }
}

/// A localizer that was told a start, and drives from another one; what the fixes say is told step by step.
struct Trial {
    localizer: Fused,
    robot: Robot,
    says: Rc<Cell<Option<Pose2>>>,
}

impl Trial {
    fn new(told: Pose2, truth: Pose2) -> Self {
        let says = Rc::new(Cell::new(None));
        let oracle = Oracle {
            says: says.clone(),
            last: SimTime::ZERO,
        };
        let mut localizer = Fused::new(RobotDescription::sentry(), vec![Box::new(oracle)]);
        localizer.reset(told);
        let mut robot = Robot::at(truth);
        robot.drive(&mut localizer, 0.0, 0.0, 2.0);
        Self {
            localizer,
            robot,
            says,
        }
    }

    /// Drives on with fixes that are off by something; the largest step of `odom` in `map` at the robot, and the largest correction that was still to come.
    fn drive(&mut self, seconds: f64, off: impl Fn(usize) -> Vector2<f64>) -> (f64, f64) {
        let (mut largest, mut pending): (f64, f64) = (0.0, 0.0);
        for step in 0..(seconds / 0.05) as usize {
            let off = off(step / 20);
            let truth = self.robot.truth;
            self.says.set(Some(Pose2::new(
                truth.x + off.x,
                truth.y + off.y,
                truth.yaw,
            )));
            let before = (self.localizer.odom(), self.localizer.pose());
            self.robot.drive(&mut self.localizer, 0.5, 0.1, 0.05);
            // Where the pose of before would be told now.
            let there = before.0.inverse_transform(before.1.point());
            let moved = self.localizer.odom().transform(there.0, there.1);
            largest = largest.max(moved.distance(before.1.point()));
            pending = pending.max(self.localizer.pending());
        }
        (largest, pending)
    }

    fn error(&self) -> f64 {
        self.localizer
            .pose()
            .point()
            .distance(self.robot.truth.point())
    }
}

#[test]
fn a_start_that_was_wrong_is_found_out_and_mended_without_a_jump() {
    let mut trial = Trial::new(Pose2::new(10.0, 5.0, 0.3), Pose2::new(10.0, 5.5, 0.31));
    let (jump, pending) = trial.drive(60.0, |_| Vector2::zeros());
    assert!(trial.error() < 0.05, "{}", trial.error());
    assert!(
        jump < 0.0101 && jump > 0.009 && pending > 0.2,
        "{jump} {pending}"
    );
    let deviation = trial.localizer.covariance().unwrap()[(0, 0)].sqrt();
    assert!(deviation < 0.1 && deviation > 1e-3, "{deviation}");
}

#[test]
fn false_fixes_bend_nothing() {
    let start = Pose2::new(-3.0, 8.0, 2.0);
    let mut trial = Trial::new(start, start);
    // Two of three are false, and differ from each other.
    let off = |i: usize| match i % 3 {
        0 => Vector2::zeros(),
        other => {
            Vector2::new(libm::sin(i as f64), libm::cos(3.0 * i as f64)) * (10.0 * other as f64)
        }
    };
    let (_, pending) = trial.drive(60.0, off);
    assert!(
        trial.error() < 0.1 && pending < 0.1,
        "{} {pending}",
        trial.error()
    );
    let FixCount { accepted, total } = trial.localizer.accepted_fixes();
    assert!(
        accepted * 2 < total && accepted * 4 > total,
        "{accepted} of {total}"
    );
}

#[test]
fn a_fix_that_is_no_number_changes_nothing() {
    let start = Pose2::new(1.0, 2.0, 0.5);
    let mut trial = Trial::new(start, start);
    let (jump, pending) = trial.drive(5.0, |_| Vector2::new(f64::NAN, 0.0));
    assert!(jump < 1e-9 && pending < 1e-9 && trial.error() < 0.05);
}
