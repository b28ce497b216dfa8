//! `openbench world`

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use nalgebra::{UnitQuaternion, Vector3};
use openbench_bench::WorldSource;
use openbench_bench::world_folder::{Recipe, Wanted, Written, is_world, write};
use openbench_core::{Pose2, Pose3, RobotDescription};
use openbench_osm::{Window, cut_out, default_georeference};
use openbench_scene::{Movers, RayCaster, World, free_space::ground_height};
use openbench_sim::{Renderer, View};

use crate::args::{DrawArgs, GenerateArgs, ImportArgs, ShowArgs, WorldArgs, WorldCommand};
use crate::commands::read_data;
use crate::outcome::{Outcome, say, tell};

/// Does what is asked with worlds.
pub fn run(args: &WorldArgs) -> anyhow::Result<Outcome> {
    match &args.command {
        WorldCommand::Generate(args) => generate(args),
        WorldCommand::Import(args) => import(args),
        WorldCommand::Show(args) => show(args),
    }
}

fn generate(args: &GenerateArgs) -> anyhow::Result<Outcome> {
    let whole = read_data(&args.map)?;
    let window = match args.around {
        Some(middle) => Some(Window::around(middle, args.radius)?),
        None => args.bbox,
    };
    let map = match &window {
        Some(window) => cut_out(&whole, window),
        None => whole,
    };
    let file = args.map.display();
    if let Some(window) = window.filter(|_| map.nodes.is_empty()) {
        anyhow::bail!("{file}: nothing of the map lies in {window} (west, south, east, north)");
    }
    let georeference = match args.georef {
        Some(georeference) => georeference,
        None => default_georeference(&map).with_context(|| file.to_string())?,
    };
    let source = args.map.file_name().unwrap_or_default().to_string_lossy();
    let recipe = Recipe::Generated {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        name: args.name.clone().unwrap_or_else(|| folder_name(&args.out)),
        map: Recipe::map_file(),
        seed: args.seed,
        georeference: georeference.to_string(),
        start: args.start.map(|p| [p.x, p.y, p.yaw.to_degrees()]),
        parked_cars: args.parked_cars,
        planting: args.planting,
        invent_doors: !args.mapped_doors_only,
        attribution: vec![format!(
            "Map `{source}`: © OpenStreetMap contributors, ODbL 1.0, where it comes from there"
        )],
    };
    let written = write(&args.out, &recipe, &map, wanted(&args.drawn, args.seed));
    report(&written.with_context(|| file.to_string())?, &args.out)
}

fn import(args: &ImportArgs) -> anyhow::Result<Outcome> {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let map = read_data(&args.map)?;
    let georeference = match args.georef {
        Some(georeference) => georeference,
        None => default_georeference(&map).with_context(|| args.map.display().to_string())?,
    };
    let recipe = Recipe::Imported {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        name: args.world.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        world: absolute(&args.world),
        map: Recipe::map_file(),
        models: args.models.iter().map(|m| absolute(m)).collect(),
        georeference: georeference.to_string(),
    };
    let written = write(&args.out, &recipe, &map, wanted(&args.drawn, args.seed))?;
    report(&written, &args.out)
}

fn wanted(drawn: &DrawArgs, seed: u64) -> Wanted {
    let count = |i: usize| drawn.draw.get(i).map_or(0, |n| usize::from(*n));
    Wanted { singles: count(0), sequences: (count(1), count(2)), reach: drawn.reach, seed }
}

fn report(written: &Written, out: &Path) -> anyhow::Result<Outcome> {
    let (world, suite) = (&written.prepared.world, &written.prepared.suite);
    world.warnings.iter().for_each(|w| tell(w));
    say(&format!(
        "{}: {} triangles, {} doors, {} within a robot's reach, {} to deliver to; {} episodes in {}\n",
        world.name,
        world.scene.triangles.len(),
        world.scene.doors.len(),
        written.reachable,
        written.candidates,
        suite.episodes.len(),
        out.display()
    ))?;
    Ok(Outcome::Done)
}

