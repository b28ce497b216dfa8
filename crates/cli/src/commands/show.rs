//! `openbench world show`: pictures of a world, and what their pixels show.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use nalgebra::{UnitQuaternion, Vector3};
use openbench_bench::image_file;
use openbench_bench::suite::Conditions;
use openbench_bench::worlds::folder::is_world;
use openbench_bench::worlds::{load_with, source_named};
use openbench_bench::{TrafficPlan, WorldSource};
use openbench_core::{Image, Pose2, Pose3, RobotDescription, Velocity};
use openbench_osm::{OsmMap, write_atomically};
use openbench_scene::{Movers, RayCaster, Scene, SemanticClass, World, ground_height};
use openbench_sim::{ImageSize, Labels, Simulator, Stage, View};
use serde_json::json;

use super::show_conditions;
use crate::args::ShowArgs;
use crate::outcome::{Outcome, say, tell};

/// Draws a world.
pub fn show(args: &ShowArgs) -> anyhow::Result<Outcome> {
    let mut conditions = Conditions::default();
    let words = args.conditions.iter();
    let set = conditions.set_all(words.map(|(key, value)| (&**key, &**value)));
    set.context("--condition")?;
    let world = load_with(&source(args)?, conditions.alterations(args.seed))?;
    world.warnings.iter().for_each(|w| tell(w));
    let plan = TrafficPlan {
        pedestrians: args.pedestrians.into(),
        cars: args.cars.into(),
    };
    let stage = Stage::with_figures(world.scene.clone(), plan)?;
    if args.levels.is_some() || !is_of_world(&conditions) {
        let pose = pose_of_robot(args)?;
        refuse_outside(&world, pose)?;
        let image = show_conditions::image(args, &world, &stage, pose)?;
        write_picture(&args.out, image, args.quality)?;
        return report(args, &world);
    }
    let view = match args.from {
        Some(pose) => {
            refuse_outside(&world, pose)?;
            street_view(stage.caster(), pose)
        }
        None => birds_eye(&world, args.above),
    };
    let view = View {
        shadows: !args.no_shadows,
        ..view
    };
    let movers = movers(&world, &stage, plan, args.after)?;
    let renderer = stage.renderer();
    let image = Image {
        stamp: Default::default(),
        width: view.size.width,
        height: view.size.height,
        rgb: renderer.render(&view, &movers),
    };
    write_picture(&args.out, image, args.quality)?;
    // Labels are another rendering, so they are made on request only.
    if args.depth.is_some() || args.classes.is_some() || args.instances.is_some() {
        write_labels(args, &renderer.labels(&view, &movers), &world.scene)?;
    }
    report(args, &world)
}

/// Whether conditions change the world alone, and nothing about how a robot sees it.
fn is_of_world(conditions: &Conditions) -> bool {
    conditions.outside_world().are_off()
}

/// The pose for an image as the robot takes it.
fn pose_of_robot(args: &ShowArgs) -> anyhow::Result<Pose2> {
    let labelled = args.depth.is_some() || args.classes.is_some() || args.instances.is_some();
    anyhow::ensure!(
        !labelled,
        "depths, classes and instances do not depend on light, weather or camera; leave \
         --condition out"
    );
    args.from
        .context("light, weather and camera show in an image of the robot: add --from X,Y,YAW")
}

fn report(args: &ShowArgs, world: &World) -> anyhow::Result<Outcome> {
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

/// People and cars where they are after so many seconds.
fn movers(world: &World, stage: &Stage, plan: TrafficPlan, after: u16) -> anyhow::Result<Movers> {
    if plan.is_empty() {
        return Ok(Movers::default());
    }
    let map = OsmMap::new(&world.map, world.georeference);
    let still = Simulator::new(stage.clone(), RobotDescription::sentry(), world.start, 0);
    let mut simulator = still.with_traffic_on(&map, plan, 0)?;
    while simulator.time().seconds() < f64::from(after) {
        simulator.step(Velocity::ZERO);
    }
    Ok(simulator.snapshot().movers.clone())
}

/// JPEG if the name says so, PNG otherwise.
pub(super) fn write_picture(path: &Path, image: Image, quality: u8) -> anyhow::Result<()> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let bytes = if ending == "jpg" || ending == "jpeg" {
        image_file::jpeg_of_quality(&image, quality)?
    } else {
        image_file::png(&image)?
    };
    Ok(write_atomically(path, &bytes)?)
}

