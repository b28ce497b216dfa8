//! The built-in worlds: every door can be reached, results are deterministic, and sizes are
//! bounded.

use std::collections::{BTreeSet, VecDeque};
use std::time::Instant;

mod maps;
#[path = "../../skips.rs"]
mod skips;

use maps::{map_of, row_of_houses};
use openbench_core::{Georeference, MapPoint, Pose2};
use openbench_osm::{OsmData, OsmMap, Tags};
use openbench_scene::generate::{GenerateOptions, builtin, builtin_names, generate};
use openbench_scene::{RayCaster, Scene, SemanticClass, World};
use skips::shared_data;

fn world(name: &str, seed: u64) -> World {
    builtin(name, seed).unwrap().unwrap()
}

/// Where a robot of 0.32 m by 0.31 m can drive: a grid of 0.1 m over the solid triangles at its
/// height, flooded from the start. Deliberately not the crate's own free space.
struct Flood {
    reached: BTreeSet<(i32, i32)>,
}

const CELL: f64 = 0.1;
const RADIUS: f64 = 0.23;

impl Flood {
    fn of(scene: &Scene, start: MapPoint) -> Self {
        let mut blocked = BTreeSet::new();
        let (mut low, mut high) = ((i32::MAX, i32::MAX), (i32::MIN, i32::MIN));
        for triangle in &scene.solid.triangles {
            let corners = triangle.map(|i| scene.solid.positions[i as usize].map(f64::from));
            let z = |f: fn(f64, f64) -> f64| f(f(corners[0][2], corners[1][2]), corners[2][2]);
            if z(f64::max) < 0.03 || z(f64::min) > 0.4 {
                continue;
            }
            for point in samples(corners) {
                let (x, y) = cell(point);
                (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
                let reach = (RADIUS / CELL).ceil() as i32;
                for (dx, dy) in
                    (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)))
                {
                    let middle = (f64::from(x + dx) + 0.5, f64::from(y + dy) + 0.5);
                    if MapPoint::new(middle.0 * CELL, middle.1 * CELL).distance(point) <= RADIUS {
                        blocked.insert((x + dx, y + dy));
                    }
                }
            }
        }
        let mut queue = VecDeque::from([cell(start)]);
        let mut reached = BTreeSet::new();
        while let Some((x, y)) = queue.pop_front() {
            let inside = x > low.0 - 5 && x < high.0 + 5 && y > low.1 - 5 && y < high.1 + 5;
            if inside && !blocked.contains(&(x, y)) && reached.insert((x, y)) {
                queue.extend([(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]);
            }
        }
        Self { reached }
    }

    fn has(&self, point: MapPoint) -> bool {
        self.reached.contains(&cell(point))
    }
}

fn cell(p: MapPoint) -> (i32, i32) {
    ((p.x / CELL).floor() as i32, (p.y / CELL).floor() as i32)
}

/// Points along the edges of a triangle: vertical surfaces have an edge on the ground.
fn samples([a, b, c]: [[f64; 3]; 3]) -> Vec<MapPoint> {
    let mut points = Vec::new();
    for (p, q) in [(a, b), (b, c), (c, a)] {
        let (p, q) = (MapPoint::new(p[0], p[1]), MapPoint::new(q[0], q[1]));
        let steps = (p.distance(q) / 0.08).ceil() as usize;
        points.extend((0..=steps).map(|i| {
            p.offset(
                p.bearing_to(q),
                p.distance(q) * i as f64 / steps.max(1) as f64,
            )
        }));
    }
    points
}

fn assert_doors_reached(name: &str, seed: u64) {
    let world = world(name, seed);
    let flood = Flood::of(&world.scene, world.start.point());
    assert!(
        flood.reached.len() > 10_000,
        "{name} {seed}: start is shut in"
    );
    for door in &world.scene.doors {
        let reached =
            (5..=15).any(|i| flood.has(door.point().offset(door.facing, f64::from(i) * 0.1)));
        assert!(
            reached,
            "{name} {seed}: {} at {}",
            door.address,
            door.point()
        );
        assert!(
            flood.has(door.point().offset(door.facing, 2.0)),
            "{name} {seed}: {} has no room",
            door.address
        );
    }
}

