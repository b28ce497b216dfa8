//! Odometry and fixes together.

mod common;

use std::cell::Cell;
use std::rc::Rc;

use common::Robot;
use nalgebra::{Isometry2, Matrix3, Vector2};
use openbench_core::{Observation, Pose2, RobotDescription, SimTime};
use openbench_localization::graph::FixCount;
use openbench_localization::{Fix, FixSource, Fused, Localizer, PoseDeviation, Presumption, Track};

/// A source whose fixes are set from outside. It gives one a second.
struct Oracle {
    fix: Rc<Cell<Option<Pose2>>>,
    last: SimTime,
    start: Option<PoseDeviation>,
}

impl FixSource for Oracle {
    fn name(&self) -> &str {
        "oracle"
    }

    fn reset(&mut self) {
        self.last = SimTime::ZERO;
    }

    fn start_deviation(&self) -> Option<PoseDeviation> {
        self.start
    }

    fn update(
        &mut self,
        observation: &Observation<'_>,
        _near: Pose2,
        _track: &dyn Track,
    ) -> Option<Fix> {
        if observation.time.since(self.last).as_secs_f64() < 1.0 {
            return None;
        }
        let pose = self.fix.get()?;
        self.last = observation.time;
        Some(Fix {
            stamp: observation.time,
            pose: Isometry2::new(Vector2::new(pose.x, pose.y), pose.yaw),
            information: Matrix3::from_diagonal(&[400.0, 400.0, 1e3].into()),
            max_deviations: 3.0,
        })
    }
}

/// A localizer that starts with one pose, and a robot that starts at another.
struct Trial {
    localizer: Fused,
    robot: Robot,
    fix: Rc<Cell<Option<Pose2>>>,
}

/// What a drive showed.
struct Shown {
    /// The largest step of the pose by a correction, metres.
    jump: f64,
    /// The largest correction that was still to be applied, metres.
    pending: f64,
}

impl Trial {
    fn new(reported: Pose2, truth: Pose2) -> Self {
        Self::with_start(reported, truth, None)
    }

    /// `start` is how well the reported pose is known.
    fn with_start(reported: Pose2, truth: Pose2, start: Option<PoseDeviation>) -> Self {
        let fix = Rc::new(Cell::new(None));
        let oracle = Oracle {
            fix: fix.clone(),
            last: SimTime::ZERO,
            start,
        };
        let mut localizer = Fused::new(RobotDescription::sentry(), vec![Box::new(oracle)]);
        localizer.reset(reported);
        let mut robot = Robot::at(truth);
        robot.drive(&mut localizer, 0.0, 0.0, 2.0);
        Self {
            localizer,
            robot,
            fix,
        }
    }

    /// Drives on. The fix of each second is off by a distance.
    fn drive(&mut self, seconds: f64, off: impl Fn(usize) -> Vector2<f64>) -> Shown {
        let mut shown = Shown {
            jump: 0.0,
            pending: 0.0,
        };
        for step in 0..(seconds / 0.05) as usize {
            let off = off(step / 20);
            let truth = self.robot.truth;
            self.fix.set(Some(Pose2::new(
                truth.x + off.x,
                truth.y + off.y,
                truth.yaw,
            )));
            let odom = self.localizer.odom();
            let before = self.localizer.pose().point();
            self.robot.drive(&mut self.localizer, 0.5, 0.1, 0.05);
            // Where the pose of before is in `map` after the correction.
            let in_odom = odom.inverse_transform(before);
            let after = self.localizer.odom().transform(in_odom.0, in_odom.1);
            shown.jump = shown.jump.max(after.distance(before));
            shown.pending = shown.pending.max(self.localizer.pending());
        }
        shown
    }

    fn error(&self) -> f64 {
        self.localizer
            .pose()
            .point()
            .distance(self.robot.truth.point())
    }
}

#[test]
fn a_wrong_start_is_corrected_without_a_jump() {
    let mut trial = Trial::new(Pose2::new(10.0, 5.0, 0.3), Pose2::new(10.0, 5.5, 0.31));
    let Shown { jump, pending } = trial.drive(60.0, |_| Vector2::zeros());
    assert!(trial.error() < 0.05, "{}", trial.error());
    assert!(
        jump < 0.0101 && jump > 0.009 && pending > 0.2,
        "{jump} {pending}"
    );
    let deviation = trial.localizer.covariance().unwrap()[(0, 0)].sqrt();
    assert!(deviation < 0.1 && deviation > 1e-3, "{deviation}");
}

#[test]
fn a_robot_that_knows_nothing_is_put_where_the_first_fix_says() {
    let unknown = PoseDeviation {
        metres: 1000.0,
        radians: 3.0,
    };
    // Three kilometres away, and the other way round.
    let truth = Pose2::new(3000.0, -200.0, -2.9);
    let mut trial = Trial::with_start(Pose2::default(), truth, Some(unknown));
    assert!(!trial.localizer.is_located());
    let Shown { jump, .. } = trial.drive(2.0, |_| Vector2::zeros());
    assert!(trial.localizer.is_located());
    assert!(
        jump > 2900.0 && trial.error() < 0.05,
        "{jump} {}",
        trial.error()
    );
    let deviation = trial.localizer.covariance().unwrap()[(0, 0)].sqrt();
    assert!(deviation < 0.1, "{deviation}");
    // From then on there is no jump.
    let Shown { jump, .. } = trial.drive(20.0, |_| Vector2::new(0.1, 0.0));
    assert!(jump < 0.0101, "{jump}");
}

