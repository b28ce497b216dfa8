//! Where the pictures are taken from.

use nalgebra::{Point3, Vector3};
use openbench_core::{CameraIntrinsics, Pose3, RobotDescription};
use openbench_scene::{Door, World};
use openbench_sim::{ImageSize, View};

/// Distances from doors, metres.
const AWAY: [f64; 4] = [2.0, 5.0, 9.0, 16.0];
/// By how much the view turns away from the door, radians.
const ASIDE: [f64; 5] = [0.0, 0.5, -0.4, 1.1, -1.3];
/// Heights of the camera above the ground: the robot's, a person's, and from above, metres.
const HEIGHTS: [f64; 3] = [0.26, 1.6, 7.0];

/// `count` views, from the start and from before doors all over the world, with the robot's camera.
pub fn views(world: &World, count: usize) -> Vec<View> {
    let robot = RobotDescription::sentry();
    let optics = robot.camera_intrinsics;
    let start = world.start;
    let at_start = Point3::new(start.x, start.y, HEIGHTS[0]);
    let ahead = Vector3::new(libm::cos(start.yaw), libm::sin(start.yaw), 0.0);
    let doors = &world.scene.doors;
    let chosen =
        (1..count).filter_map(|i| doors.get(i * doors.len() / count).map(|door| (i, door)));
    let before = chosen.map(|(i, door)| before_door(door, i));
    std::iter::once((at_start, ahead))
        .chain(before)
        .map(|(eye, look)| view(&optics, eye, look))
        .collect()
}

/// Eye and direction of the `i`-th view.
fn before_door(door: &Door, i: usize) -> (Point3<f64>, Vector3<f64>) {
    let (away, aside, height) = (
        AWAY[i % AWAY.len()],
        ASIDE[i % ASIDE.len()],
        HEIGHTS[i % HEIGHTS.len()],
    );
    let out = Vector3::new(libm::cos(door.facing), libm::sin(door.facing), 0.0);
    let eye = Point3::new(door.plate[0], door.plate[1], height) + out * away;
    let yaw = door.facing + std::f64::consts::PI + aside;
    let down = if height > 2.0 { -0.35 } else { 0.0 };
    (eye, Vector3::new(libm::cos(yaw), libm::sin(yaw), down))
}

fn view(optics: &CameraIntrinsics, eye: Point3<f64>, look: Vector3<f64>) -> View {
    // A place that single precision holds: elsewhere the renderer's eye is up to some micrometres off, which alone
    // makes another pixel or two of a frame differ.
    let eye = eye.map(|c| f64::from(c as f32));
    let forward = look.normalize();
    let left = Vector3::z().cross(&forward).normalize();
    let axes = nalgebra::Matrix3::from_columns(&[forward, left, forward.cross(&left)]);
    let rotation = nalgebra::UnitQuaternion::from_matrix(&axes);
    View {
        pose: Pose3::from_parts(eye.coords.into(), rotation),
        size: ImageSize::new(optics.width, optics.height),
        focal_length: optics.focal_length(),
        range: 100.0,
        shadows: false,
        exposure: 1.0,
    }
}
