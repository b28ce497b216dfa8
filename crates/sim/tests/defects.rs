//! Robots that differ from their description.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use openbench_core::{Pose2, RobotDescription, SimTime, Velocity};
use openbench_scene::{Layer, Material, RayCaster, SceneBuilder, SemanticClass};
use openbench_sim::{Defects, Mount, Simulator, Stage, Surroundings, Weather};

/// Flat ground of a class, 40 m x 40 m, with a wall across x = 3.
fn stage(class: SemanticClass) -> Stage {
    let mut builder = SceneBuilder::new();
    let ground = builder.material(Material::plain(class, [0.4, 0.5, 0.3]));
    let wall = builder.material(Material::plain(SemanticClass::Wall, [0.6; 3]));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let corner = Point3::new(-20.0, -20.0, 0.0);
    builder.rectangle(Layer::Both, ground, corner, x * 40.0, y * 40.0, [1.0; 2]);
    let corner = Point3::new(3.0, -5.0, 0.0);
    builder.rectangle(Layer::Both, wall, corner, y * 10.0, z * 2.0, [1.0; 2]);
    Stage::new(RayCaster::new(Arc::new(builder.build()))).unwrap()
}

fn robot(defects: Defects) -> Simulator {
    on(SemanticClass::Road, defects)
}

fn on(class: SemanticClass, defects: Defects) -> Simulator {
    let described = RobotDescription::sentry();
    Simulator::with_defects(stage(class), described, &defects, Pose2::default(), 1)
}

/// Drives for some seconds; returns where the robot is then, and the angles of its wheels.
fn drive(simulator: &mut Simulator, velocity: Velocity, seconds: f64) -> (Pose2, [f64; 2]) {
    for _ in 0..(seconds / 0.05).round() as usize {
        simulator.step(velocity);
    }
    let wheels = simulator.observation().wheels.last().unwrap();
    let pose = Pose2::from_pose3(&simulator.base_link());
    (pose, [wheels.left, wheels.right])
}

#[test]
fn a_smaller_wheel_turns_the_robot_and_its_encoder_does_not_see_it() {
    let ahead = Velocity::new(0.4, 0.0);
    let worn = Defects {
        left_wheel: 0.97,
        ..Defects::default()
    };
    let (straight, _) = drive(&mut robot(Defects::default()), ahead, 4.0);
    let (bent, [left, right]) = drive(&mut robot(worn), ahead, 4.0);
    assert!(straight.yaw.abs() < 0.01, "{straight:?}");
    // 3 % of the way over the effective track, to the left.
    assert!((0.08..0.16).contains(&bent.yaw), "{bent:?}");
    assert!((left - right).abs() < 0.01, "{left} {right}");
}

#[test]
fn a_wider_track_turns_the_robot_less() {
    let turn = Velocity::new(0.0, 0.5);
    let turned = |track| {
        let defects = Defects {
            track,
            ..Defects::default()
        };
        drive(&mut robot(defects), turn, 4.0).0.yaw
    };
    assert!(turned(1.2) < 0.97 * turned(1.0));
}

#[test]
fn a_turned_lidar_sees_the_wall_turned() {
    // The bearing of the point nearest ahead, degrees: that of the wall's foot point.
    let bearing = |turn_deg: f64| {
        let mut simulator = robot(Defects {
            lidar: Mount {
                turn_deg: [0.0, 0.0, turn_deg],
                ..Mount::default()
            },
            ..Defects::default()
        });
        simulator.step(Velocity::ZERO);
        simulator.step(Velocity::ZERO);
        let observation = simulator.observation();
        let points = &observation.scan.unwrap().points;
        let wall = points.iter().filter(|p| p.xyz[0] > 1.0 && p.xyz[2] > 0.0);
        // A line through the wall's points: x = a + b y.
        let (mut n, mut sy, mut sx, mut syy, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for [x, y, _] in wall.map(|p| p.xyz.map(f64::from)) {
            (n, sy, sx, syy, sxy) = (n + 1.0, sy + y, sx + x, syy + y * y, sxy + x * y);
        }
        let slope = (n * sxy - sx * sy) / (n * syy - sy * sy);
        libm::atan(slope).to_degrees()
    };
    assert!((bearing(10.0) - bearing(0.0)).abs() > 9.0);
}

#[test]
fn a_late_clock_stamps_scans_later() {
    let stamp = |lidar_clock_ms| {
        let mut simulator = robot(Defects {
            lidar_clock_ms,
            ..Defects::default()
        });
        simulator.step(Velocity::ZERO);
        simulator.step(Velocity::ZERO);
        simulator.observation().scan.unwrap().stamp
    };
    assert_eq!(stamp(0.0), SimTime::ZERO);
    assert_eq!(stamp(4.0), SimTime::from_millis(4));
}

#[test]
fn tyres_slip_more_on_grass() {
    // Full speed at once: what the motors ask for is more than grass gives.
    let turned = |class, slips| {
        let defects = Defects {
            slips,
            ..Defects::default()
        };
        drive(&mut on(class, defects), Velocity::new(0.0, 1.0), 3.0)
            .0
            .yaw
    };
    let asphalt = turned(SemanticClass::Road, true);
    assert_eq!(asphalt, turned(SemanticClass::Road, false));
    assert_eq!(asphalt, turned(SemanticClass::Ground, false));
    let grass = turned(SemanticClass::Ground, true);
    assert!(grass < asphalt, "{grass} {asphalt}");
}

#[test]
fn tyres_slip_more_on_wet_asphalt() {
    let turned = |weather| {
        let defects = Defects {
            slips: true,
            ..Defects::default()
        };
        let surroundings = Surroundings {
            weather,
            ..Surroundings::default()
        };
        let robot = on(SemanticClass::Road, defects);
        let mut robot = robot.in_surroundings(&surroundings);
        drive(&mut robot, Velocity::new(0.0, 1.0), 3.0).0.yaw
    };
    let wet = Weather {
        wetness: 1.0,
        ..Weather::DRY
    };
    assert!(turned(wet) < turned(Weather::DRY));
}

#[test]
fn a_robot_without_defects_is_the_described_one() {
    let chain = |mut simulator: Simulator| {
        drive(&mut simulator, Velocity::new(0.3, 0.2), 1.0);
        simulator.hash_chain()
    };
    let described = RobotDescription::sentry();
    let start = Pose2::default();
    let plain = Simulator::new(stage(SemanticClass::Road), described, start, 1);
    assert_eq!(chain(plain), chain(robot(Defects::default())));
}
