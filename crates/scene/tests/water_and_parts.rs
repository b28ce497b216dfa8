//! Water and kerbs stop a robot, bridges and paths lead across them; buildings have the parts that
//! are mapped.

mod maps;

use std::sync::Arc;

use maps::{WayOf, map_of, rectangle, row_of_houses};
use openbench_core::{MapPoint, Pose2};
use openbench_osm::{Node, Tags, Way};
use openbench_scene::generate::{GenerateOptions, generate};
use openbench_scene::{FreeSpace, RayCaster, SemanticClass, World};

/// The footprint of the robot, metres.
const RADIUS: f64 = 0.23;

fn caster(world: &World) -> RayCaster {
    RayCaster::new(Arc::new(world.scene.clone()))
}

fn reach(world: &World) -> FreeSpace {
    FreeSpace::new(&caster(world), world.start.point(), RADIUS)
}

fn bare() -> GenerateOptions {
    GenerateOptions {
        planting: 0.0,
        parked_cars: 0.0,
        ..GenerateOptions::default()
    }
}

#[test]
fn the_sea_is_water_and_no_robot_starts_in_it() {
    let (mut data, georeference) =
        row_of_houses(2, &[("highway", "residential")], &[("building", "yes")]);
    // Land is on the left: the sea begins 10 m south of the street and has no other shore.
    let projection = openbench_osm::Projection::new(georeference);
    for (id, x) in [(901, -2_000.0), (902, 2_000.0)] {
        let position = projection.to_lonlat(MapPoint::new(x, -10.0));
        data.nodes.insert(
            id,
            Node {
                id,
                position,
                tags: Tags::new(),
            },
        );
    }
    let tags: Tags = [("natural", "coastline")].into_iter().collect();
    data.ways.insert(
        900,
        Way {
            id: 900,
            nodes: vec![901, 902],
            tags,
        },
    );
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    let at = |y: f64| {
        let caster = openbench_scene::RayCaster::new(std::sync::Arc::new(world.scene.clone()));
        let hit = caster
            .visible()
            .cast([5.0, y as f32, 30.0], [0.0, 0.0, -1.0], 100.0)
            .unwrap();
        world.scene.materials[world.scene.triangles[hit.triangle as usize].material.0 as usize]
            .clone()
    };
    assert!(
        at(-40.0).reflectivity < 10 && at(-40.0).color[2] > 0.4,
        "water in the south"
    );
    assert!(at(-7.0).reflectivity > 10, "land in the north");
    assert!(world.start.y > -10.0);
}

#[test]
fn a_large_building_is_flat_and_one_on_stilts_can_be_driven_under() {
    let hall: &[(f64, f64)] = &[(0.0, 5.0), (90.0, 5.0), (90.0, 65.0), (0.0, 65.0)];
    let bridge: &[(f64, f64)] = &[(100.0, 5.0), (110.0, 5.0), (110.0, 15.0), (100.0, 15.0)];
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (140.0, 0.0)];
    let (data, georeference) = map_of(&[
        (hall, &[("building", "retail"), ("building:levels", "2")]),
        (
            bridge,
            &[("building", "yes"), ("min_height", "4"), ("height", "10")],
        ),
        (road, &[("highway", "residential")]),
    ]);
    let options = GenerateOptions {
        planting: 0.0,
        ..GenerateOptions::default()
    };
    let world = generate(&data, georeference, 1, &options).unwrap();
    assert_eq!(world.scene.doors.len(), 1, "no door in the air");
    let scene = &world.scene;
    let is_building = |t: &&openbench_scene::Triangle| {
        scene.materials[t.material.0 as usize].class == SemanticClass::Building
    };
    let corners =
        |t: &openbench_scene::Triangle| t.corners.map(|i| scene.vertices[i as usize].position);
    let in_bridge = |p: [f32; 3]| (99.0..111.0).contains(&p[0]);
    let lowest = scene
        .triangles
        .iter()
        .filter(is_building)
        .flat_map(corners)
        .filter(|p| in_bridge(*p));
    assert!((lowest.map(|p| p[2]).fold(f32::MAX, f32::min) - 4.0).abs() < 1e-3);
    assert!(
        !scene
            .solid
            .positions
            .iter()
            .any(|p| in_bridge(*p) && p[2] > 0.5 && (5.0..15.0).contains(&p[1]))
    );
}

