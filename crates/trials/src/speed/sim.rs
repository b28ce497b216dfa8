//! Speed of the simulator: LiDAR rays, images, real-time factor.

use std::num::NonZeroU32;
use std::path::Path;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use openbench_core::{MapPoint, Pose2, Pose3, RobotDescription, SimTime, Velocity};
use openbench_osm::OsmMap;
use openbench_scene::{Movers, RayCaster, Snapshot, World, ground_height};
use openbench_sim::lidar::{Lidar, RAYS_PER_SCAN};
use openbench_sim::noise::Noise;
use openbench_sim::traffic::{MoverKind, TrafficPlan};
use openbench_sim::{ImageSize, Simulator, Stage, Surroundings, View};
use serde::Serialize;
use serde_json::json;

use super::{dump, fastest, peak_memory_mb};
use openbench_bench::suite::Conditions;
use openbench_bench::worlds::{load, surroundings};
use openbench_bench::{BenchError, WorldSource};

/// Maximum number of viewpoints for scans and images.
const MAX_VIEWPOINTS: usize = 20;
/// Distance of the viewpoints from doors.
const VIEW_DISTANCE_M: f64 = 3.0;
/// Duration of a simulated drive.
const DRIVE_S: f64 = 20.0;
/// How a robot moves whose images are blurred: nearly as fast as it can turn.
const TURNING: Velocity = Velocity {
    linear: 0.2,
    angular: 0.8,
};
/// Lamps that light an image: the most that the simulator lets count, in a circle around the robot.
const LAMPS: u32 = 30;
const LAMP_DISTANCE_M: f64 = 12.0;
/// Repetitions of a measurement, of which the fastest counts.
const REPETITIONS: usize = 5;
/// Repetitions of a drive, of which the fastest counts.
const DRIVE_REPETITIONS: usize = 2;

/// The measured speeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimSpeed {
    /// Name of the world.
    pub world: String,
    /// Number of static triangles.
    pub triangles: usize,
    /// Number of moving people.
    pub pedestrians: usize,
    /// Number of moving cars.
    pub cars: usize,
    /// LiDAR rays, millions per core and second, for a complete scan: aiming, casting, noise, and
    /// points.
    pub lidar_mrays_per_core_second: f64,
    /// The same with mixed pixels, panes, ghosts and rain.
    pub real_lidar_mrays_per_core_second: f64,
    /// The same rays, sorted and cast only, without transparent textures: comparable with other ray
    /// casters.
    pub cast_mrays_per_core_second: f64,
    /// Camera images of 640 x 480 pixels per core and second.
    pub camera_fps_per_core: f64,
    /// The same of a turning robot with noise, motion blur, a rolling shutter, a bent lens with
    /// drops, and the shadows of a drawn sun.
    pub camera_day_fps_per_core: f64,
    /// The same at night, lit by 30 lamps and without shadows.
    pub camera_night_fps_per_core: f64,
    /// Real-time factor on one core with physics, IMU, wheels and LiDAR.
    pub rtf_lidar: f64,
    /// The same with ten images per simulated second.
    pub rtf_camera: f64,
    /// Time from the world's files to the first step, seconds.
    pub load_seconds: f64,
    /// Peak memory, megabytes; null if the system does not report it.
    pub peak_memory_mb: Option<f64>,
}