#[test]
fn every_door_of_small_is_reached_whatever_the_seed() {
    (0..6).for_each(|seed| assert_doors_reached("small", seed));
}

#[test]
fn every_door_of_medium_is_reached_whatever_the_seed() {
    (0..4).for_each(|seed| assert_doors_reached("medium", seed));
}

#[test]
fn every_door_of_large_is_reached_whatever_the_seed() {
    (0..3).for_each(|seed| assert_doors_reached("large", seed));
}

#[test]
fn the_start_has_room() {
    for name in builtin_names() {
        let world = world(name, 7);
        assert_eq!(world.start, Pose2::default());
        let near = world.scene.solid.triangles.iter().filter(|t| {
            let corners = t.map(|i| world.scene.solid.positions[i as usize].map(f64::from));
            corners.iter().any(|c| c[2] > 0.03)
                && samples(corners)
                    .iter()
                    .any(|p| p.distance(MapPoint::default()) < 1.5)
        });
        assert_eq!(near.count(), 0, "{name}");
    }
}

#[test]
fn a_seed_gives_one_world_and_another_seed_another() {
    for name in builtin_names() {
        assert_eq!(world(name, 1).scene, world(name, 1).scene, "{name}");
        assert_ne!(world(name, 1).scene, world(name, 2).scene, "{name}");
        let doors = |seed| {
            world(name, seed)
                .scene
                .doors
                .iter()
                .map(|d| d.address.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(doors(1), doors(2), "{name}: the map decides on the doors");
    }
}

#[test]
fn built_in_worlds_stay_within_their_budgets() {
    let sizes = [
        ("small", 3, 15_000),
        ("medium", 14, 60_000),
        ("large", 17, 100_000),
    ];
    for (name, buildings, triangles) in sizes {
        let world = world(name, 3);
        let map = OsmMap::new(&world.map, world.georeference);
        assert!(map.buildings.len() >= buildings, "{name}");
        assert!(map.buildings.iter().all(|b| b.name.is_some()), "{name}");
        assert!(
            world.scene.triangles.len() < triangles,
            "{name}: {} triangles",
            world.scene.triangles.len()
        );
        assert!(
            world
                .scene
                .textures
                .iter()
                .all(|t| t.width <= 512 && t.height <= 512),
            "{name}"
        );
        assert!(world.warnings.is_empty(), "{name}: {:?}", world.warnings);
    }
}

#[test]
fn the_public_map_keeps_buildings_and_roads_but_no_door() {
    for name in builtin_names() {
        let world = world(name, 3);
        let map = OsmMap::new(&world.map, world.georeference);
        assert!(!map.roads.is_empty(), "{name}");
        assert!(map.entrances.is_empty(), "{name}");
        let tells = |tags: &Tags| ["entrance", "addr:unit", "ref"].iter().any(|k| tags.has(k));
        assert!(!world.map.nodes.values().any(|n| tells(&n.tags)), "{name}");
    }
}

#[test]
fn doors_of_one_building_are_apart_and_face_away_from_it() {
    for name in builtin_names() {
        let world = world(name, 5);
        let map = OsmMap::new(&world.map, world.georeference);
        let doors = &world.scene.doors;
        assert_eq!(
            doors
                .iter()
                .map(|d| &d.address)
                .collect::<BTreeSet<_>>()
                .len(),
            doors.len()
        );
        for (i, door) in doors.iter().enumerate() {
            let same = |d: &&openbench_scene::Door| d.address.building == door.address.building;
            for other in doors[i + 1..].iter().filter(same) {
                assert!(
                    other.point().distance(door.point()) > 2.5,
                    "{name}: {} and {}",
                    door.address,
                    other.address
                );
            }
            let building = map
                .buildings
                .iter()
                .find(|b| b.name.as_deref() == Some(&door.address.building))
                .unwrap();
            assert!(
                !building
                    .polygon
                    .contains(door.point().offset(door.facing, 0.5)),
                "{name}: {}",
                door.address
            );
            assert!(
                building
                    .polygon
                    .contains(door.point().offset(door.facing, -0.5)),
                "{name}: {}",
                door.address
            );
            assert!((1.4..=1.9).contains(&door.plate[2]), "{name}");
            assert!(door.text.starts_with("UNIT "), "{name}");
        }
    }
}

#[test]
fn roads_are_connected() {
    for name in builtin_names() {
        let world = world(name, 1);
        let map = OsmMap::new(&world.map, world.georeference);
        let mut reached = BTreeSet::from([map.roads[0].nodes[0]]);
        loop {
            let before = reached.len();
            for road in map
                .roads
                .iter()
                .filter(|r| r.nodes.iter().any(|n| reached.contains(n)))
                .collect::<Vec<_>>()
            {
                reached.extend(road.nodes.iter().copied());
            }
            if reached.len() == before {
                break;
            }
        }
        let lost = map
            .roads
            .iter()
            .filter(|r| !reached.contains(&r.nodes[0]))
            .map(|r| r.way)
            .collect::<Vec<_>>();
        assert_eq!(lost, Vec::<i64>::new(), "{name}");
    }
}

#[test]
fn all_classes_are_present_and_corners_are_finite() {
    let scene = world("medium", 1).scene;
    let classes: BTreeSet<SemanticClass> = scene.materials.iter().map(|m| m.class).collect();
    let used: BTreeSet<SemanticClass> = scene
        .triangles
        .iter()
        .map(|t| scene.materials[t.material.0 as usize].class)
        .collect();
    assert!(classes.is_superset(&used));
    for class in [
        SemanticClass::Grass,
        SemanticClass::Hedge,
        SemanticClass::Road,
        SemanticClass::Pavement,
        SemanticClass::Building,
        SemanticClass::Door,
        SemanticClass::Plate,
        SemanticClass::Wall,
        SemanticClass::Vegetation,
        SemanticClass::Vehicle,
        SemanticClass::Furniture,
    ] {
        assert!(used.contains(&class), "{class:?}");
    }
    assert!(
        scene
            .vertices
            .iter()
            .all(|v| v.position.iter().all(|c| c.is_finite()))
    );
}

#[test]
fn a_house_without_name_or_entrance_gets_both() {
    let house: &[(f64, f64)] = &[(4.0, 5.0), (14.0, 5.0), (14.0, 13.0), (4.0, 13.0)];
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (40.0, 0.0)];
    let (data, georeference) = map_of(&[
        (house, &[("building", "yes")]),
        (road, &[("highway", "residential")]),
    ]);
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    let door = &world.scene.doors[0];
    assert_eq!(door.address.building, "building1");
    assert!(
        (door.facing + std::f64::consts::FRAC_PI_2).abs() < 1e-3,
        "towards the street"
    );
    assert_eq!(world.map.ways[&1].tags.get("name"), Some("building1"));
}

#[test]
fn no_door_is_in_a_wall_of_two_buildings() {
    // Both drawn with the same front to the street.
    let house: &[(f64, f64)] = &[(4.0, 5.0), (24.0, 5.0), (24.0, 13.0), (4.0, 13.0)];
    let wing: &[(f64, f64)] = &[(4.0, 5.0), (15.0, 5.0), (15.0, 30.0), (4.0, 30.0)];
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (40.0, 0.0)];
    let (data, georeference) = map_of(&[
        (house, &[("building", "yes")]),
        (wing, &[("building", "yes")]),
        (road, &[("highway", "residential")]),
    ]);
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    assert_eq!(world.scene.doors.len(), 2);
    for door in &world.scene.doors {
        let at = door.point();
        assert!(at.x > 15.0 || at.y > 13.0, "{} at {at:?}", door.address);
    }
}

