//! The robot on flat ground and before a wall.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use openbench_core::{Pose2, RobotDescription, Velocity};
use openbench_scene::scene::Layer;
use openbench_scene::{Material, RayCaster, SceneBuilder, SemanticClass};
use openbench_sim::{LeftWorld, Simulator, Stage};

/// Ground of 40 m x 40 m at z = 0.1 and a wall across x = 3.
fn stage() -> Stage {
    let mut builder = SceneBuilder::new();
    let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4, 0.5, 0.3]));
    let wall = builder.material(Material::plain(SemanticClass::Wall, [0.6; 3]));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    builder.rectangle(
        Layer::Both,
        ground,
        Point3::new(-20.0, -20.0, 0.1),
        (x * 40.0, y * 40.0),
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        wall,
        Point3::new(3.0, -5.0, 0.1),
        (y * 10.0, z * 2.0),
        [1.0; 2],
    );
    Stage::new(RayCaster::new(Arc::new(builder.build()))).unwrap()
}

fn simulator(yaw: f64, seed: u64) -> Simulator {
    let start = Pose2::new(0.0, 0.0, yaw);
    Simulator::new(stage(), RobotDescription::sentry(), start, seed)
}

fn drive(simulator: &mut Simulator, velocity: Velocity, seconds: f64) -> Pose2 {
    for _ in 0..(seconds / 0.05).round() as usize {
        simulator.step(velocity);
    }
    Pose2::from_pose3(&simulator.base_link())
}

#[test]
fn the_robot_settles_on_the_ground_and_stays() {
    let mut simulator = simulator(0.7, 1);
    let pose = drive(&mut simulator, Velocity::ZERO, 3.0);
    assert!(
        pose.point().distance(Default::default()) < 0.005 && (pose.yaw - 0.7).abs() < 0.005,
        "{pose:?}"
    );
    let height = simulator.base_link().translation.z;
    assert!((height - 0.1).abs() < 0.01, "{height}");
    assert!(simulator.collisions().is_empty());
}

#[test]
fn it_drives_and_turns_about_as_told() {
    let mut simulator = simulator(3.0, 1);
    let there = drive(&mut simulator, Velocity::new(0.5, 0.0), 4.0);
    let length = there.point().distance(Default::default());
    assert!(
        (1.7..2.0).contains(&length),
        "0.5 m/s for 4 s with 1 m/s²: {length}"
    );
    let turned = drive(&mut simulator, Velocity::new(0.0, 0.5), 4.0).yaw - there.yaw;
    let turned = turned.rem_euclid(std::f64::consts::TAU);
    assert!((1.7..2.2).contains(&turned), "0.5 rad/s for 4 s: {turned}");
}

/// What the encoders and the body did while driving: metres that the left and right rims ran, metres and radians that the body
/// moved. Half a second passes first, in which the motors come up to speed.
fn driven(velocity: Velocity, seconds: f64) -> ([f64; 2], f64, f64) {
    let mut simulator = simulator(3.0, 1);
    let radius = RobotDescription::sentry().wheel_radius;
    let rims = |s: &Simulator| {
        s.observation()
            .wheels
            .last()
            .map(|w| [w.left * radius, w.right * radius])
            .unwrap()
    };
    let (mut before, mut turned) = (drive(&mut simulator, velocity, 1.0), 0.0);
    let (start, first) = (before, rims(&simulator));
    for _ in 0..(seconds / 0.05) as usize {
        let after = drive(&mut simulator, velocity, 0.05);
        turned += openbench_core::frames::wrap_angle(after.yaw - before.yaw);
        before = after;
    }
    let last = rims(&simulator);
    (
        [last[0] - first[0], last[1] - first[1]],
        start.point().distance(before.point()),
        turned,
    )
}

#[test]
fn turning_on_the_spot_the_wheels_slip_as_on_a_wider_track() {
    let robot = RobotDescription::sentry();
    for rate in [0.3, 0.6, 1.0] {
        let ([left, right], moved, turned) = driven(Velocity::new(0.0, rate), 4.0);
        let track = (right - left) / turned;
        // Wheels 0.26 m apart in y and 0.2 m in x. Friction against the slip makes no moment when a · a = b / 2 · (rim / rate - b / 2),
        // a half the distance in x: the track is b + 4 a² / b, 1.59 times b, whatever the friction.
        let expected = robot.wheel_separation + 4.0 * 0.1 * 0.1 / robot.wheel_separation;
        assert!(
            (track / expected - 1.0).abs() < 0.05,
            "{track} at {rate} rad/s, not {expected}"
        );
        assert!(
            (track / robot.effective_track - 1.0).abs() < 0.05,
            "{track} at {rate} rad/s: not as described"
        );
        assert!(moved < 0.02, "{moved} m off the spot");
    }
}

