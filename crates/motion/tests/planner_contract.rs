//! The contract of `LocalPlanner`, checked on each implementation.

use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::feasible::clearance;
use openbench_motion::local::built_in::built_in;
use openbench_motion::local::make_planner;
use openbench_motion::{
    Blocked, Follower, Footprint, Limits, LocalPlanner, Motion, Mppi, Navigator, Obstacle,
    PlannerSettings, Progress, Situation, Teb, TebSettings, Vector2,
};
use proptest::prelude::*;

/// A new planner of each kind, from the same settings each time.
fn planners() -> impl Iterator<Item = Box<dyn LocalPlanner>> {
    let settings = PlannerSettings::new(RobotDescription::sentry()).with_seed(7);
    let planners: Vec<_> = built_in()
        .entries()
        .map(|entry| make_planner(entry, &settings).unwrap())
        .collect();
    planners.into_iter()
}

/// Seconds between two calls.
const STEP: f64 = 0.05;

fn points(corners: &[(f64, f64)]) -> Vec<MapPoint> {
    corners.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
}

/// A drive with ideal wheels.
struct Drive {
    /// Where it ended.
    pose: Pose2,
    arrived: bool,
    /// The last cause of being blocked.
    blocked: Option<Blocked>,
    /// The least distance to an obstacle, metres.
    nearest: f64,
}

fn drive(
    planner: &mut dyn LocalPlanner,
    path: &[MapPoint],
    yaw: Option<f64>,
    obstacles: &[Obstacle],
    seconds: f64,
) -> Drive {
    let robot = RobotDescription::sentry();
    let (limits, footprint) = (Limits::of(&robot).unwrap(), Footprint::of(&robot).unwrap());
    let mut motion = Motion {
        pose: Pose2::default(),
        velocity: Velocity::ZERO,
        command: Velocity::ZERO,
    };
    let mut drive = Drive {
        pose: motion.pose,
        arrived: false,
        blocked: None,
        nearest: 1.0,
    };
    for i in 0..(seconds / STEP) as u32 {
        let time = SimTime::ZERO + Duration::from_millis(50) * i;
        let situation = Situation {
            time,
            pose: motion.pose,
            velocity: motion.velocity,
            path,
            final_yaw: yaw,
            obstacles,
        };
        motion.command = Velocity::ZERO;
        match planner.plan(&situation) {
            Ok(Progress::Drive(velocity) | Progress::Slowed(velocity, _)) => {
                motion.command = velocity
            }
            Ok(Progress::Arrived) => {
                drive.arrived = true;
                break;
            }
            Err(blocked) => drive.blocked = Some(blocked),
        }
        motion.step(&limits, STEP);
        drive.nearest = drive.nearest.min(clearance(
            &footprint,
            obstacles.iter(),
            motion.pose,
            0.0,
            1.0,
        ));
    }
    drive.pose = motion.pose;
    drive
}

#[test]
fn a_free_path_is_driven_to_its_end() {
    let path = points(&[(0.0, 0.0), (3.0, 0.5), (3.0, 3.0), (-2.0, 3.0)]);
    for mut planner in planners() {
        let drive = drive(planner.as_mut(), &path, Some(0.0), &[], 60.0);
        let pose = drive.pose;
        assert!(
            drive.arrived
                && pose.point().distance(path[3]) < 0.2
                && wrap_angle(pose.yaw).abs() < 0.15,
            "{pose:?}"
        );
    }
}

#[test]
fn an_obstacle_is_not_touched_and_is_reported() {
    let wall = [Obstacle::wall(MapPoint::new(2.0, -9.0), MapPoint::new(2.0, 9.0)).unwrap()];
    let path = points(&[(0.0, 0.0), (4.0, 0.0)]);
    for mut planner in planners() {
        let drive = drive(planner.as_mut(), &path, None, &wall, 20.0);
        assert!(
            !drive.arrived && drive.nearest > 0.0,
            "{:?} {}",
            drive.pose,
            drive.nearest
        );
        let is_told = matches!(drive.blocked, Some(Blocked::Obstacle(_) | Blocked::NoGap));
        assert!(is_told, "{:?}", drive.blocked);
    }
}

#[test]
fn without_a_path_or_a_pose_the_robot_stands() {
    let nowhere = Pose2::new(f64::NAN, 0.0, 0.0);
    let broken = points(&[(0.0, 0.0), (f64::INFINITY, 0.0)]);
    let plain = points(&[(0.0, 0.0), (1.0, 0.0)]);
    let beyond = points(&[(-1.7e308, 0.0), (1.7e308, 0.0)]);
    let (here, yaw, still) = (Pose2::default(), Some(f64::NAN), Velocity::ZERO);
    let (no_path, no_pose) = (Blocked::NoPath, Blocked::NoPose);
    let cases = [
        (here, still, &[][..], None, no_path),
        (here, still, &broken, None, no_path),
        (here, still, &beyond, None, no_path),
        (here, still, &plain, yaw, no_path),
        (nowhere, still, &plain, None, no_pose),
        (here, Velocity::new(f64::NAN, 0.0), &plain, None, no_pose),
        (here, Velocity::new(0.0, 1e308), &plain, None, no_pose),
    ];
    for (pose, velocity, path, final_yaw, why) in cases {
        let time = SimTime::ZERO;
        let situation = Situation {
            time,
            pose,
            velocity,
            path,
            final_yaw,
            obstacles: &[],
        };
        for mut planner in planners() {
            assert_eq!(planner.plan(&situation), Err(why), "{pose:?} {path:?}");
        }
    }
}