fn names_of_doors(world: &World) -> BTreeSet<&str> {
    world
        .scene
        .doors
        .iter()
        .map(|d| d.address.building.as_str())
        .collect()
}

#[test]
fn houses_in_a_named_street_get_numbers_that_the_public_map_has() {
    let street = [("highway", "residential"), ("name", "Rua Alta")];
    for tags in [
        &[("building", "yes")][..],
        &[("building", "yes"), ("addr:housenumber", "7")],
    ] {
        let (data, georeference) = row_of_houses(6, &street, tags);
        let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
        assert_eq!(names_of_doors(&world).len(), 6);
        let map = OsmMap::new(&world.map, georeference);
        for door in &world.scene.doors {
            assert!(
                door.address.building.starts_with("Rua Alta "),
                "{}",
                door.address
            );
            let found = openbench_osm::locate(&map, &door.address);
            assert!(
                matches!(found, openbench_osm::Location::Building(_)),
                "{}: {found:?}",
                door.address
            );
        }
        assert!(tags.len() == 1 || names_of_doors(&world).contains("Rua Alta 7"));
    }
}

#[test]
fn houses_of_one_name_get_addresses_of_their_own() {
    let street = [("highway", "residential"), ("name", "Rua Alta")];
    let (data, georeference) = row_of_houses(3, &street, &[("building", "yes"), ("name", "Casa")]);
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    assert_eq!(names_of_doors(&world).len(), 3);
}

