//! What every `LocalPlanner` keeps to, checked on each implementation.

use std::time::Duration;

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::feasible::clearance;
use openbench_motion::teb::classes::Exploring;
use openbench_motion::teb::settings::Margins;
use openbench_motion::{
    Blocked, Follower, Footprint, LocalPlanner, Mppi, Navigator, Obstacle, Progress, Situation, Teb,
    TebSettings, Vector2,
};
use proptest::prelude::*;

type Make = fn() -> Box<dyn LocalPlanner>;

const PLANNERS: [Make; 3] = [
    || Box::new(Follower::new(RobotDescription::sentry()).unwrap()),
    || Box::new(Teb::new(&RobotDescription::sentry(), TebSettings::default()).unwrap()),
    || Box::new(Mppi::new(&RobotDescription::sentry(), 7).unwrap()),
];

/// Seconds between two calls.
const STEP: f64 = 0.05;

fn points(corners: &[(f64, f64)]) -> Vec<MapPoint> {
    corners.iter().map(|(x, y)| MapPoint::new(*x, *y)).collect()
}

/// A drive with ideal wheels: where it ended, whether the planner said that it was there, and the last that it said of being blocked.
struct Drive {
    pose: Pose2,
    arrived: bool,
    blocked: Option<Blocked>,
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
    let mut motion = Motion { pose: Pose2::default(), velocity: Velocity::ZERO, command: Velocity::ZERO };
    let mut drive = Drive { pose: motion.pose, arrived: false, blocked: None, nearest: 1.0 };
    for i in 0..(seconds / STEP) as u32 {
        let time = SimTime::ZERO + Duration::from_millis(50) * i;
        let situation =
            Situation { time, pose: motion.pose, velocity: motion.velocity, path, final_yaw: yaw, obstacles };
        motion.command = Velocity::ZERO;
        match planner.plan(&situation) {
            Ok(Progress::Drive(velocity) | Progress::Slowed(velocity, _)) => motion.command = velocity,
            Ok(Progress::Arrived) => {
                drive.arrived = true;
                break;
            }
            Err(blocked) => drive.blocked = Some(blocked),
        }
        motion.step(&limits, STEP);
        drive.nearest = drive.nearest.min(clearance(&footprint, obstacles.iter(), motion.pose, 0.0, 1.0));
    }
    drive.pose = motion.pose;
    drive
}

#[test]
fn a_free_way_is_driven_to_its_end() {
    let path = points(&[(0.0, 0.0), (3.0, 0.5), (3.0, 3.0), (-2.0, 3.0)]);
    for make in PLANNERS {
        let drive = drive(make().as_mut(), &path, Some(0.0), &[], 60.0);
        let pose = drive.pose;
        assert!(
            drive.arrived && pose.point().distance(path[3]) < 0.2 && wrap_angle(pose.yaw).abs() < 0.15,
            "{pose:?}"
        );
    }
}

#[test]
fn what_stands_in_the_way_is_not_touched_and_announced() {
    let wall = [Obstacle::wall(MapPoint::new(2.0, -9.0), MapPoint::new(2.0, 9.0)).unwrap()];
    let path = points(&[(0.0, 0.0), (4.0, 0.0)]);
    for make in PLANNERS {
        let drive = drive(make().as_mut(), &path, None, &wall, 20.0);
        assert!(!drive.arrived && drive.nearest > 0.0, "{:?} {}", drive.pose, drive.nearest);
        let is_told = matches!(drive.blocked, Some(Blocked::Obstacle(_) | Blocked::NoGap));
        assert!(is_told, "{:?}", drive.blocked);
    }
}

#[test]
fn without_a_way_or_a_pose_nothing_is_driven() {
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
    for make in PLANNERS {
        for (pose, velocity, path, final_yaw, why) in cases {
            let time = SimTime::ZERO;
            let situation = Situation { time, pose, velocity, path, final_yaw, obstacles: &[] };
            assert_eq!(make().plan(&situation), Err(why), "{pose:?} {path:?}");
        }
    }
}