#[test]
fn a_river_stops_a_robot_and_a_bridge_leads_over_it() {
    // A street from west to east, a river across it from x = 40 to x = 60, a house on either side.
    let river = rectangle((40.0, -300.0), (60.0, 300.0));
    let (west, east) = (
        rectangle((0.0, 6.0), (10.0, 14.0)),
        rectangle((80.0, 6.0), (90.0, 14.0)),
    );
    let street: &[(f64, f64)] = &[(-20.0, 0.0), (48.0, 0.0), (110.0, 0.0)];
    let options = GenerateOptions {
        start: Some(Pose2::new(5.0, -4.0, 0.0)),
        ..bare()
    };
    let world = |roads: &[(&str, &str)]| {
        let (data, georeference) = map_of(&[
            (&west, &[("building", "yes")]),
            (&east, &[("building", "yes")]),
            (&river, &[("natural", "water")]),
            (street, roads),
        ]);
        generate(&data, georeference, 1, &options).unwrap()
    };
    let over = reach(&world(&[("highway", "residential"), ("bridge", "yes")]));
    let (home, far) = (MapPoint::new(5.0, -4.0), MapPoint::new(85.0, -4.0));
    assert!(
        over.distance(home, far).is_some_and(|d| d < 95.0),
        "{:?}",
        over.distance(home, far)
    );
    for wet in [
        MapPoint::new(50.0, 20.0),
        MapPoint::new(42.0, -30.0),
        MapPoint::new(50.0, 7.5),
    ] {
        assert!(!over.is_reachable(wet), "{wet}");
    }
    assert!(over.is_reachable(MapPoint::new(38.0, 20.0)), "the bank");
    // Without the bridge the other side cannot be reached, not even around the end of the world.
    let none = reach(&world(&[("highway", "residential"), ("tunnel", "yes")]));
    assert!(none.is_reachable(MapPoint::new(20.0, 0.0)), "this side");
    assert!(!none.is_reachable(far), "the other side");
}

#[test]
fn no_robot_gets_into_the_sea_but_a_pier_leads_out() {
    let (mut data, georeference) =
        row_of_houses(2, &[("highway", "residential")], &[("building", "yes")]);
    let projection = openbench_osm::Projection::new(georeference);
    let mut node = |id, x, y| {
        let position = projection.to_lonlat(MapPoint::new(x, y));
        data.nodes.insert(
            id,
            Node {
                id,
                position,
                tags: Tags::new(),
            },
        );
    };
    for (id, x, y) in [
        (901, -2_000.0, -10.0),
        (902, 2_000.0, -10.0),
        (903, 6.0, 0.0),
        (904, 6.0, -40.0),
    ] {
        node(id, x, y);
    }
    data.ways.insert(
        900,
        Way {
            id: 900,
            nodes: vec![901, 902],
            tags: Tags::from([("natural", "coastline")]),
        },
    );
    data.ways.insert(
        905,
        Way {
            id: 905,
            nodes: vec![903, 904],
            tags: Tags::from([("highway", "footway")]),
        },
    );
    let world = generate(&data, georeference, 1, &bare()).unwrap();
    let space = reach(&world);
    assert!(
        space.is_reachable(MapPoint::new(20.0, -8.0))
            && space.is_reachable(MapPoint::new(6.0, -35.0))
    );
    for wet in [
        MapPoint::new(20.0, -12.0),
        MapPoint::new(-15.0, -40.0),
        MapPoint::new(10.0, -30.0),
    ] {
        assert!(!space.is_reachable(wet), "{wet}");
    }
    // No ground under the sea that it would show through, and no gap between the two.
    let caster = caster(&world);
    let depth = |x: f32, y: f32| {
        let hit = caster
            .visible()
            .cast([x, y, 30.0], [0.0, 0.0, -1.0], 100.0)
            .unwrap();
        (
            30.0 - hit.distance,
            world.scene.materials[world.scene.triangles[hit.triangle as usize].material.0 as usize]
                .class,
        )
    };
    assert_eq!(depth(-30.3, -50.2), (-0.5, SemanticClass::Water));
    let below = caster
        .visible()
        .cast([-30.3, -50.2, -0.6], [0.0, 0.0, -1.0], 100.0);
    assert!(below.is_none(), "{below:?}");
    for i in 0..400 {
        depth(-40.0 + 0.217 * i as f32, -10.6 + 0.003 * i as f32);
    }
}

