//! The robot on flat ground, in front of a wall and at kerbs.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use openbench_core::{Pose2, RobotDescription, Velocity};
use openbench_scene::{Layer, Material, RayCaster, SceneBuilder, SemanticClass};
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
        x * 40.0,
        y * 40.0,
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        wall,
        Point3::new(3.0, -5.0, 0.1),
        y * 10.0,
        z * 2.0,
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
fn a_robot_that_is_carried_stands_elsewhere_and_its_imu_noticed_nothing() {
    let mut simulator = simulator(0.0, 1);
    drive(&mut simulator, Velocity::new(0.4, 0.0), 2.0);
    simulator.carry_to(Pose2::new(-8.0, 5.0, 2.0));
    simulator.step(Velocity::ZERO);
    let there = Pose2::from_pose3(&simulator.base_link());
    assert!(
        (there.x + 8.0).abs() < 0.01 && (there.yaw - 2.0).abs() < 0.01,
        "{there:?}"
    );
    // A stop from 0.4 m/s within a sample would be 40 m/s².
    for sample in simulator.observation().imu {
        assert!(sample.accel[0].abs() < 2.0 && sample.gyro[2].abs() < 0.1);
    }
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
fn the_robot_drives_and_turns_about_as_commanded() {
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

/// Motion of the wheels and of the body during a drive.
struct Driven {
    /// Distances that the rims ran, metres.
    left: f64,
    right: f64,
    /// Straight distance that the body moved, metres.
    moved: f64,
    /// Angle that the body turned, radians.
    turned: f64,
}

/// Drives with a velocity, after a second in which the motors come up to speed.
fn driven(velocity: Velocity, seconds: f64) -> Driven {
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
    Driven {
        left: last[0] - first[0],
        right: last[1] - first[1],
        moved: start.point().distance(before.point()),
        turned,
    }
}

#[test]
fn wheels_slip_in_turns_as_on_a_wider_track() {
    let robot = RobotDescription::sentry();
    for rate in [0.3, 0.6, 1.0] {
        let Driven {
            left,
            right,
            moved,
            turned,
        } = driven(Velocity::new(0.0, rate), 4.0);
        let track = (right - left) / turned;
        // Wheels are b = 0.26 m apart in y and 2 a = 0.2 m in x. Friction against the slip makes no
        // moment when a · a = b / 2 · (rim / rate - b / 2): the track is b + 4 a² / b, 1.59 times
        // b, whatever the friction.
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
fn wheels_hardly_slip_on_a_straight_drive() {
    let Driven {
        left,
        right,
        moved,
        turned,
    } = driven(Velocity::new(0.5, 0.0), 4.0);
    assert!(
        (left / moved - 1.0).abs() < 0.005 && (right / moved - 1.0).abs() < 0.005,
        "{left} {right} {moved}"
    );
    assert!(turned.abs() < 0.002, "{turned}");
}

#[test]
fn blocked_wheels_slip_and_their_encoders_count_on() {
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
fn a_wall_stops_the_robot_and_counts_as_one_collision() {
    let mut simulator = simulator(0.0, 1);
    let pose = drive(&mut simulator, Velocity::new(0.5, 0.0), 12.0);
    assert!((2.7..2.9).contains(&pose.x), "{pose:?}");
    let collisions = simulator.collisions();
    assert_eq!(collisions.len(), 1, "{collisions:?}");
    assert_eq!(collisions[0].class, SemanticClass::Wall);
    assert!(collisions[0].impulse > 0.5);
}

/// Ground, and a kerb of this height across x = 1.
fn kerb(height: f64) -> Simulator {
    let mut builder = SceneBuilder::new();
    let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4, 0.5, 0.3]));
    let stone = builder.material(Material::plain(SemanticClass::Kerb, [0.6; 3]));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    builder.rectangle(
        Layer::Both,
        ground,
        Point3::new(-20.0, -20.0, 0.0),
        x * 40.0,
        y * 40.0,
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.0, -5.0, 0.0),
        y * 10.0,
        z * height,
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.0, -5.0, height),
        x * 0.14,
        y * 10.0,
        [1.0; 2],
    );
    builder.rectangle(
        Layer::Both,
        stone,
        Point3::new(1.14, -5.0, 0.0),
        y * 10.0,
        z * height,
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
fn nan_and_huge_velocities_are_harmless() {
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
        simulator.hash_chain()
    };
    assert_eq!(chain(7), chain(7));
    assert_ne!(chain(7), chain(8));
}

#[test]
fn sensors_have_their_rates_and_stamps() {
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
fn the_camera_adjusts_its_exposure_even_without_requests() {
    let mean = |image: &openbench_core::Image| {
        image.rgb.iter().map(|c| f64::from(*c)).sum::<f64>() / image.rgb.len() as f64
    };
    // Close to a pale wall in the sun, then turned to the sky above the meadow.
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
fn the_imu_at_rest_measures_gravity_upwards() {
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
    // It tips over the edge before it falls.
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
fn a_robot_drives_kilometres_from_the_origin_as_near_it() {
    let driven = |x: f64| {
        let mut builder = SceneBuilder::new();
        let ground = builder.material(Material::plain(SemanticClass::Ground, [0.4, 0.5, 0.3]));
        let corner = Point3::new(x - 32.0, -32.0, 0.0);
        let (east, north) = (Vector3::x() * 64.0, Vector3::y() * 64.0);
        builder.rectangle(Layer::Both, ground, corner, east, north, [1.0; 2]);
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