#[test]
fn a_robot_whose_limits_make_no_sense_has_no_planner() {
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
        assert!(Navigator::new(&robot, PLANNERS[0]()).is_err(), "{robot:?}");
    }
    let mut settings = TebSettings::default();
    settings.band.weights.time = -1.0;
    let error = Teb::new(&RobotDescription::sentry(), settings).unwrap_err().to_string();
    assert!(error.contains("the weight of time is -1"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn velocities_are_within_the_limits_and_repeat(
        corners in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 1..6),
        (x, y, yaw) in (-9.0..9.0_f64, -9.0..9.0_f64, -4.0..4.0_f64),
        stones in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64, 0.0..0.6_f64), 0..12),
    ) {
        let robot = RobotDescription::sentry();
        let (path, pose) = (points(&corners), Pose2::new(x, y, yaw));
        let stones: Vec<Obstacle> = stones.iter().map(|(x, y, r)| Obstacle::disc(MapPoint::new(*x, *y), *r).unwrap()).collect();
        let (time, velocity) = (SimTime::ZERO, Velocity::ZERO);
        let situation = Situation { time, pose, velocity, path: &path, final_yaw: Some(1.0), obstacles: &stones };
        for make in PLANNERS {
            let decide = || make().plan(&situation);
            prop_assert_eq!(decide(), decide());
            if let Some(v) = decide().ok().and_then(|decided| decided.velocity()) {
                prop_assert!(v.linear <= robot.max_forward && v.linear >= -robot.max_backward, "{v:?}");
                prop_assert!(v.angular.abs() <= robot.max_turn, "{v:?}");
            }
        }
    }
}

#[test]
fn a_drive_repeats_to_the_last_bit() {
    let stones =
        [(1.0, 0.1), (2.2, -0.4), (2.4, 0.7)].map(|(x, y)| Obstacle::disc(MapPoint::new(x, y), 0.2).unwrap());
    let walker = Obstacle::new(&[MapPoint::new(3.0, -2.0)], 0.25, Vector2::new(0.0, 0.1)).unwrap();
    let obstacles = [&stones[..], &[walker]].concat();
    let path = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0)]);
    for make in PLANNERS {
        let end = || drive(make().as_mut(), &path, Some(1.0), &obstacles, 12.0).pose;
        let (one, other) = (end(), end());
        let bits = |pose: Pose2| [pose.x, pose.y, pose.yaw].map(f64::to_bits);
        assert_eq!(bits(one), bits(other));
    }
}

#[test]
fn absurd_settings_are_refused_by_name() {
    let robot = RobotDescription::sentry();
    let teb = |settings: TebSettings| Teb::new(&robot, settings).unwrap_err().to_string();
    assert!(teb(TebSettings { horizon: -1.0, ..TebSettings::default() }).contains("the horizon is -1"));
    assert!(
        teb(TebSettings { tolerance: f64::NAN, ..TebSettings::default() }).contains("the tolerance is NaN")
    );
    let default = TebSettings::default;
    let margins = |margins: Margins| {
        let mut settings = default();
        settings.band.margins = margins;
        teb(settings)
    };
    let resolution = |near: f64, far: f64| {
        let mut settings = default();
        (settings.band.resolution.near, settings.band.resolution.far) = (near, far);
        teb(settings)
    };
    let exploring = |exploring: Exploring| teb(TebSettings { exploring, ..default() });
    let (margin, classes) = (Margins::default(), Exploring::default());
    for (told, wanted) in [
        (teb(TebSettings { hysteresis: 5.0, ..default() }), "the hysteresis is 5"),
        (teb(TebSettings { hysteresis: 0.0, ..default() }), "the hysteresis is 0"),
        (teb(TebSettings { via: Some(0.0), ..default() }), "points to pass by is 0"),
        (teb(TebSettings { surprise: Some(-1.0), ..default() }), "the speed of a surprise is -1"),
        (teb(TebSettings { yields: Some(f64::INFINITY), ..default() }), "to stop is inf"),
        (margins(Margins { least: -0.1, ..margin }), "a margin is -0.1"),
        (margins(Margins { comfort: 0.0, ..margin }), "the margin of comfort is 0"),
        (resolution(1e-300, 0.3), "the first time step is 0.000"),
        (resolution(0.1, f64::INFINITY), "the last time step is inf"),
        (exploring(Exploring { cell: 0.0, ..classes }), "the side of a cell is 0"),
        (exploring(Exploring { around: -10.0, ..classes }), "around start and goal is -10"),
        (exploring(Exploring { most: 0, ..classes }), "the number of classes is 0"),
        (
            exploring(Exploring { longest: f64::NAN, ..classes }),
            "the cost of the dearest way, by that of the cheapest is NaN",
        ),
    ] {
        assert!(told.contains(wanted), "{told}");
    }
    let slow = RobotDescription { max_forward: -0.5, ..RobotDescription::sentry() };
    assert!(
        Teb::new(&slow, TebSettings::default())
            .unwrap_err()
            .to_string()
            .contains("the largest forward speed is -0.5")
    );
}