fn folder_name(path: &Path) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    absolute.file_name().map_or("generated".into(), |n| n.to_string_lossy().into_owned())
}

fn show(args: &ShowArgs) -> anyhow::Result<Outcome> {
    let world = source(args)?.load()?;
    world.warnings.iter().for_each(|w| tell(w));
    let caster = RayCaster::new(Arc::new(world.scene.clone()));
    let view = match args.from {
        Some(pose) => street_view(&caster, pose),
        None => birds_eye(&world, args.above),
    };
    let rgb = Renderer::new(caster).render(&view, &Movers::default());
    let picture =
        openbench_core::Image { stamp: Default::default(), width: view.size.0, height: view.size.1, rgb };
    let png = openbench_bench::picture::png(&picture)?;
    openbench_osm::write_atomically(&args.out, &png)?;
    let scene = &world.scene;
    say(&format!(
        "{}: {} triangles, {} doors, start {:.2},{:.2},{:.0}; picture in {}\n",
        world.name,
        scene.triangles.len(),
        scene.doors.len(),
        world.start.x,
        world.start.y,
        world.start.yaw.to_degrees(),
        args.out.display()
    ))?;
    Ok(Outcome::Done)
}

fn source(args: &ShowArgs) -> anyhow::Result<WorldSource> {
    match (&args.name, &args.world, &args.map) {
        (_, Some(world), Some(map)) => Ok(WorldSource::Imported {
            world: world.clone(),
            map: map.clone(),
            models: args.models.clone(),
            georeference: args.georef.clone(),
        }),
        (Some(name), ..) if is_world(Path::new(name)) => {
            Ok(WorldSource::Folder { path: std::path::absolute(name)? })
        }
        (Some(name), ..) => Ok(WorldSource::Builtin { name: name.clone(), seed: 1 }),
        _ => anyhow::bail!("name a built-in world or a world's folder, or give --world and --map"),
    }
}

/// As the robot's camera sees from `pose`, in twice its size.
fn street_view(caster: &RayCaster, pose: Pose2) -> View {
    let robot = RobotDescription::sentry();
    let ground = ground_height(caster, pose.point());
    let optics = robot.camera_intrinsics;
    View {
        pose: pose.to_pose3(ground) * robot.camera,
        size: (2 * optics.width, 2 * optics.height),
        focal_length: 2.0 * optics.focal_length(),
        range: 200.0,
        shadows: true,
        exposure: 1.0,
    }
}

/// From high up in the south, looking down at the middle.
fn birds_eye(world: &World, near: Option<f64>) -> View {
    let start = world.start.point();
    let doors = world.scene.doors.iter().map(openbench_scene::Door::point);
    let shown = doors.filter(|p| near.is_none_or(|near| p.distance(start) <= near));
    let points: Vec<_> = shown.chain([start]).collect();
    let bound = |f: fn(f64, f64) -> f64, get: fn(&openbench_core::MapPoint) -> f64| {
        points.iter().map(get).reduce(f).unwrap_or(0.0)
    };
    let (x0, x1) = (bound(f64::min, |p| p.x), bound(f64::max, |p| p.x));
    let (y0, y1) = (bound(f64::min, |p| p.y), bound(f64::max, |p| p.y));
    let reach = (x1 - x0).max(1.4 * (y1 - y0)).max(20.0) + 16.0;
    let pitch = 58.0_f64.to_radians();
    let distance = 1.15 * reach;
    let middle = Vector3::new((x0 + x1) / 2.0, (y0 + y1) / 2.0, 0.0);
    let rotation = UnitQuaternion::from_euler_angles(0.0, pitch, std::f64::consts::FRAC_PI_2);
    let eye = middle - rotation * Vector3::x() * distance;
    View {
        pose: Pose3::from_parts(eye.into(), rotation),
        size: (1600, 1100),
        focal_length: 1600.0,
        range: 5000.0,
        shadows: true,
        exposure: 1.0,
    }
}