/// Height of the highest thing over a place, metres.
fn top(caster: &RayCaster, x: f32, y: f32) -> f32 {
    let hit = caster
        .visible()
        .cast([x, y, 200.0], [0.0, 0.0, -1.0], 300.0)
        .unwrap();
    200.0 - hit.distance
}

#[test]
fn parts_replace_the_outline_that_they_cover() {
    let outline = rectangle((0.0, 5.0), (30.0, 17.0));
    let low = rectangle((0.0, 5.0), (15.0, 17.0));
    let high = rectangle((15.0, 5.0), (30.0, 17.0));
    let spire = rectangle((20.0, 9.0), (24.0, 13.0));
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (60.0, 0.0)];
    let (data, georeference) = map_of(&[
        (&outline, &[("building", "yes"), ("height", "40")]),
        (road, &[("highway", "residential")]),
        (&low, &[("building:part", "yes"), ("height", "6")]),
        (&high, &[("building:part", "yes"), ("height", "15")]),
        (
            &spire,
            &[
                ("building:part", "yes"),
                ("min_height", "15"),
                ("height", "30"),
                ("roof:shape", "pyramidal"),
                ("roof:height", "8"),
            ],
        ),
    ]);
    let world = generate(&data, georeference, 1, &bare()).unwrap();
    let seen = caster(&world);
    assert!(
        (6.0..6.1).contains(&top(&seen, 5.0, 10.0)),
        "{}",
        top(&seen, 5.0, 10.0)
    );
    assert!(
        (15.0..15.1).contains(&top(&seen, 18.0, 15.0)),
        "{}",
        top(&seen, 18.0, 15.0)
    );
    assert!(
        (29.5..30.1).contains(&top(&seen, 22.0, 11.0)),
        "{}",
        top(&seen, 22.0, 11.0)
    );
    let door = &world.scene.doors[0];
    assert_eq!(world.scene.doors.len(), 1);
    let space = reach(&world);
    assert!(space.approach_point(door).is_some());
    assert!(
        !space.is_reachable(MapPoint::new(5.0, 11.0)),
        "the base is solid"
    );
}

#[test]
fn a_tower_rises_from_a_church_that_has_no_other_parts() {
    let church = rectangle((0.0, 5.0), (30.0, 17.0));
    let tower = rectangle((0.0, 8.0), (6.0, 14.0));
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (60.0, 0.0)];
    let (data, georeference) = map_of(&[
        (
            &church,
            &[
                ("building", "church"),
                ("height", "9"),
                ("roof:shape", "flat"),
            ],
        ),
        (road, &[("highway", "residential")]),
        (&tower, &[("building:part", "tower"), ("height", "25")]),
    ]);
    let world = generate(&data, georeference, 1, &bare()).unwrap();
    let seen = caster(&world);
    assert!(
        (24.9..25.1).contains(&top(&seen, 3.0, 9.0)),
        "{}",
        top(&seen, 3.0, 9.0)
    );
    assert!(
        (8.9..9.6).contains(&top(&seen, 28.0, 16.0)),
        "{}",
        top(&seen, 28.0, 16.0)
    );
}

/// A street with a raised kerb beside it for 80 m, and the ways in `more`.
fn beside_a_kerb(kerb: &[(&str, &str)], more: &[WayOf]) -> World {
    let line: &[(f64, f64)] = &[
        (-40.0, 8.0),
        (40.0, 8.0),
        (40.0, 30.0),
        (-40.0, 30.0),
        (-40.0, 8.0),
    ];
    let house: &[(f64, f64)] = &[(-5.0, 35.0), (5.0, 35.0), (5.0, 45.0), (-5.0, 45.0)];
    let road: &[(f64, f64)] = &[(-60.0, 0.0), (60.0, 0.0)];
    let barn: &[(f64, f64)] = &[(-5.0, -20.0), (5.0, -20.0), (5.0, -10.0), (-5.0, -10.0)];
    let mut parts = vec![
        (barn, &[("building", "barn")] as &[_]),
        (road, &[("highway", "residential")]),
        (house, &[("building", "house"), ("addr:housenumber", "1")]),
        (line, kerb),
    ];
    parts.extend_from_slice(more);
    let (data, georeference) = map_of(&parts);
    generate(&data, georeference, 1, &bare()).unwrap()
}

