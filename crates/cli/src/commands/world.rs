//! `openbench world`

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use openbench_bench::WorldSource;
use openbench_core::{Pose2, Pose3, RobotDescription};
use openbench_scene::{RayCaster, World, free_space::ground_height};
use openbench_sim::{Renderer, View};

use crate::args::{ShowArgs, WorldArgs, WorldCommand};
use crate::outcome::{Outcome, say, tell};

/// Does what is asked with worlds.
pub fn run(args: &WorldArgs) -> anyhow::Result<Outcome> {
    match &args.command {
        WorldCommand::Show(args) => show(args),
    }
}

fn show(args: &ShowArgs) -> anyhow::Result<Outcome> {
    let world = source(args)?.load()?;
    world.warnings.iter().for_each(|w| tell(w));
    let caster = RayCaster::new(Arc::new(world.scene.clone()));
    let view = match args.from {
        Some(pose) => street_view(&caster, pose),
        None => birds_eye(&world),
    };
    let rgb = Renderer::new(caster).render(&view);
    let picture =
        openbench_core::Image { stamp: Default::default(), width: view.size.0, height: view.size.1, rgb };
    let png = openbench_bench::picture::png(&picture)?;
    openbench_osm::write_atomically(&args.out, &png)?;
    let scene = &world.scene;
    say(&format!(
        "{}: {} triangles, {} doors; picture in {}\n",
        world.name,
        scene.triangles.len(),
        scene.doors.len(),
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
        (Some(name), ..) => Ok(WorldSource::Builtin { name: name.clone(), seed: 1 }),
        _ => anyhow::bail!("name a built-in world, or give --world and --map"),
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
    }
}

/// From high up in the south, looking down at the middle.
fn birds_eye(world: &World) -> View {
    let doors = world.scene.doors.iter().map(openbench_scene::Door::point);
    let points: Vec<_> = doors.chain([world.start.point()]).collect();
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
    }
}