fn write_labels(args: &ShowArgs, labels: &Labels, scene: &Scene) -> anyhow::Result<()> {
    if let Some(path) = &args.depth {
        let millimetres: Vec<u16> = labels.depth.iter().map(|d| millimetres(*d)).collect();
        let png = image_file::grey16_png(labels.size.width, labels.size.height, &millimetres)?;
        write_atomically(path, &png)?;
    }
    if let Some(path) = &args.classes {
        let colors = classes(labels).map(color_of_class);
        write_colors(path, labels.size, colors)?;
        write_legend(path, legend_of_classes(labels))?;
    }
    if let Some(path) = &args.instances {
        write_colors(
            path,
            labels.size,
            labels.object.iter().map(|number| color_of_number(*number)),
        )?;
        write_legend(path, legend_of_instances(labels, scene))?;
    }
    Ok(())
}

fn write_colors(
    path: &Path,
    size: ImageSize,
    colors: impl Iterator<Item = [u8; 3]>,
) -> anyhow::Result<()> {
    // Lossless whatever the name: another colour would be another thing.
    let image = Image {
        stamp: Default::default(),
        width: size.width,
        height: size.height,
        rgb: colors.flatten().collect(),
    };
    Ok(write_atomically(path, &image_file::png(&image)?)?)
}

fn write_legend(image: &Path, legend: serde_json::Value) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(&legend)? + "\n";
    Ok(write_atomically(
        &image.with_extension("json"),
        text.as_bytes(),
    )?)
}

/// 0 where nothing is seen; what is too far for 16 bits is 65535.
fn millimetres(depth: f32) -> u16 {
    // The cast ends at 65535.
    if depth.is_finite() {
        (depth * 1000.0).round() as u16
    } else {
        0
    }
}

/// The class of each pixel; that of the sky where nothing is seen.
fn classes(labels: &Labels) -> impl Iterator<Item = SemanticClass> {
    let sky = SemanticClass::Sky;
    labels.class.iter().map(move |class| class.unwrap_or(sky))
}

fn legend_of_classes(labels: &Labels) -> serde_json::Value {
    let mut pixels: BTreeMap<SemanticClass, u64> = BTreeMap::new();
    classes(labels).for_each(|class| *pixels.entry(class).or_default() += 1);
    let entry = |(class, pixels): (&SemanticClass, &u64)| {
        let color = hex(color_of_class(*class));
        json!({ "name": class.name(), "color": color, "pixels": pixels })
    };
    json!({ "classes": pixels.iter().map(entry).collect::<Vec<_>>() })
}

