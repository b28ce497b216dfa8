//! What the sensors of a robot meet: cameras with faults, and other light than noon's.

use nalgebra::{Point3, Vector3};
use openbench_core::{Distortion, Image, MapPoint, Pose2, RobotDescription, Velocity};
use openbench_scene::{Finish, Layer, Material, RayCaster, Scene, SceneBuilder, SemanticClass};
use openbench_sim::{CameraErrors, Daylight, LensBuild, LensDrop, Simulator, Stage, Surroundings};
use std::sync::Arc;

const CHEAP: CameraErrors = CameraErrors {
    full_well: 4000.0,
    read_noise: 8.0,
    exposure_ms: 0.5,
    longest_exposure_ms: 33.0,
    readout_ms: 25.0,
    vignetting: 0.3,
    ..CameraErrors::PERFECT
};

/// Grey ground, a white wall 6 m ahead of the origin, and a dark post before it.
fn street() -> Scene {
    let mut builder = SceneBuilder::new();
    let [ground, white, dark] = [[0.4; 3], [0.9; 3], [0.02; 3]]
        .map(|color| builder.material(Material::plain(SemanticClass::Ground, color)));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut board = |material, corner: [f64; 3], u: Vector3<f64>, v: Vector3<f64>| {
        let corner = Point3::from(corner);
        builder.rectangle(Layer::Both, material, corner, u, v, [1.0; 2]);
    };
    board(ground, [-50.0, -50.0, 0.0], x * 100.0, y * 100.0);
    board(white, [6.0, -20.0, 0.0], y * 40.0, z * 12.0);
    board(dark, [5.5, -0.05, 0.0], y * 0.1, z * 12.0);
    builder.build()
}

fn simulator(scene: Scene, met: &Surroundings) -> Simulator {
    let stage = Stage::new(RayCaster::new(Arc::new(scene))).unwrap();
    Simulator::new(stage, RobotDescription::sentry(), Pose2::default(), 7).in_surroundings(met)
}

fn image(simulator: &Simulator) -> Image {
    simulator
        .observation()
        .camera
        .image()
        .unwrap()
        .as_ref()
        .clone()
}

fn cheap() -> Surroundings {
    Surroundings {
        camera: CHEAP,
        lens: LensBuild {
            focal: 1.002,
            distortion: Distortion {
                k1: -0.1,
                ..Distortion::default()
            },
            drops: vec![LensDrop {
                x: 0.3,
                y: 0.4,
                radius: 0.05,
            }],
        },
        ..Surroundings::default()
    }
}

fn night() -> Surroundings {
    Surroundings {
        light: Some(Daylight {
            lamps: true,
            ..Daylight::at(48.2, 1, 0.0)
        }),
        ..Surroundings::default()
    }
}

/// Mean grey value of a row of pixels.
fn mean(image: &Image, rows: std::ops::Range<usize>) -> f64 {
    let width = image.width as usize;
    let part = &image.rgb[3 * width * rows.start..3 * width * rows.end];
    part.iter().map(|value| f64::from(*value)).sum::<f64>() / part.len() as f64
}

#[test]
fn nothing_out_of_the_ordinary_changes_nothing() {
    let stage = Stage::new(RayCaster::new(Arc::new(street()))).unwrap();
    let plain = Simulator::new(stage, RobotDescription::sentry(), Pose2::default(), 7);
    let same = simulator(street(), &Surroundings::default());
    assert_eq!(image(&plain), image(&same));
}

#[test]
fn an_image_depends_on_seed_and_time_and_not_on_those_asked_for_before() {
    let (mut often, mut once) = (simulator(street(), &cheap()), simulator(street(), &cheap()));
    for step in 0..20 {
        often.step(Velocity::new(0.2, 0.8));
        once.step(Velocity::new(0.2, 0.8));
        if step % 2 == 1 {
            often.observation().camera.image();
        }
    }
    assert_eq!(image(&often), image(&once));
    assert_eq!(often.hash_chain(), once.hash_chain());
    let moved = image(&once);
    once.step(Velocity::ZERO);
    once.step(Velocity::ZERO);
    assert_ne!(image(&once), moved, "each image has noise of its own");
}