/// A source that presumes what is set from outside, and gives each fix once.
#[derive(Clone, Default)]
struct Guide {
    presumption: Rc<Cell<Option<Presumption>>>,
    information: Rc<Cell<Option<Matrix3<f64>>>>,
}

impl FixSource for Guide {
    fn name(&self) -> &str {
        "guide"
    }

    fn reset(&mut self) {}

    fn start_deviation(&self) -> Option<PoseDeviation> {
        Some(PoseDeviation {
            metres: 10.0,
            radians: 0.3,
        })
    }

    fn presumption(&self) -> Option<Presumption> {
        self.presumption.get()
    }

    /// The robot is at (100, 50).
    fn update(&mut self, observation: &Observation<'_>, _: Pose2, _: &dyn Track) -> Option<Fix> {
        Some(Fix {
            stamp: observation.time,
            pose: Isometry2::new(Vector2::new(100.0, 50.0), 0.0),
            information: self.information.take()?,
            max_deviations: 100.0,
        })
    }
}

/// A robot that stands, and what guides it.
fn standing(start: Pose2) -> (Fused, Robot, Guide) {
    let guide = Guide::default();
    let sources: Vec<Box<dyn FixSource>> = vec![Box::new(guide.clone())];
    let mut localizer = Fused::new(RobotDescription::sentry(), sources);
    localizer.reset(start);
    let mut robot = Robot::at(start);
    robot.drive(&mut localizer, 0.0, 0.0, 2.0);
    (localizer, robot, guide)
}

#[test]
fn what_a_source_presumes_is_followed_with_a_jump_only_if_it_is_elsewhere() {
    let (mut localizer, mut robot, guide) = standing(Pose2::new(95.0, 50.0, 0.0));
    assert!(!localizer.is_presumed());
    let mut presume = |x: f64| {
        let odom = Pose2::default();
        let map = Pose2::new(x, 50.0, 0.0);
        guide.presumption.set(Some(Presumption { odom, map }));
        robot.drive(&mut localizer, 0.0, 0.0, 0.1);
        assert!(localizer.is_presumed() && !localizer.is_located());
        localizer.pose().x
    };
    let near = |x: f64, expected: f64| (x - expected).abs() < 0.05;
    assert!(near(presume(99.0), 99.0));
    // Nearly there: slowly.
    assert!(near(presume(99.5), 99.0));
    // Elsewhere: at once.
    assert!(near(presume(110.0), 110.0));
}

#[test]
fn fixes_of_which_none_says_where_the_robot_is_do_so_together() {
    let (mut localizer, mut robot, guide) = standing(Pose2::new(95.0, 50.0, 0.0));
    let mut fix = |information: [f64; 3]| {
        let information = Matrix3::from_diagonal(&information.into());
        guide.information.set(Some(information));
        robot.drive(&mut localizer, 0.0, 0.0, 0.1);
        (localizer.is_located(), localizer.pose().x)
    };
    // Across the road, and along it.
    assert!(!fix([0.0, 400.0, 1e3]).0);
    let (is_located, x) = fix([400.0, 0.0, 0.0]);
    assert!(is_located && (x - 100.0).abs() < 0.05, "{x}");
}

/// Two of three fixes are outliers, and differ from each other.
fn mostly_wrong(i: usize) -> Vector2<f64> {
    let seconds = i as f64;
    let direction = Vector2::new(libm::sin(seconds), libm::cos(3.0 * seconds));
    direction * (10.0 * (i % 3) as f64)
}

#[test]
fn outliers_change_nothing() {
    let start = Pose2::new(-3.0, 8.0, 2.0);
    let mut trial = Trial::new(start, start);
    let pending = trial.drive(60.0, mostly_wrong).pending;
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
fn a_fix_that_contains_nan_changes_nothing() {
    let start = Pose2::new(1.0, 2.0, 0.5);
    let mut trial = Trial::new(start, start);
    let Shown { jump, pending } = trial.drive(5.0, |_| Vector2::new(f64::NAN, 0.0));
    assert!(jump < 1e-9 && pending < 1e-9 && trial.error() < 0.05);
}

/// A source that finds the robot again, and counts how often it had to search anew.
struct Searcher(Rc<Cell<usize>>);

impl FixSource for Searcher {
    fn name(&self) -> &str {
        "searcher"
    }

    fn reset(&mut self) {}

    fn finds(&self) -> bool {
        true
    }

    fn lose(&mut self) {
        self.0.set(self.0.get() + 1);
    }

    fn update(&mut self, _: &Observation<'_>, _: Pose2, _: &dyn Track) -> Option<Fix> {
        None
    }
}

#[test]
fn a_robot_that_sees_nothing_for_long_is_searched_anew_once() {
    let searches = Rc::new(Cell::new(0));
    let source = Box::new(Searcher(searches.clone()));
    let mut localizer = Fused::new(RobotDescription::sentry(), vec![source]);
    localizer.reset(Pose2::default());
    let mut robot = Robot::at(Pose2::default());
    robot.drive(&mut localizer, 0.0, 0.0, 2.0);
    robot.drive(&mut localizer, 0.5, 0.0, 10.0);
    assert!(localizer.is_located() && searches.get() == 0);
    // It has no scans: its pose follows wheels and IMU, until it is of no use.
    while searches.get() == 0 && robot.time.seconds() < 3600.0 {
        robot.drive(&mut localizer, 0.5, 0.0, 1.0);
    }
    assert_eq!((searches.get(), localizer.is_located()), (1, false));
    robot.drive(&mut localizer, 0.5, 0.0, 5.0);
    assert_eq!(searches.get(), 1);
}