fn legend_of_instances(labels: &Labels, scene: &Scene) -> serde_json::Value {
    // One entry for each number, though a house shows walls, doors and plates. Moving objects have
    // one class each.
    let mut seen: BTreeMap<u32, (Option<SemanticClass>, u64)> = BTreeMap::new();
    for (number, class) in labels.object.iter().zip(&labels.class) {
        seen.entry(*number).or_insert((*class, 0)).1 += 1;
    }
    let entry = |(number, (class, pixels)): (&u32, &(Option<SemanticClass>, u64))| {
        let object = scene.object(*number);
        let class = object.map(|o| o.class).or(*class).map(SemanticClass::name);
        let name = object.map_or(class.unwrap_or("sky"), |object| &object.name);
        let color = hex(color_of_number(*number));
        json!({ "number": number, "name": name, "class": class, "color": color, "pixels": pixels })
    };
    json!({ "instances": seen.iter().map(entry).collect::<Vec<_>>() })
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// One of 16 million colours for each number, with neighbours far apart. The factor is odd, so no
/// two are equal.
fn color_of_number(number: u32) -> [u8; 3] {
    let [_, r, g, b] = number.wrapping_mul(0x9e_3779).to_be_bytes();
    [r, g, b]
}

/// The colours of Cityscapes for the classes that it has.
fn color_of_class(class: SemanticClass) -> [u8; 3] {
    match class {
        SemanticClass::Ground => [152, 251, 152],
        SemanticClass::Road => [128, 64, 128],
        SemanticClass::Pavement => [244, 35, 232],
        SemanticClass::Building => [70, 70, 70],
        SemanticClass::Door => [200, 90, 20],
        SemanticClass::Plate => [255, 230, 0],
        SemanticClass::Wall => [102, 102, 156],
        SemanticClass::Vegetation => [107, 142, 35],
        SemanticClass::Vehicle => [0, 0, 142],
        SemanticClass::Furniture => [153, 153, 153],
        SemanticClass::Person => [220, 20, 60],
        SemanticClass::Kerb => [196, 196, 196],
        SemanticClass::Other => [0, 130, 180],
        SemanticClass::Water => [0, 60, 220],
        SemanticClass::Grass => [60, 190, 60],
        SemanticClass::Hedge => [20, 90, 20],
        SemanticClass::Sky => [70, 130, 180],
    }
}

fn source(args: &ShowArgs) -> anyhow::Result<WorldSource> {
    match (&args.name, &args.world, &args.map) {
        (_, Some(world), Some(map)) => Ok(WorldSource::Imported {
            world: world.clone(),
            map: map.clone(),
            models: args.models.clone(),
            georeference: args.georef.clone(),
        }),
        (Some(name), ..) if is_world(Path::new(name)) => Ok(WorldSource::Folder {
            path: std::path::absolute(name)?,
        }),
        (Some(name), ..) => Ok(source_named(name)),
        _ => anyhow::bail!("name a built-in world or a world's folder, or give --world and --map"),
    }
}

/// Refuses a view from where there is no world.
fn refuse_outside(world: &World, pose: Pose2) -> anyhow::Result<()> {
    let vertices = world.scene.vertices.iter();
    let corners = vertices.map(|v| [v.position[0], v.position[1]].map(f64::from));
    let bounds = corners.fold(
        [f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY],
        |b, [x, y]| [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)],
    );
    let [west, south, east, north] = bounds;
    if !(west..=east).contains(&pose.x) || !(south..=north).contains(&pose.y) {
        anyhow::bail!(
            "--from {},{}: there is nothing; the world reaches from {west:.0},{south:.0} to \
             {east:.0},{north:.0}",
            pose.x,
            pose.y
        );
    }
    Ok(())
}

/// As the robot's camera sees from `pose`, in twice its size.
fn street_view(caster: &RayCaster, pose: Pose2) -> View {
    let robot = RobotDescription::sentry();
    let ground = ground_height(caster, pose.point());
    let optics = robot.camera_intrinsics;
    View {
        pose: pose.to_pose3(ground) * robot.camera,
        size: ImageSize::new(2 * optics.width, 2 * optics.height),
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
    // The focal length is the width of the picture: at any distance the view is as wide as that
    // distance. 15 % are margin.
    let distance = 1.15 * reach;
    let middle = Vector3::new((x0 + x1) / 2.0, (y0 + y1) / 2.0, 0.0);
    // The camera looks along its x axis: pitch turns it down, and a yaw of 90° to the north.
    let rotation = UnitQuaternion::from_euler_angles(0.0, pitch, std::f64::consts::FRAC_PI_2);
    let eye = middle - rotation * Vector3::x() * distance;
    View {
        pose: Pose3::from_parts(eye.into(), rotation),
        size: ImageSize::new(1600, 1100),
        focal_length: 1600.0,
        range: 5000.0,
        shadows: true,
        exposure: 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_colour_of_its_own() {
        let colors: std::collections::BTreeSet<_> = (0..200_000).map(color_of_number).collect();
        assert_eq!(colors.len(), 200_000);
        assert_eq!(color_of_number(0), [0; 3]);
    }

    #[test]
    fn depths_are_millimetres_within_sixteen_bits() {
        assert_eq!(
            [0.0, 1.2345, 65.0, 70.0, f32::INFINITY].map(millimetres),
            [0, 1235, 65_000, 65_535, 0]
        );
    }
}