#[test]
fn impossible_limits_of_a_robot_are_refused() {
    let odd = |change: fn(&mut RobotDescription)| {
        let mut robot = RobotDescription::sentry();
        change(&mut robot);
        robot
    };
    let robots = [
        odd(|r| r.max_forward = -0.5),
        odd(|r| r.max_turn = 0.0),
        odd(|r| r.max_acceleration = f64::NAN),
        odd(|r| r.max_backward = f64::INFINITY),
        odd(|r| r.max_backward = -0.1),
        odd(|r| r.max_turn = f64::NAN),
        odd(|r| r.width = 0.0),
        odd(|r| r.length = f64::NAN),
    ];
    for robot in robots {
        assert!(
            Teb::new(&robot, TebSettings::default()).is_err() && Mppi::new(&robot, 0).is_err(),
            "{robot:?}"
        );
        assert!(Follower::new(robot.clone()).is_err(), "{robot:?}");
        assert!(
            Navigator::new(&robot, planners().next().unwrap()).is_err(),
            "{robot:?}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn velocities_are_within_the_limits_and_repeat(
        corners in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 1..6),
        (x, y, yaw) in (-9.0..9.0_f64, -9.0..9.0_f64, -4.0..4.0_f64),
        discs in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64, 0.0..0.6_f64), 0..12),
    ) {
        let robot = RobotDescription::sentry();
        let (path, pose) = (points(&corners), Pose2::new(x, y, yaw));
        let disc = |&(x, y, r): &(f64, f64, f64)| Obstacle::disc(MapPoint::new(x, y), r).unwrap();
        let obstacles: Vec<Obstacle> = discs.iter().map(disc).collect();
        let situation = Situation {
            time: SimTime::ZERO,
            pose,
            velocity: Velocity::ZERO,
            path: &path,
            final_yaw: Some(1.0),
            obstacles: &obstacles,
        };
        for (mut planner, mut other) in planners().zip(planners()) {
            let decided = planner.plan(&situation);
            prop_assert_eq!(decided, other.plan(&situation));
            if let Some(v) = decided.ok().and_then(|decided| decided.velocity()) {
                let speeds = -robot.max_backward..=robot.max_forward;
                prop_assert!(speeds.contains(&v.linear), "{v:?}");
                prop_assert!(v.angular.abs() <= robot.max_turn, "{v:?}");
            }
        }
    }
}

#[test]
fn a_drive_repeats_to_the_last_bit() {
    let discs = [(1.0, 0.1), (2.2, -0.4), (2.4, 0.7)]
        .map(|(x, y)| Obstacle::disc(MapPoint::new(x, y), 0.2).unwrap());
    let walker = Obstacle::new(&[MapPoint::new(3.0, -2.0)], 0.25, Vector2::new(0.0, 0.1)).unwrap();
    let obstacles = [&discs[..], &[walker]].concat();
    let path = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)]);
    for (mut planner, mut other) in planners().zip(planners()) {
        let end = |planner: &mut dyn LocalPlanner| {
            drive(planner, &path, Some(1.0), &obstacles, 12.0).pose
        };
        let bits = |pose: Pose2| [pose.x, pose.y, pose.yaw].map(f64::to_bits);
        assert_eq!(bits(end(planner.as_mut())), bits(end(other.as_mut())));
    }
}

/// The error of a planner with changed settings.
fn refused(change: fn(&mut TebSettings)) -> String {
    let mut settings = TebSettings::default();
    change(&mut settings);
    Teb::new(&RobotDescription::sentry(), settings)
        .unwrap_err()
        .to_string()
}

#[test]
fn impossible_settings_are_refused_by_name() {
    let errors = [
        (refused(|s| s.horizon = -1.0), "the horizon is -1"),
        (refused(|s| s.tolerance = f64::NAN), "the tolerance is NaN"),
        (refused(|s| s.hysteresis = 5.0), "the hysteresis is 5"),
        (refused(|s| s.hysteresis = 0.0), "the hysteresis is 0"),
        (
            refused(|s| s.via = Some(0.0)),
            "the distance between via points is 0",
        ),
        (
            refused(|s| s.approach_margin_mps = Some(-1.0)),
            "approach speed of people is -1",
        ),
        (
            refused(|s| s.stopping_time_s = Some(f64::INFINITY)),
            "to stop is inf",
        ),
        (refused(|s| s.band.margins.least = -0.1), "a margin is -0.1"),
        (
            refused(|s| s.band.margins.comfort = 0.0),
            "the margin of comfort is 0",
        ),
        (
            refused(|s| s.band.resolution.near = 1e-300),
            "the first time step is 0.000",
        ),
        (
            refused(|s| s.band.resolution.far = f64::INFINITY),
            "the last time step is inf",
        ),
        (
            refused(|s| s.band.weights.time = -1.0),
            "the weight of time is -1",
        ),
        (
            refused(|s| s.exploring.cell = 0.0),
            "the side of a cell is 0",
        ),
        (
            refused(|s| s.exploring.around = -10.0),
            "around start and goal is -10",
        ),
        (
            refused(|s| s.exploring.most = 0),
            "the number of classes is 0",
        ),
        (
            refused(|s| s.exploring.longest = f64::NAN),
            "by that of the cheapest is NaN",
        ),
    ];
    for (error, wanted) in errors {
        assert!(error.contains(wanted), "{error}");
    }
    let slow = RobotDescription {
        max_forward: -0.5,
        ..RobotDescription::sentry()
    };
    let error = Teb::new(&slow, TebSettings::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("the largest forward speed is -0.5"),
        "{error}"
    );
}