#[test]
fn driving_straight_the_wheels_hardly_slip() {
    let ([left, right], moved, turned) = driven(Velocity::new(0.5, 0.0), 4.0);
    assert!(
        (left / moved - 1.0).abs() < 0.005 && (right / moved - 1.0).abs() < 0.005,
        "{left} {right} {moved}"
    );
    assert!(turned.abs() < 0.002, "{turned}");
}

#[test]
fn a_wheel_that_is_held_up_slips_and_the_encoder_counts_on() {
    let mut simulator = simulator(0.0, 1);
    let held = drive(&mut simulator, Velocity::new(0.5, 0.0), 10.0);
    let turns = |s: &Simulator| s.observation().wheels.last().map(|w| w.left).unwrap();
    let before = turns(&simulator);
    let after = drive(&mut simulator, Velocity::new(0.5, 0.0), 2.0);
    assert!(
        after.point().distance(held.point()) < 0.02,
        "the wall is in the way"
    );
    assert!(
        (turns(&simulator) - before) * 0.06 > 0.95,
        "the rims run a metre"
    );
}

#[test]
fn a_wall_stops_the_robot_and_counts_once() {
    let mut simulator = simulator(0.0, 1);
    let pose = drive(&mut simulator, Velocity::new(0.5, 0.0), 12.0);
    assert!((2.7..2.9).contains(&pose.x), "{pose:?}");
    let collisions = simulator.collisions();
    assert_eq!(collisions.len(), 1, "{collisions:?}");
    assert_eq!(collisions[0].class, SemanticClass::Wall);
    assert!(collisions[0].impulse > 0.5);
}

/// Ground, and across x = 1 a kerb of that height.
fn kerb(height: f64) -> Simulator {
    let mut builder = SceneBuilder::new();
    let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4, 0.5, 0.3]));
    let stone = builder.material(Material::plain(SemanticClass::Kerb, [0.6; 3]));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    builder.rectangle(
        Layer::Both,
        ground,
        Point3::new(-20.0, -20.0, 0.0),
        (x * 40.0, y * 40.0),
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.0, -5.0, 0.0),
        (y * 10.0, z * height),
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.0, -5.0, height),
        (x * 0.14, y * 10.0),
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.14, -5.0, 0.0),
        (y * 10.0, z * height),
        [1.0; 2],
    );
    let stage = Stage::new(RayCaster::new(Arc::new(builder.build()))).unwrap();
    Simulator::new(
        stage,
        RobotDescription::sentry(),
        Pose2::new(0.0, 0.0, 0.0),
        1,
    )
}

#[test]
fn a_raised_kerb_stops_the_robot_and_is_a_collision_with_a_kerb() {
    let mut simulator = kerb(0.12);
    let pose = drive(&mut simulator, Velocity::new(0.5, 0.0), 5.0);
    assert!((0.6..0.9).contains(&pose.x), "{pose:?}");
    let classes: Vec<SemanticClass> = simulator.collisions().iter().map(|c| c.class).collect();
    assert_eq!(classes, [SemanticClass::Kerb]);
}

#[test]
fn wheels_go_over_a_low_kerb() {
    let mut simulator = kerb(0.02);
    let pose = drive(&mut simulator, Velocity::new(0.5, 0.0), 6.0);
    assert!(pose.x > 2.0, "{pose:?}");
    assert!(
        simulator.collisions().is_empty(),
        "{:?}",
        simulator.collisions()
    );
}

#[test]
fn absurd_velocities_do_no_harm() {
    let mut simulator = simulator(3.0, 1);
    for velocity in [
        Velocity::new(f64::NAN, f64::INFINITY),
        Velocity::new(1e300, -1e300),
    ] {
        let pose = drive(&mut simulator, velocity, 1.0);
        assert!(pose.x.is_finite() && pose.x.abs() < 2.0);
    }
}

#[test]
fn the_same_seed_gives_the_same_chain_and_another_does_not() {
    let chain = |seed| {
        let mut simulator = simulator(0.5, seed);
        drive(&mut simulator, Velocity::new(0.4, 0.3), 2.0);
        simulator.chain()
    };
    assert_eq!(chain(7), chain(7));
    assert_ne!(chain(7), chain(8));
}

