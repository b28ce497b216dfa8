//! The contract of `Localizer`, checked on each implementation.

mod common;

use common::{Robot, seen};
use openbench_core::frames::wrap_angle;
use openbench_core::{ImuSample, Pose2, RobotDescription, SimTime, WheelSample};
use openbench_localization::{DeadReckoning, Fused, LidarInertial, Localizer};

type Make = fn() -> Box<dyn Localizer>;

const LOCALIZERS: [Make; 3] = [
    || Box::new(DeadReckoning::new(RobotDescription::sentry())),
    || Box::new(LidarInertial::new(RobotDescription::sentry())),
    || Box::new(Fused::new(RobotDescription::sentry(), vec![])),
];

/// Whether two poses differ by less than a distance, metres, and an angle, radians.
fn is_near(a: Pose2, b: Pose2, metres: f64, radians: f64) -> bool {
    a.point().distance(b.point()) < metres && wrap_angle(a.yaw - b.yaw).abs() < radians
}

/// Whether two poses are the same except for rounding.
fn is_same(a: Pose2, b: Pose2) -> bool {
    is_near(a, b, 1e-6, 1e-6)
}

#[test]
fn it_begins_at_its_start_and_stays_there_at_rest() {
    let start = Pose2::new(12.0, -7.0, 2.5);
    for make in LOCALIZERS {
        let (mut localizer, mut robot) = (make(), Robot::at(start));
        localizer.reset(start);
        assert!(!localizer.name().is_empty());
        assert!(is_same(localizer.pose(), start));
        robot.drive(localizer.as_mut(), 0.0, 0.0, 30.0);
        let pose = localizer.pose();
        assert!(
            localizer.ready() && is_near(pose, start, 0.01, 0.01),
            "{pose:?}"
        );
    }
}

#[test]
fn it_follows_a_drive_and_its_history_agrees_with_its_poses() {
    for make in LOCALIZERS {
        let start = Pose2::new(1.0, 2.0, -3.0);
        let (mut localizer, mut robot) = (make(), Robot::at(start));
        localizer.reset(start);
        robot.drive(localizer.as_mut(), 0.0, 0.0, 5.0);
        for (linear, angular) in [(0.4, 0.0), (0.3, 0.5), (0.0, -0.8), (0.5, 0.1)] {
            robot.drive(localizer.as_mut(), linear, angular, 4.0);
        }
        let pose = localizer.pose();
        assert!(is_near(pose, robot.truth, 0.05, 0.01), "{pose:?} after 5 m");
        assert!(is_same(localizer.pose_at(robot.time), pose));
        let before = localizer.pose_at(SimTime(robot.time.0 - 500_000_000));
        let driven = before.point().distance(pose.point());
        assert!(
            (0.2..0.3).contains(&driven),
            "half a second at 0.5 m/s: {driven}"
        );
        localizer.reset(start);
        assert!(is_same(localizer.pose(), start) && !localizer.ready());
    }
}

#[test]
fn broken_samples_do_not_break_it() {
    for make in LOCALIZERS {
        let mut localizer = make();
        localizer.reset(Pose2::default());
        let mut robot = Robot::at(Pose2::default());
        robot.drive(localizer.as_mut(), 0.0, 0.0, 2.0);
        let stamp = SimTime(robot.time.0 + 10_000_000);
        let nan = [ImuSample {
            stamp,
            gyro: [f64::NAN; 3],
            accel: [f64::INFINITY; 3],
        }];
        let far = [WheelSample {
            stamp,
            left: f64::NAN,
            right: f64::INFINITY,
        }];
        // Empty observations, NaN and infinity, and time that runs backwards.
        localizer.update(&seen(robot.time, &[], &[]));
        localizer.update(&seen(stamp, &nan, &far));
        let early = SimTime::ZERO;
        let imu = [ImuSample {
            stamp: early,
            gyro: [0.0; 3],
            accel: [0.0; 3],
        }];
        let wheels = [WheelSample {
            stamp: early,
            left: 0.0,
            right: 0.0,
        }];
        localizer.update(&seen(early, &imu, &wheels));
        robot.drive(localizer.as_mut(), 0.0, 0.0, 1.0);
        let pose = localizer.pose();
        assert!(is_near(pose, Pose2::default(), 0.05, 0.05), "{pose:?}");
    }
}
