//! Worlds whose streets differ: what changes, and what does not.

use std::sync::Arc;

use openbench_core::MapPoint;
use openbench_geometry::{Bounds, Segment, segments, signed_area, turn};
use openbench_osm::OsmMap;
use openbench_scene::generate::{Alterations, SceneryOptions, builtin, builtin_with};
use openbench_scene::scenery::Scenery;
use openbench_scene::{FreeSpace, RayCaster, SemanticClass, World};

/// All there is of everything.
const MOST: Scenery = Scenery {
    ground: 1.0,
    shapes: 1.0,
    clutter: 1.0,
    relief: 1.0,
};
/// Radius of the robot, with a little room, metres.
const ROBOT_M: f64 = 0.25;

fn world(name: &str, amounts: Scenery, seed: u64) -> World {
    let conditions = Alterations {
        scenery: SceneryOptions { amounts, seed },
        ..Alterations::default()
    };
    builtin_with(name, 1, conditions).unwrap().unwrap()
}

/// For each door whether a robot reaches it.
fn reached(world: &World) -> Vec<bool> {
    let caster = RayCaster::new(Arc::new(world.scene.clone()));
    let space = FreeSpace::new(&caster, world.start.point(), ROBOT_M);
    let doors = world.scene.doors.iter();
    doors
        .map(|door| space.approach_point(door).is_some())
        .collect()
}

#[test]
fn plain_streets_are_those_of_before() {
    let usual = builtin("small", 1).unwrap().unwrap();
    // A seed alone changes nothing.
    let same = world("small", Scenery::PLAIN, 7);
    assert_eq!(usual.scene, same.scene);
    assert!(same.scenery.is_none());
    assert!(usual.scene.pits.is_empty());
}

#[test]
fn a_seed_draws_the_same_streets_and_another_seed_others() {
    let of = |seed| world("small", Scenery::VARIED, seed);
    assert_eq!(of(3).scene, of(3).scene);
    assert_ne!(of(3).scene, of(4).scene);
    assert_ne!(of(3).scenery, of(4).scenery);
}

#[test]
fn houses_and_doors_stay_where_they_are() {
    let usual = builtin("medium", 1).unwrap().unwrap();
    let varied = world("medium", MOST, 10_000);
    assert_eq!(usual.map.to_xml(), varied.map.to_xml());
    assert_eq!(usual.scene.doors, varied.scene.doors);
    let drawn = varied.scenery.unwrap();
    assert!(drawn.ground.len() >= 5, "{drawn:?}");
    assert!(drawn.clutter.len() >= 6, "{drawn:?}");
    assert!(
        drawn.beside_doors > 3 && drawn.steps + drawn.ramps > 3,
        "{drawn:?}"
    );
    assert!(drawn.wells > 3, "{drawn:?}");
    assert!(drawn.trees > 0 && drawn.cars > 0, "{drawn:?}");
    assert_eq!(drawn.wells, varied.scene.pits.len());
}

#[test]
fn every_door_that_is_reached_without_scenery_is_reached_with_it() {
    for name in ["small", "medium", "large"] {
        let usual = reached(&builtin(name, 1).unwrap().unwrap());
        for seed in 0..3 {
            let varied = reached(&world(name, MOST, seed));
            for (door, (before, with)) in usual.iter().zip(&varied).enumerate() {
                assert!(!before || *with, "{name}, seed {seed}, door {door}");
            }
        }
    }
}

#[test]
fn nothing_stands_in_buildings_or_on_carriageways() {
    let clutter = Scenery {
        clutter: 1.0,
        ..Scenery::PLAIN
    };
    let world = world("large", clutter, 5);
    let map = OsmMap::new(&world.map, world.georeference);
    let drawn = world.scenery.unwrap();
    let things: Vec<&str> = drawn.clutter.keys().map(String::as_str).collect();
    let scene = &world.scene;
    let mut looked_at = 0;
    for (triangle, number) in scene.triangles.iter().zip(&scene.object_numbers) {
        let object = scene.object(*number).unwrap();
        if !things.contains(&&*object.name) || object.class != SemanticClass::Furniture {
            continue;
        }
        looked_at += 1;
        for corner in triangle.corners {
            let [x, y, _] = scene.vertices[corner as usize].position;
            let p = MapPoint::new(f64::from(x), f64::from(y));
            let inside = map.buildings_within(p, 30.0).into_iter().any(|i| {
                let polygon = &map.buildings[i].polygon;
                polygon.contains(p) && polygon.sides().all(|s| s.distance_to_point(p) > 0.02)
            });
            assert!(!inside, "{} in a building at {p:?}", object.name);
            let on_road = map.roads.iter().any(|road| {
                let is_street = ["residential", "tertiary", "secondary", "service"]
                    .iter()
                    .any(|kind| road.tags.is("highway", kind));
                is_street && segments(&road.points).any(|s| s.distance_to_point(p) < 1.5)
            });
            assert!(!on_road, "{} on a carriageway at {p:?}", object.name);
        }
    }
    assert!(looked_at > 1_000, "{looked_at}");
}

