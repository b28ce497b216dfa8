//! The published worlds, where they are: `../shared/data` beside the workspace.

// Tests report when they are skipped for lack of data.
#![allow(clippy::print_stderr)]

#[path = "../../skips.rs"]
mod skips;

use std::time::Instant;

use nalgebra::{Point3, Vector3};
use openbench_core::MapPoint;
use openbench_scene::{ImportRequest, Scene, Triangle, World, import_world};
use skips::shared_data;

/// The published world `name`; `None`, with a message, if the data is absent.
fn published(name: &str) -> Option<World> {
    let folder = shared_data("openbench")?.join(name);
    let request = ImportRequest {
        world: folder.join(format!("{name}_osm.world")),
        map: folder.join(format!("{name}.osm")),
        models: vec![shared_data("gazebo_models")?],
        georeference: None,
        start: None,
    };
    Some(import_world(&request).unwrap())
}

/// All points in the truth files of a world.
fn truths(name: &str) -> Vec<MapPoint> {
    let folder = shared_data("openbench").unwrap().join(name);
    let mut points = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        if entry.file_name().to_string_lossy().contains("_gt") {
            let text = std::fs::read_to_string(entry.path()).unwrap();
            let numbers: Vec<f64> = text
                .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
                .filter_map(|w| w.parse().ok())
                .collect();
            points.extend(numbers.chunks_exact(2).map(|c| MapPoint::new(c[0], c[1])));
        }
    }
    points
}

/// Lengths of `direction` to the nearest of the triangles.
fn cast(origin: Point3<f64>, direction: Vector3<f64>, triangles: &[[[f32; 3]; 3]]) -> Option<f64> {
    let hit = |t: &[[f32; 3]; 3]| {
        let [a, b, c] = t.map(|p| Point3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])));
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(&e2);
        let det = e1.dot(&p);
        if det.abs() < 1e-12 {
            return None;
        }
        let s = origin - a;
        let u = s.dot(&p) / det;
        let q = s.cross(&e1);
        let v = direction.dot(&q) / det;
        let distance = e2.dot(&q) / det;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
    };
    triangles.iter().filter_map(hit).min_by(f64::total_cmp)
}

/// Doors whose plate is visible from fewer than three of seven places 1.5 m in front of it, up to
/// 45 degrees aside: porches have posts, doors have niches.
fn hidden_plates(scene: &Scene) -> Vec<String> {
    let corners = |t: &Triangle| t.corners.map(|i| scene.vertices[i as usize].position);
    let triangles: Vec<[[f32; 3]; 3]> = scene.triangles.iter().map(corners).collect();
    let mut hidden = Vec::new();
    for door in &scene.doors {
        let normal = Vector3::new(libm::cos(door.facing), libm::sin(door.facing), 0.0);
        let across = normal.cross(&Vector3::z());
        let target = Point3::from(door.plate) + normal * 0.1;
        let sees = |aside: &f64| {
            let eye = target + normal * 1.5 + across * *aside;
            let to_plate = target - eye;
            cast(eye, to_plate, &triangles).is_some_and(|share| (share - 1.0).abs() < 0.005)
        };
        let count = [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]
            .iter()
            .filter(|a| sees(a))
            .count();
        if count < 3 {
            hidden.push(format!(
                "{} at {:?}: seen from {count} of 7 places",
                door.address, door.plate
            ));
        }
    }
    hidden
}

fn check(name: &str, doors: usize) {
    let Some(world) = published(name) else { return };
    assert_eq!(world.scene.doors.len(), doors);
    let truths = truths(name);
    assert!(truths.len() >= 5);
    for truth in truths {
        let nearest = world
            .scene
            .doors
            .iter()
            .map(|d| d.point().distance(truth))
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.02, "no plate at {truth}: {nearest} m");
    }
    let hidden = hidden_plates(&world.scene);
    assert!(hidden.is_empty(), "{}", hidden.join("\n"));
}

#[test]
fn small_has_seven_doors_in_plain_sight() {
    check("small", 7);
}

#[test]
fn medium_has_thirty_two_doors_in_plain_sight() {
    check("medium", 32);
}

#[test]
fn medium_is_imported_in_two_seconds() {
    let start = Instant::now();
    let Some(world) = published("medium") else {
        return;
    };
    let seconds = start.elapsed().as_secs_f64();
    eprintln!(
        "medium: {seconds:.2} s, {} triangles, {} textures",
        world.scene.triangles.len(),
        world.scene.textures.len()
    );
    // Twice the goal, since other work may be running on the machine.
    assert!(seconds < 4.0, "{seconds}");
}

#[test]
fn doors_have_the_addresses_of_the_instructions() {
    let Some(world) = published("medium") else {
        return;
    };
    for (building, unit) in [
        ("building3", "unit1"),
        ("building11", "unit3"),
        ("building7", "unit2"),
        ("building6", "unit1"),
    ] {
        let count = world
            .scene
            .doors
            .iter()
            .filter(|d| d.address == openbench_core::Address::new(building, unit))
            .count();
        assert_eq!(count, 1, "{unit}, {building}");
    }
}
