//! What every `Localizer` keeps to, checked on each implementation.

mod common;

use common::{Robot, seen};
use openbench_core::frames::wrap_angle;
use openbench_core::{ImuSample, MapPoint, Pose2, RobotDescription, SimTime, WheelSample};
use openbench_localization::{DeadReckoning, Fused, LidarInertial, Localizer};

type Make = fn() -> Box<dyn Localizer>;

const LOCALIZERS: [Make; 3] = [
    || Box::new(DeadReckoning::new(RobotDescription::sentry())),
    || Box::new(LidarInertial::new(RobotDescription::sentry())),
    || Box::new(Fused::new(RobotDescription::sentry(), vec![])),
];

fn apart(a: Pose2, b: Pose2) -> (f64, f64) {
    (
        a.point().distance(b.point()),
        wrap_angle(a.yaw - b.yaw).abs(),
    )
}

#[test]
fn it_begins_where_it_is_told_and_stays_there_at_rest() {
    let start = Pose2::new(12.0, -7.0, 2.5);
    for make in LOCALIZERS {
        let (mut localizer, mut robot) = (make(), Robot::at(start));
        localizer.reset(start);
        assert!(!localizer.name().is_empty() && apart(localizer.pose(), start) < (1e-9, 1e-9));
        robot.drive(localizer.as_mut(), 0.0, 0.0, 30.0);
        let (away, turned) = apart(localizer.pose(), start);
        assert!(
            localizer.ready() && away < 0.01 && turned < 0.01,
            "{away} m, {turned} rad"
        );
    }
}

#[test]
fn it_follows_a_drive_and_its_history_agrees_with_what_it_said() {
    for make in LOCALIZERS {
        let start = Pose2::new(1.0, 2.0, -3.0);
        let (mut localizer, mut robot) = (make(), Robot::at(start));
        localizer.reset(start);
        robot.drive(localizer.as_mut(), 0.0, 0.0, 5.0);
        let mut said = Vec::new();
        for (linear, angular) in [(0.4, 0.0), (0.3, 0.5), (0.0, -0.8), (0.5, 0.1)] {
            robot.drive(localizer.as_mut(), linear, angular, 4.0);
            said.push((robot.time, localizer.pose()));
        }
        let (away, turned) = apart(localizer.pose(), robot.truth);
        assert!(
            away < 0.05 && turned < 0.01,
            "{away} m, {turned} rad after 5 m"
        );
        let (time, pose) = *said.last().unwrap();
        assert!(apart(localizer.pose_at(time), pose) < (1e-6, 1e-6));
        let before = localizer.pose_at(SimTime(time.0 - 500_000_000));
        let driven = before.point().distance(pose.point());
        assert!(
            (0.2..0.3).contains(&driven),
            "half a second at 0.5 m/s: {driven}"
        );
        localizer.reset(start);
        assert!(apart(localizer.pose(), start) < (1e-9, 1e-9) && !localizer.ready());
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
        // Nothing, no numbers, and time that runs backwards.
        localizer.update(&seen(robot.time, &[], &[]));
        localizer.update(&seen(stamp, &nan, &far));
        let early = [ImuSample {
            stamp: SimTime::ZERO,
            gyro: [0.0; 3],
            accel: [0.0; 3],
        }];
        localizer.update(&seen(
            SimTime::ZERO,
            &early,
            &[WheelSample {
                stamp: SimTime::ZERO,
                left: 0.0,
                right: 0.0,
            }],
        ));
        robot.drive(localizer.as_mut(), 0.0, 0.0, 1.0);
        let pose = localizer.pose();
        assert!(
            pose.point().distance(MapPoint::default()) < 0.05 && pose.yaw.abs() < 0.05,
            "{pose:?}"
        );
    }
}