#[test]
fn the_ground_is_missing_in_a_well_and_there_beside_it() {
    let relief = Scenery {
        relief: 1.0,
        ..Scenery::PLAIN
    };
    let world = world("large", relief, 2);
    let caster = RayCaster::new(Arc::new(world.scene.clone()));
    let below = |p: MapPoint, solid: bool| {
        let (origin, down) = ([p.x as f32, p.y as f32, 1.0], [0.0, 0.0, -1.0]);
        let tree = if solid {
            caster.solid()
        } else {
            caster.visible()
        };
        tree.cast(origin, down, 10.0).map(|hit| 1.0 - hit.distance)
    };
    assert!(!world.scene.pits.is_empty());
    let space = FreeSpace::new(&caster, world.start.point(), ROBOT_M);
    for pit in &world.scene.pits {
        let sum = |of: fn(&MapPoint) -> f64| pit.iter().map(of).sum::<f64>() / pit.len() as f64;
        let middle = MapPoint::new(sum(|p| p.x), sum(|p| p.y));
        for solid in [true, false] {
            let depth = below(middle, solid).unwrap();
            assert!(depth < -0.4, "{depth} at {middle:?}, solid: {solid}");
        }
        assert!(!space.is_reachable(middle));
        // Beyond its rim, away from the wall, there is ground again.
        let outside = beyond(pit, middle, 1.2);
        assert!(below(outside, true).unwrap() > -0.01, "{outside:?}");
    }
}

/// A point beyond the side of a pit that is away from the wall: outlines begin at the wall and run
/// clockwise. It is further from the middle by so many times the distance of that side.
fn beyond(pit: &[MapPoint], middle: MapPoint, times: f64) -> MapPoint {
    let (a, b) = (pit[1], pit[2]);
    let away = |from: f64, a: f64, b: f64| from + ((a + b) / 2.0 - from) * (1.0 + times);
    MapPoint::new(away(middle.x, a.x, b.x), away(middle.y, a.y, b.y))
}

#[test]
fn the_ground_lies_once_and_every_pit_is_open() {
    let relief = Scenery {
        relief: 1.0,
        ..Scenery::PLAIN
    };
    let mut pits = 0;
    for name in ["small", "medium", "large"] {
        for seed in 0..8 {
            let world = world(name, relief, seed);
            let scene = &world.scene;
            let grounds = ground_triangles(&world);
            pits += scene.pits.len();
            assert_eq!(world.scenery.as_ref().unwrap().wells, scene.pits.len());
            for pit in &scene.pits {
                let middle = Segment::new(pit[0], pit[2]).middle();
                let covers = |[a, b, c]: &[MapPoint; 3]| {
                    let sides = [[a, b], [b, c], [c, a]];
                    sides.iter().all(|[p, q]| turn(**p, **q, middle) > 0.0)
                };
                assert!(!grounds.iter().any(covers), "{name}, {seed}: {middle:?}");
            }
            let area: f64 = grounds.iter().map(|[a, b, c]| turn(*a, *b, *c) / 2.0).sum();
            let missing: f64 = scene.pits.iter().map(|pit| signed_area(pit).abs()).sum();
            let bounds = grounds.iter().flatten().map(|p| Bounds::of_point(*p));
            let bounds = bounds.reduce(Bounds::union).unwrap();
            let whole = signed_area(&bounds.corners());
            // Corners are rounded to 32 bits.
            assert!((whole - missing - area).abs() < 0.5, "{name}, {seed}");
        }
    }
    assert!(pits > 40, "{pits}");
}

/// The visible ground around pits.
fn ground_triangles(world: &World) -> Vec<[MapPoint; 3]> {
    let scene = &world.scene;
    let numbered = scene.triangles.iter().zip(&scene.object_numbers);
    let of_ground = numbered.filter(|(_, number)| {
        let object = scene.object(**number).unwrap();
        object.name == "ground"
    });
    let corner = |i: u32| {
        let [x, y, _] = scene.vertices[i as usize].position;
        MapPoint::new(f64::from(x), f64::from(y))
    };
    of_ground
        .map(|(triangle, _)| triangle.corners.map(corner))
        .collect()
}