#[test]
fn a_raised_kerb_stops_a_robot_but_not_where_a_path_crosses_it() {
    let raised: &[(&str, &str)] = &[("barrier", "kerb"), ("kerb", "raised")];
    let closed = beside_a_kerb(raised, &[]);
    let solid = &closed.scene.solid;
    let of_kerbs = solid
        .triangles
        .iter()
        .zip(&solid.classes)
        .filter(|(_, class)| **class == SemanticClass::Kerb);
    let heights = of_kerbs.flat_map(|(t, _)| t.map(|i| solid.positions[i as usize][2]));
    assert!((heights.fold(0.0, f32::max) - 0.12).abs() < 1e-6);
    let inside = MapPoint::new(0.0, 20.0);
    assert!(
        !reach(&closed).is_reachable(inside),
        "nothing leads over the kerb"
    );
    let path: &[(f64, f64)] = &[(10.0, 0.0), (10.0, 20.0)];
    let open = beside_a_kerb(raised, &[(path, &[("highway", "footway")])]);
    assert!(reach(&open).is_reachable(inside), "the footway does");
}

#[test]
fn a_kerb_of_short_stretches_is_open_as_wide_as_the_path_is() {
    let points: Vec<(f64, f64)> = (0..=40).map(|i| (0.4 * f64::from(i), 5.0)).collect();
    let house: &[(f64, f64)] = &[(0.0, 35.0), (10.0, 35.0), (10.0, 45.0), (0.0, 45.0)];
    let (road, path): (&[_], &[_]) = (&[(-30.0, 0.0), (50.0, 0.0)], &[(8.2, 0.0), (8.2, 20.0)]);
    let (data, georeference) = map_of(&[
        (road, &[("highway", "residential")]),
        (path, &[("highway", "footway")]),
        (&points, &[("barrier", "kerb")]),
        (house, &[("building", "house")]),
    ]);
    let world = generate(&data, georeference, 1, &bare()).unwrap();
    let solid = &world.scene.solid;
    let of_kerbs = solid
        .triangles
        .iter()
        .zip(&solid.classes)
        .filter(|(_, class)| **class == SemanticClass::Kerb);
    let places: Vec<f32> = of_kerbs
        .flat_map(|(t, _)| t.map(|i| solid.positions[i as usize][0]))
        .collect();
    let nearest = places
        .iter()
        .map(|x| (x - 8.2).abs())
        .fold(f32::INFINITY, f32::min);
    assert!(
        (1.2..2.5).contains(&nearest),
        "stones {nearest} m beside the middle of the path"
    );
    assert!(places.iter().any(|x| *x < 1.0) && places.iter().any(|x| *x > 15.0));
}

#[test]
fn low_kerbs_are_no_barriers_and_fences_are_whatever_kerb_they_have() {
    let low: [&[(&str, &str)]; 3] = [
        &[("barrier", "kerb"), ("kerb", "lowered")],
        &[("barrier", "kerb"), ("height", "2 cm")],
        &[("barrier", "kerb"), ("kerb:height", "0")],
    ];
    for tags in low {
        let world = beside_a_kerb(tags, &[]);
        assert!(
            !world.scene.solid.classes.contains(&SemanticClass::Kerb),
            "{tags:?}"
        );
        assert!(
            reach(&world).is_reachable(MapPoint::new(0.0, 20.0)),
            "{tags:?}"
        );
    }
    let fence = beside_a_kerb(&[("barrier", "fence"), ("kerb", "lowered")], &[]);
    assert!(!reach(&fence).is_reachable(MapPoint::new(0.0, 20.0)));
}