#[test]
fn the_start_is_where_most_doors_are_reached() {
    // A walled yard with one house and a path, beside a street with three houses; the yard is
    // nearer to the middle.
    let (mut data, georeference) =
        row_of_houses(3, &[("highway", "residential")], &[("building", "yes")]);
    let wall: &[(f64, f64)] = &[
        (8.0, 20.0),
        (40.0, 20.0),
        (40.0, 50.0),
        (8.0, 50.0),
        (8.0, 20.0),
    ];
    let hut: &[(f64, f64)] = &[(15.0, 36.0), (25.0, 36.0), (25.0, 44.0), (15.0, 44.0)];
    let path: &[(f64, f64)] = &[(12.0, 24.0), (36.0, 24.0)];
    let (yard, _) = map_of(&[
        (wall, &[("barrier", "wall")]),
        (hut, &[("building", "yes")]),
        (path, &[("highway", "path")]),
    ]);
    data.nodes
        .extend(yard.nodes.into_iter().map(|(id, mut node)| {
            node.id += 1_000;
            (id + 1_000, node)
        }));
    data.ways.extend(yard.ways.into_iter().map(|(id, mut way)| {
        way.id += 1_000;
        way.nodes.iter_mut().for_each(|n| *n += 1_000);
        (id + 1_000, way)
    }));
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    assert!(world.start.y < 5.0, "{:?}", world.start);
    assert_eq!(world.scene.doors.len(), 4);
}

#[test]
#[allow(clippy::print_stderr)]
fn maps_of_real_places_become_worlds() {
    let Some(folder) = shared_data("osm") else {
        return;
    };
    let entries = std::fs::read_dir(folder).unwrap();
    let mut worlds = 0;
    for path in entries.filter_map(|e| e.ok()).map(|e| e.path()) {
        let name = path
            .file_name()
            .map(|n| n.to_string_lossy().into_owned())
            .unwrap_or_default();
        if !name.ends_with(".osm") && !name.starts_with("monaco") {
            continue;
        }
        let data = OsmData::read(&path).unwrap();
        let georeference = openbench_osm::default_georeference(&data).unwrap();
        let began = Instant::now();
        let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
        let (triangles, doors) = (world.scene.triangles.len(), world.scene.doors.len());
        eprintln!(
            "{name}: {triangles} triangles, {doors} doors, {:?}, {:?}",
            began.elapsed(),
            world.warnings
        );
        assert!(doors > 0 && triangles > 1_000, "{name}");
        worlds += 1;
    }
    assert!(worlds > 0);
}