/// Measures the simulator in a world with people and cars. With `dump`, triangles and rays are
/// written to that folder.
///
/// # Errors
/// A world that cannot be built, traffic that cannot be placed, or a file that cannot be written.
pub fn measure(
    source: &WorldSource,
    plan: TrafficPlan,
    dump: Option<&Path>,
) -> Result<SimSpeed, BenchError> {
    let began = Instant::now();
    let world = load(source)?;
    // Before the scene is moved into the stage.
    let (name, start, doors) = (world.name.clone(), world.start, places(&world));
    let map = (!plan.is_empty()).then(|| OsmMap::new(&world.map, world.georeference));
    let triangles = world.scene.triangles.len();
    let [day, night] = ["day", "night"].map(|light| hard(&world, light, "dry"));
    let (day, night, rain) = (day?, night?, hard(&world, "day", "rain")?);
    let stage = Stage::with_figures(world.scene, plan).map_err(BenchError::world)?;
    let scenery = Scenery {
        stage,
        map,
        plan,
        start,
    };
    let mut simulator = scenery.simulator()?;
    simulator.step(Velocity::ZERO);
    let load_seconds = began.elapsed().as_secs_f64();
    let placed = (simulator.movers().iter())
        .filter(|m| m.kind == MoverKind::Pedestrian)
        .count();
    let (pedestrians, cars) = (placed, simulator.movers().len() - placed);
    let seen = simulator.snapshot();
    let speed = SimSpeed {
        world: name,
        triangles,
        pedestrians,
        cars,
        lidar_mrays_per_core_second: lidar(seen, &doors, Lidar::new(Noise::new(0, 2))),
        real_lidar_mrays_per_core_second: lidar(seen, &doors, spoiled(&rain)),
        cast_mrays_per_core_second: cast(seen.caster, &doors),
        camera_fps_per_core: camera(&scenery.stage, seen.movers, &doors),
        camera_day_fps_per_core: scenery.real_camera(&doors, |_| day.clone())?,
        camera_night_fps_per_core: scenery.real_camera(&doors, |place| lamplit(&night, place))?,
        rtf_lidar: scenery.drive(false)?,
        rtf_camera: scenery.drive(true)?,
        load_seconds,
        peak_memory_mb: peak_memory_mb(),
    };
    if let Some(folder) = dump {
        let measured = json!({ "world": speed.world, "triangles": speed.triangles, "ours": speed });
        dump::write(
            folder,
            &scenery.stage,
            &sensors(seen.caster, &doors),
            measured,
        )?;
    }
    Ok(speed)
}

/// A world with its traffic.
struct Scenery {
    stage: Stage,
    /// The map of the traffic; `None` without traffic.
    map: Option<OsmMap>,
    plan: TrafficPlan,
    start: Pose2,
}

impl Scenery {
    fn simulator(&self) -> Result<Simulator, BenchError> {
        self.simulator_at(self.start, &Surroundings::default())
    }

    fn simulator_at(
        &self,
        start: Pose2,
        surroundings: &Surroundings,
    ) -> Result<Simulator, BenchError> {
        let (stage, robot) = (self.stage.clone(), RobotDescription::sentry());
        let still = Simulator::new(stage, robot, start, 0).in_surroundings(surroundings);
        let Some(map) = &self.map else {
            return Ok(still);
        };
        still
            .with_traffic_on(map, self.plan, 0)
            .map_err(BenchError::world)
    }

    /// Images per core and second of a robot that turns before doors, by what it meets there.
    /// Rendering alone counts.
    fn real_camera(
        &self,
        places: &[Pose2],
        met: impl Fn(Pose2) -> Surroundings,
    ) -> Result<f64, BenchError> {
        let (mut fastest, mut count) = (Duration::ZERO, 0);
        for place in places {
            let mut simulator = self.simulator_at(*place, &met(*place))?;
            let mut best = Duration::MAX;
            for _ in 0..REPETITIONS {
                // Two steps, since the camera takes ten images a second.
                simulator.step(TURNING);
                simulator.step(TURNING);
                let began = ThreadTime::now();
                std::hint::black_box(simulator.observation().camera.image());
                best = best.min(began.elapsed());
            }
            fastest += best;
            count += 1;
        }
        Ok(f64::from(count) / fastest.as_secs_f64())
    }

    /// The real-time factor of a drive in circles.
    fn drive(&self, images: bool) -> Result<f64, BenchError> {
        let mut best = 0.0_f64;
        for _ in 0..DRIVE_REPETITIONS {
            let mut simulator = self.simulator()?;
            let began = ThreadTime::now();
            while simulator.time().seconds() < DRIVE_S {
                simulator.step(Velocity::new(0.4, 0.3));
                if images {
                    std::hint::black_box(simulator.observation().camera.image());
                }
            }
            best = best.max(simulator.time().seconds() / began.elapsed().as_secs_f64());
        }
        Ok(best)
    }
}