#[test]
fn sensors_come_at_their_rates_with_stamps_of_their_own() {
    let mut simulator = simulator(0.0, 1);
    let (mut imu, mut scans, mut images) = (0, 0, 0);
    for _ in 0..20 {
        simulator.step(Velocity::ZERO);
        let observation = simulator.observation();
        imu += observation.imu.len();
        assert!(observation.imu.iter().all(|s| s.stamp <= observation.time));
        if let Some(scan) = observation.scan {
            scans += 1;
            let last = scan.points.last().unwrap();
            assert!(scan.stamp.0 + u64::from(last.offset_ns) <= observation.time.0);
        }
        images += usize::from(observation.camera.image().is_some());
    }
    assert_eq!((imu, scans, images), (100, 10, 10));
}

#[test]
fn the_camera_adjusts_its_exposure_even_when_nobody_looks() {
    let mean = |image: &openbench_core::Image| {
        image.rgb.iter().map(|c| f64::from(*c)).sum::<f64>() / image.rgb.len() as f64
    };
    // Close before a pale wall in the sun, then turned to the sky above the meadow.
    let mut simulator = Simulator::new(
        stage(),
        RobotDescription::sentry(),
        Pose2::new(2.0, 0.0, 0.0),
        1,
    );
    simulator.step(Velocity::ZERO);
    let first = simulator.observation().camera.image().unwrap();
    assert!((100.0..140.0).contains(&mean(&first)), "{}", mean(&first));
    drive(&mut simulator, Velocity::new(0.0, 1.0), 4.0);
    let second = simulator.observation().camera.image().unwrap();
    assert!((100.0..140.0).contains(&mean(&second)), "{}", mean(&second));
}

#[test]
fn at_rest_the_imu_feels_gravity_upwards() {
    let mut simulator = simulator(0.0, 1);
    drive(&mut simulator, Velocity::ZERO, 1.0);
    let sample = simulator.observation().imu.last().copied().unwrap();
    assert!(
        (sample.accel[2] - 9.8).abs() < 0.25 && sample.accel[0].abs() < 0.25,
        "{sample:?}"
    );
    assert!(sample.gyro.iter().all(|w| w.abs() < 0.02), "{sample:?}");
}

#[test]
fn a_robot_that_leaves_the_ground_has_left_the_world() {
    let start = Pose2::new(-19.0, 0.0, std::f64::consts::PI);
    let mut simulator = Simulator::new(stage(), RobotDescription::sentry(), start, 1);
    drive(&mut simulator, Velocity::new(0.5, 0.0), 1.0);
    assert_eq!(simulator.left_world(), None);
    drive(&mut simulator, Velocity::new(0.5, 0.0), 4.0);
    // Over the edge it tips before it falls.
    assert_eq!(simulator.left_world(), Some(LeftWorld::TippedOver));
    let beyond = Pose2::new(-30.0, 0.0, 0.0);
    let mut falling = Simulator::new(stage(), RobotDescription::sentry(), beyond, 1);
    drive(&mut falling, Velocity::ZERO, 1.0);
    assert_eq!(falling.left_world(), Some(LeftWorld::OffTheGround));
    for outside in [Pose2::new(-90.0, 0.0, 0.0), Pose2::new(0.0, 90.0, 0.0)] {
        let far = Simulator::new(stage(), RobotDescription::sentry(), outside, 1);
        assert_eq!(far.left_world(), Some(LeftWorld::OutOfBounds));
    }
}

/// Wheel rays are in single precision, but on level ground their lengths depend on heights alone.
#[test]
fn a_robot_kilometres_from_the_origin_drives_as_one_near_it() {
    let driven = |x: f64| {
        let mut builder = SceneBuilder::new();
        let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4, 0.5, 0.3]));
        let (corner, sides) = (
            Point3::new(x - 32.0, -32.0, 0.0),
            (Vector3::x() * 64.0, Vector3::y() * 64.0),
        );
        builder.rectangle(Layer::Both, ground, corner, sides, [1.0; 2]);
        let stage = Stage::new(RayCaster::new(Arc::new(builder.build()))).unwrap();
        let start = Pose2::new(x, 0.0, 0.3);
        let mut simulator = Simulator::new(stage, RobotDescription::sentry(), start, 1);
        let end = drive(&mut simulator, Velocity::new(0.5, 0.2), 10.0);
        (end.x - x, end.y, end.yaw)
    };
    let (here, there) = (driven(0.0), driven(4096.0));
    let apart = libm::hypot(here.0 - there.0, here.1 - there.1);
    assert!(
        apart < 1e-4 && (here.2 - there.2).abs() < 1e-4,
        "{here:?} against {there:?}"
    );
}