/// Ranges from the same places of a world, relative to its start.
fn ranges_about_the_start(world: &World) -> Vec<Option<f32>> {
    let caster = RayCaster::new(std::sync::Arc::new(world.scene.clone()));
    let start = world.start.point();
    let places = (0..40).map(|i| start.offset(f64::from(i) * 0.7, f64::from(i)));
    let cast = |from: MapPoint| {
        (0..36).map(move |k| {
            let (sin, cos) = libm::sincos(f64::from(k) * 0.1745);
            (from, [cos as f32, sin as f32, 0.05])
        })
    };
    let rays = places.flat_map(cast);
    rays.map(|(from, direction)| {
        caster
            .cast([from.x as f32, from.y as f32, 0.3], direction, 50.0)
            .map(|hit| hit.distance)
    })
    .collect()
}

#[test]
fn a_false_origin_anywhere_gives_the_same_world() {
    let (data, _) = maps::row_of_houses(6, &[("highway", "residential")], &[("building", "yes")]);
    let plane = openbench_osm::default_georeference(&data).unwrap();
    let Georeference::Utm {
        zone,
        north,
        offset_x,
        offset_y,
    } = plane
    else {
        panic!("{plane}")
    };
    let at = |metres: f64| {
        let (offset_x, offset_y) = (offset_x + metres, offset_y - metres);
        let moved = Georeference::Utm {
            zone,
            north,
            offset_x,
            offset_y,
        };
        generate(&data, moved, 4, &GenerateOptions::default()).unwrap()
    };
    let here = at(0.0);
    let expected = ranges_about_the_start(&here);
    assert!(
        expected.iter().flatten().count() > 100,
        "the rays must meet something"
    );
    for metres in [5e3, 5e5, 5e6] {
        let there = at(metres);
        assert!(
            there.start.point().distance(MapPoint::default()) < 600.0,
            "{:?}",
            there.start
        );
        assert!(
            there
                .warnings
                .iter()
                .any(|w| w.contains("far from the start")),
            "{:?}",
            there.warnings
        );
        assert_eq!(there.scene.triangles.len(), here.scene.triangles.len());
        for (a, b) in expected.iter().zip(ranges_about_the_start(&there)) {
            let apart = a.zip(b).map(|(a, b)| (a - b).abs());
            assert!(
                apart.map_or(*a == b, |apart| apart < 1e-4),
                "{a:?} against {b:?}"
            );
        }
    }
}

/// The same world, so many metres farther east.
fn moved_east(world: &World, metres: f64) -> World {
    let mut moved = world.clone();
    moved.start.x += metres;
    for vertex in &mut moved.scene.vertices {
        vertex.position[0] = (f64::from(vertex.position[0]) + metres) as f32;
    }
    moved
}

#[test]
fn ranges_are_exact_to_millimetres_kilometres_from_the_origin() {
    let (data, _) = maps::row_of_houses(6, &[("highway", "residential")], &[("building", "yes")]);
    let plane = openbench_osm::default_georeference(&data).unwrap();
    let here = generate(&data, plane, 4, &GenerateOptions::default()).unwrap();
    let expected = ranges_about_the_start(&here);
    // The value in ARCHITECTURE.md: distances between neighbours in single precision.
    for (metres, step) in [(2e3, 0.000_13), (1e4, 0.001), (2e4, 0.002)] {
        let found = ranges_about_the_start(&moved_east(&here, metres));
        let both = expected
            .iter()
            .zip(&found)
            .filter_map(|(a, b)| Some(f64::from((*a)? - (*b)?)));
        // A ray past an edge may hit a surface behind it.
        let near: Vec<f64> = both.filter(|apart| apart.abs() < 0.1).collect();
        let seen = expected.iter().flatten().count();
        assert!(near.len() * 200 > seen * 199, "{} of {seen}", near.len());
        let rms =
            libm::sqrt(near.iter().map(|apart| apart * apart).sum::<f64>() / near.len() as f64);
        assert!(rms < step, "{rms} m at {metres}");
    }
}