/// The column in which the post is in a row.
fn post(image: &Image, row: usize) -> f64 {
    let width = image.width as usize;
    let line = &image.rgb[3 * width * row..3 * width * (row + 1)];
    let dark = (0..width).filter(|x| line[3 * x] < 90);
    let columns: Vec<usize> = dark.collect();
    columns.iter().sum::<usize>() as f64 / columns.len() as f64
}

#[test]
fn a_rolling_shutter_tilts_a_post_that_a_turning_robot_sees() {
    let rolling = Surroundings {
        camera: CameraErrors {
            readout_ms: 40.0,
            ..CameraErrors::PERFECT
        },
        ..Surroundings::default()
    };
    let tilt = |turn: f64| {
        let mut simulator = simulator(street(), &rolling);
        for _ in 0..8 {
            simulator.step(Velocity::new(0.0, turn));
        }
        let image = image(&simulator);
        post(&image, 200) - post(&image, 20)
    };
    // 180 of 480 rows take 15 ms, in which 0.8 rad/s are 0.012 rad of 381 pixels.
    let (left, right) = (tilt(0.8), tilt(-0.8));
    assert!((3.0..7.0).contains(&left), "{left}");
    assert!((-7.0..-3.0).contains(&right), "{right}");
    assert!(tilt(0.0).abs() < 0.6);
}

#[test]
fn night_is_dark_and_lamps_light_the_ground_below_them() {
    let noon = image(&simulator(street(), &Surroundings::default()));
    let dark = image(&simulator(street(), &night()));
    let lit = Surroundings {
        street_lamps: vec![MapPoint::new(4.0, 2.0)],
        ..night()
    };
    let lit = image(&simulator(street(), &lit));
    // Sky over the wall, and the ground.
    let (sky, ground) = (10..30, 400..480);
    assert!(mean(&dark, sky.clone()) < 0.7 * mean(&noon, sky));
    let (with, without) = (mean(&lit, ground.clone()), mean(&dark, ground));
    assert!(with > 1.1 * without, "{with} {without}");
}

#[test]
fn a_lit_window_shines_at_night() {
    let mut scene = SceneBuilder::new();
    let ground = scene.material(Material::plain(SemanticClass::Ground, [0.4; 3]));
    let pane = scene.material(Material {
        finish: Finish::Lamp,
        ..Material::plain(SemanticClass::Furniture, [0.1; 3])
    });
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let corner = Point3::new(-50.0, -50.0, 0.0);
    scene.rectangle(Layer::Both, ground, corner, x * 100.0, y * 100.0, [1.0; 2]);
    let corner = Point3::new(8.0, -1.0, 1.0);
    scene.rectangle(Layer::Visible, pane, corner, y * 2.0, z * 2.0, [1.0; 2]);
    let scene = scene.build();
    let image = image(&simulator(scene, &night()));
    let at = |x: usize, y: usize| image.rgb[3 * (640 * y + x)];
    assert!(
        at(320, 180) > 200 && at(100, 180) < 150,
        "{} {}",
        at(320, 180),
        at(100, 180)
    );
}

#[test]
fn a_low_sun_throws_long_shadows() {
    let mut scene = SceneBuilder::new();
    let ground = scene.material(Material::plain(SemanticClass::Ground, [0.4; 3]));
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let corner = Point3::new(-50.0, -50.0, 0.0);
    scene.rectangle(Layer::Both, ground, corner, x * 100.0, y * 100.0, [1.0; 2]);
    // A wall in the west, behind the robot.
    let corner = Point3::new(-6.0, -30.0, 0.0);
    scene.rectangle(Layer::Both, ground, corner, y * 60.0, z * 3.0, [1.0; 2]);
    let scene = scene.build();
    let seen = |hour: f64| {
        let met = Surroundings {
            light: Some(Daylight::at(48.2, 80, hour)),
            ..Surroundings::default()
        };
        let image = image(&simulator(scene.clone(), &met));
        // The ground 4 m ahead, in the shadow in the evening, and 30 m ahead.
        (
            f64::from(image.rgb[3 * (640 * 265 + 320)]),
            mean(&image, 243..245),
        )
    };
    let ((near, far), (near_at_noon, far_at_noon)) = (seen(17.0), seen(12.0));
    assert!(
        near / far < 0.95 * near_at_noon / far_at_noon,
        "{near} {far}"
    );
}