/// A cheap camera and a real LiDAR in this light and weather.
fn hard(world: &World, light: &str, weather: &str) -> Result<Surroundings, BenchError> {
    let mut conditions = Conditions::default();
    let levels = [
        ("camera", "cheap"),
        ("light", light),
        ("weather", weather),
        ("lidar", "real"),
    ];
    conditions.set_all(levels).map_err(BenchError::world)?;
    Ok(surroundings(world, &conditions, 0))
}

/// The same with so many street lamps around a place that an image is lit by as many as ever are.
fn lamplit(night: &Surroundings, place: Pose2) -> Surroundings {
    let mut met = night.clone();
    met.street_lamps.extend((0..LAMPS).map(|i| {
        let direction = std::f64::consts::TAU * f64::from(i) / f64::from(LAMPS);
        place.point().offset(direction, LAMP_DISTANCE_M)
    }));
    met
}

/// Viewpoints in front of doors, facing them, spread over the world.
fn places(world: &World) -> Vec<Pose2> {
    let doors = &world.scene.doors;
    let stride = doors.len().div_ceil(MAX_VIEWPOINTS).max(1);
    let before = |door: &openbench_scene::Door| {
        let at: MapPoint = door.point().offset(door.facing, VIEW_DISTANCE_M);
        Pose2::new(at.x, at.y, at.bearing_to(door.point()))
    };
    let spread: Vec<Pose2> = doors.iter().step_by(stride).map(before).collect();
    if spread.is_empty() {
        vec![world.start]
    } else {
        spread
    }
}

/// Poses of the robot's base on the ground at the viewpoints.
fn bases(caster: &RayCaster, places: &[Pose2]) -> Vec<Pose3> {
    places
        .iter()
        .map(|p| p.to_pose3(ground_height(caster, p.point())))
        .collect()
}

fn sensors(caster: &RayCaster, places: &[Pose2]) -> Vec<Pose3> {
    let mount = RobotDescription::sentry().lidar;
    bases(caster, places)
        .iter()
        .map(|base| base * mount)
        .collect()
}

/// A LiDAR with all errors.
fn spoiled(met: &Surroundings) -> Lidar {
    Lidar::new(Noise::new(0, 2)).with_errors(met.lidar, met.weather.air(), 0)
}

/// Rays a second, millions.
fn lidar(seen: Snapshot<'_>, places: &[Pose2], mut lidar: Lidar) -> f64 {
    let poses = sensors(seen.caster, places);
    let time = fastest(REPETITIONS, || {
        for pose in &poses {
            // A path of two equal poses: the sensor stands still during the scan.
            std::hint::black_box(lidar.scan(seen, SimTime::ZERO, &[*pose; 2], NonZeroU32::MIN));
        }
    });
    (RAYS_PER_SCAN * poses.len()) as f64 / time.as_secs_f64() / 1e6
}

fn cast(caster: &RayCaster, places: &[Pose2]) -> f64 {
    let mut lidar = Lidar::new(Noise::new(0, 2));
    let poses = sensors(caster, places);
    let time = fastest(REPETITIONS, || {
        for pose in &poses {
            std::hint::black_box(lidar.ranges(caster.visible(), &[*pose; 2]));
        }
    });
    (RAYS_PER_SCAN * poses.len()) as f64 / time.as_secs_f64() / 1e6
}

fn camera(stage: &Stage, movers: &Movers, places: &[Pose2]) -> f64 {
    let robot = RobotDescription::sentry();
    let optics = robot.camera_intrinsics;
    let size = ImageSize::new(optics.width, optics.height);
    let focal_length = optics.focal_length();
    let bases = bases(stage.caster(), places);
    let time = fastest(REPETITIONS, || {
        for base in &bases {
            let pose = base * robot.camera;
            let view = View {
                pose,
                size,
                focal_length,
                // Range and shadows as those of the robot's camera.
                range: 200.0,
                shadows: false,
                exposure: 1.0,
            };
            std::hint::black_box(stage.renderer().render(&view, movers));
        }
    });
    bases.len() as f64 / time.as_secs_f64()
}
