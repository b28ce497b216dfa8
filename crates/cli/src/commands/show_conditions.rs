//! The robot's own images in a world under conditions, one or side by side.

use std::sync::Arc;

use anyhow::Context;
use openbench_bench::TrafficPlan;
use openbench_bench::suite::Conditions;
use openbench_bench::worlds::surroundings;
use openbench_core::{Image, Pose2, RobotDescription, Velocity};
use openbench_osm::OsmMap;
use openbench_scene::World;
use openbench_sim::{Simulator, Stage};

use crate::args::ShowArgs;

/// The conditions whose levels make images of one world differ.
const SEEN: [&str; 4] = ["camera", "light", "weather", "robot"];
/// Images in a row of a sheet.
const COLUMNS: usize = 2;

/// The robot's image at `pose` under the conditions of `args`, or a sheet of them.
pub(super) fn image(
    args: &ShowArgs,
    world: &World,
    stage: &Stage,
    pose: Pose2,
) -> anyhow::Result<Image> {
    let mut conditions = Conditions::default();
    let words = args.conditions.iter();
    let set = conditions.set_all(words.map(|(key, value)| (&**key, &**value)));
    set.context("--condition")?;
    let Some(key) = &args.levels else {
        let image = taken(args, world, stage, pose, &conditions)?;
        return Ok(Arc::unwrap_or_clone(image));
    };
    anyhow::ensure!(
        SEEN.contains(&key.as_str()),
        "--levels {key}: that does not show in an image; there are {}",
        SEEN.join(", ")
    );
    let levels = Conditions::levels(key).with_context(|| format!("--levels {key}"))?;
    let mut images = Vec::new();
    for level in levels {
        let mut conditions = conditions;
        conditions.set(key, level)?;
        images.push(taken(args, world, stage, pose, &conditions)?);
    }
    sheet(&images).context("the condition has no levels")
}

/// The image of a robot at `pose`. It has stood there while people and cars moved.
fn taken(
    args: &ShowArgs,
    world: &World,
    stage: &Stage,
    pose: Pose2,
    conditions: &Conditions,
) -> anyhow::Result<Arc<Image>> {
    let plan = TrafficPlan {
        pedestrians: args.pedestrians.into(),
        cars: args.cars.into(),
    };
    let mut robot = RobotDescription::sentry();
    robot.camera_intrinsics.distortion = conditions.camera.distortion();
    let defects = conditions.robot.draw(args.seed);
    let mut simulator = Simulator::with_defects(stage.clone(), robot, &defects, pose, args.seed)
        .in_surroundings(&surroundings(world, conditions, args.seed));
    if !plan.is_empty() {
        let map = OsmMap::new(&world.map, world.georeference);
        simulator = simulator.with_traffic_on(&map, plan, args.seed)?;
        while simulator.time().seconds() < f64::from(args.after) {
            simulator.step(Velocity::ZERO);
        }
    }
    let image = simulator.observation().camera.image();
    image.context("the camera took no image")
}

/// Images of one size, row by row; `None` without any.
fn sheet(images: &[Arc<Image>]) -> Option<Image> {
    let first = images.first()?;
    let (width, height) = (first.width as usize, first.height as usize);
    let columns = COLUMNS.min(images.len());
    let rows = images.len().div_ceil(columns);
    let mut rgb = vec![255; 3 * columns * width * rows * height];
    for (i, image) in images.iter().enumerate() {
        let (left, top) = (i % columns * width, i / columns * height);
        for (row, line) in image.rgb.chunks_exact(3 * width).enumerate() {
            let at = 3 * ((top + row) * columns * width + left);
            rgb[at..at + line.len()].copy_from_slice(line);
        }
    }
    Some(Image {
        stamp: first.stamp,
        width: (columns * width) as u32,
        height: (rows * height) as u32,
        rgb,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_has_its_images_row_by_row() {
        let image = |value| {
            Arc::new(Image {
                stamp: Default::default(),
                width: 2,
                height: 1,
                rgb: vec![value; 6],
            })
        };
        let sheet = sheet(&[image(1), image(2), image(3)]).unwrap();
        assert_eq!((sheet.width, sheet.height), (4, 2));
        let rows: Vec<u8> = sheet.rgb.iter().step_by(6).copied().collect();
        // White where there is none.
        assert_eq!(rows, [1, 2, 3, 255]);
    }
}
