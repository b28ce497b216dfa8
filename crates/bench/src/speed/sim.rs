//! The simulator: LiDAR rays, images, and seconds simulated in a second.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cpu_time::ThreadTime;
use openbench_core::{MapPoint, Pose2, Pose3, RobotDescription, SimTime, Velocity};
use openbench_scene::free_space::ground_height;
use openbench_scene::{Movers, RayCaster, World};
use openbench_sim::lidar::{Lidar, RAYS};
use openbench_sim::noise::Noise;
use openbench_sim::{Simulator, Stage, View};
use serde::Serialize;

use super::{dump, fastest, peak_memory_mb};
use crate::{BenchError, WorldSource};

/// Most places from which scans and images are taken.
const PLACES: usize = 20;
/// Distance of those places in front of doors, metres.
const BEFORE_DOORS: f64 = 3.0;
/// Seconds that the whole is simulated for.
const DRIVE: f64 = 20.0;
/// Goes of which the fastest counts.
const GOES: usize = 3;

/// What was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimSpeed {
    /// The world.
    pub world: String,
    /// Visible triangles.
    pub triangles: usize,
    /// Million LiDAR rays in a second of one core, all that a scan needs included: aiming, casting, noise, points.
    pub lidar_mrays_per_core_second: f64,
    /// Million of the same rays, ordered and cast only, holes in leaves not regarded: what peers are compared with.
    pub cast_mrays_per_core_second: f64,
    /// Camera images of 640 x 480 in a second of one core.
    pub camera_fps_per_core: f64,
    /// Seconds simulated in a second of one core, with physics, IMU, wheels and LiDAR.
    pub rtf_lidar: f64,
    /// The same with an image ten times a second.
    pub rtf_camera: f64,
    /// Seconds from the world's files to the first step.
    pub load_seconds: f64,
    /// Most memory held, megabytes; null where the system does not say.
    pub peak_memory_mb: Option<f64>,
}

/// Measures a world. With `dump`, the triangles and rays go into that folder.
pub fn measure(source: &WorldSource, dump: Option<&Path>) -> Result<SimSpeed, BenchError> {
    let began = Instant::now();
    let world = source.load()?;
    let (name, start, doors) = (world.name.clone(), world.start, places(&world));
    let triangles = world.scene.triangles.len();
    let stage =
        Stage::new(RayCaster::new(Arc::new(world.scene))).map_err(|e| BenchError::World(e.to_string()))?;
    let mut simulator = Simulator::new(stage.clone(), RobotDescription::sentry(), start, 0);
    simulator.step(Velocity::ZERO);
    let load_seconds = began.elapsed().as_secs_f64();
    drop(simulator);
    let speed = SimSpeed {
        world: name,
        triangles,
        lidar_mrays_per_core_second: lidar(&stage, &doors),
        cast_mrays_per_core_second: cast(&stage, &doors),
        camera_fps_per_core: camera(&stage, &doors),
        rtf_lidar: drive(&stage, start, false),
        rtf_camera: drive(&stage, start, true),
        load_seconds,
        peak_memory_mb: peak_memory_mb(),
    };
    if let Some(folder) = dump {
        dump::write(folder, &stage, &sensors(&stage, &doors), &speed)?;
    }
    Ok(speed)
}

/// Places in front of doors, facing them, spread over the world.
fn places(world: &World) -> Vec<Pose2> {
    let doors = &world.scene.doors;
    let stride = doors.len().div_ceil(PLACES).max(1);
    let before = |door: &openbench_scene::Door| {
        let at: MapPoint = door.point().offset(door.facing, BEFORE_DOORS);
        Pose2::new(at.x, at.y, at.bearing_to(door.point()))
    };
    let spread: Vec<Pose2> = doors.iter().step_by(stride).map(before).collect();
    if spread.is_empty() { vec![world.start] } else { spread }
}

/// Poses of the robot's base on the ground at these places.
fn bases(stage: &Stage, places: &[Pose2]) -> Vec<Pose3> {
    places.iter().map(|p| p.to_pose3(ground_height(stage.caster(), p.point()))).collect()
}

fn sensors(stage: &Stage, places: &[Pose2]) -> Vec<Pose3> {
    let mount = RobotDescription::sentry().lidar;
    bases(stage, places).iter().map(|base| base * mount).collect()
}

fn lidar(stage: &Stage, places: &[Pose2]) -> f64 {
    let mut lidar = Lidar::new(Noise::new(0, 2));
    let movers = Movers::default();
    let poses = sensors(stage, places);
    let time = fastest(GOES, || {
        for pose in &poses {
            std::hint::black_box(lidar.scan(stage.snapshot(&movers), SimTime::ZERO, &[*pose; 2]));
        }
    });
    (RAYS * poses.len()) as f64 / time.as_secs_f64() / 1e6
}

fn cast(stage: &Stage, places: &[Pose2]) -> f64 {
    let mut lidar = Lidar::new(Noise::new(0, 2));
    let poses = sensors(stage, places);
    let time = fastest(GOES, || {
        for pose in &poses {
            std::hint::black_box(lidar.ranges(stage.caster().visible(), &[*pose; 2]));
        }
    });
    (RAYS * poses.len()) as f64 / time.as_secs_f64() / 1e6
}

fn camera(stage: &Stage, places: &[Pose2]) -> f64 {
    let robot = RobotDescription::sentry();
    let optics = robot.camera_intrinsics;
    let bases = bases(stage, places);
    let time = fastest(GOES, || {
        for base in &bases {
            let pose = base * robot.camera;
            let size = (optics.width, optics.height);
            let focal_length = optics.focal_length();
            let view = View { pose, size, focal_length, range: 200.0, shadows: false, exposure: 1.0 };
            std::hint::black_box(stage.renderer().render(&view, &Movers::default()));
        }
    });
    bases.len() as f64 / time.as_secs_f64()
}

/// Drives in circles.
fn drive(stage: &Stage, start: Pose2, images: bool) -> f64 {
    let mut simulator = Simulator::new(stage.clone(), RobotDescription::sentry(), start, 0);
    let began = ThreadTime::now();
    while simulator.time().seconds() < DRIVE {
        simulator.step(Velocity::new(0.4, 0.3));
        if images {
            std::hint::black_box(simulator.observation().camera.image());
        }
    }
    simulator.time().seconds() / began.elapsed().as_secs_f64()
}
