//! Broken maps: each gives a world or an error, in bounded memory, and everything that is left out
//! is counted.

mod maps;

use maps::{map_of, rectangle, row_of_houses};
use openbench_core::{Georeference, LonLat, MapPoint};
use openbench_osm::{Node, OsmData, Tags, Way};
use openbench_scene::World;
use openbench_scene::generate::{GenerateError, GenerateOptions, generate};

fn made(data: &OsmData, georeference: Georeference) -> World {
    generate(data, georeference, 1, &GenerateOptions::default()).unwrap()
}

#[test]
fn odd_outlines_do_not_stop_generation() {
    let bow_tie: &[(f64, f64)] = &[(0.0, 5.0), (10.0, 15.0), (10.0, 5.0), (0.0, 15.0)];
    let sliver: &[(f64, f64)] = &[(20.0, 5.0), (40.0, 5.0), (40.0, 5.05)];
    let tower: &[(f64, f64)] = &[(50.0, 5.0), (60.0, 5.0), (60.0, 15.0), (50.0, 15.0)];
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (70.0, 0.0), (70.0, 0.0)];
    let (data, georeference) = map_of(&[
        (bow_tie, &[("building", "yes")]),
        (sliver, &[("building", "yes")]),
        (
            tower,
            &[
                ("building", "yes"),
                ("height", "1e300"),
                ("building:levels", "-4"),
            ],
        ),
        (road, &[("highway", "residential"), ("width", "NaN")]),
    ]);
    let world = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap();
    assert!(world.scene.triangles.len() < 50_000);
}

#[test]
fn a_map_without_buildings_or_of_another_place_is_rejected() {
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (40.0, 0.0)];
    let (data, georeference) = map_of(&[(road, &[("highway", "residential")])]);
    let error = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap_err();
    let expected = matches!(error, GenerateError::NoBuildings { broken: 0 });
    assert!(expected, "{error}");
    let house: &[(f64, f64)] = &[(4.0, 5.0), (14.0, 5.0), (14.0, 13.0), (4.0, 13.0)];
    let (data, _) = map_of(&[(house, &[("building", "yes")])]);
    let elsewhere = Georeference::tangent_plane(LonLat::new(18.0, 48.0));
    let error = generate(&data, elsewhere, 1, &GenerateOptions::default()).unwrap_err();
    assert!(matches!(error, GenerateError::Distorted { .. }), "{error}");
}

#[test]
fn roads_and_walls_around_the_earth_cost_nothing() {
    let (mut data, georeference) =
        row_of_houses(2, &[("highway", "residential")], &[("building", "yes")]);
    for i in 0..200 {
        let lon = f64::from(i) - 100.0;
        data.nodes.insert(
            10_000 + i64::from(i),
            Node {
                id: 10_000 + i64::from(i),
                position: LonLat::new(lon, 48.0),
                tags: Tags::new(),
            },
        );
    }
    for (id, key, value) in [
        (900, "highway", "primary"),
        (901, "barrier", "wall"),
        (902, "natural", "tree_row"),
    ] {
        let tags: Tags = [(key, value)].into_iter().collect();
        data.ways.insert(
            id,
            Way {
                id,
                nodes: (10_000..10_200).collect(),
                tags,
            },
        );
    }
    let world = made(&data, georeference);
    assert!(
        world.scene.triangles.len() < 20_000,
        "{}",
        world.scene.triangles.len()
    );
    assert!(
        world.scene.solid.positions.len() < 10_000,
        "{}",
        world.scene.solid.positions.len()
    );
}

#[test]
fn a_map_with_swapped_or_mirrored_coordinates_is_rejected() {
    let (mut data, _) = row_of_houses(3, &[("highway", "residential")], &[("building", "yes")]);
    let georeference: Georeference = "utm:32N,-400000,-5300000".parse().unwrap();
    let at_home = openbench_osm::default_georeference(&data).unwrap();
    assert!(!made(&data, at_home).scene.doors.is_empty());
    let original = data.clone();
    let wrong: [fn(LonLat) -> LonLat; 2] = [
        |p| LonLat::new(p.lat, p.lon),
        |p| LonLat::new(-p.lon, p.lat),
    ];
    for turn in wrong {
        data.clone_from(&original);
        data.nodes
            .values_mut()
            .for_each(|n| n.position = turn(n.position));
        let error = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap_err();
        assert!(
            matches!(
                error,
                GenerateError::Distorted { .. } | GenerateError::TooLarge { .. }
            ),
            "{error}"
        );
        // With a georeference of its own position it is a place like any other.
        let there = openbench_osm::default_georeference(&data).unwrap();
        assert!(!made(&data, there).scene.doors.is_empty());
    }
}

#[test]
fn houses_on_both_sides_of_the_earth_are_too_far_apart() {
    let (mut data, georeference) =
        row_of_houses(2, &[("highway", "residential")], &[("building", "yes")]);
    for node in data.nodes.values_mut().take(4) {
        node.position = LonLat::new(node.position.lon - 180.0, -node.position.lat);
    }
    let error = generate(&data, georeference, 1, &GenerateOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("cut out a neighbourhood"),
        "{error}"
    );
}

#[test]
fn invalid_coordinates_never_get_into_a_map() {
    let node = |id: i64, lat: &str, lon: &str| format!("<node id='{id}' lat='{lat}' lon='{lon}'/>");
    let bad = [
        ("95", "8"),
        ("48", "190"),
        ("NaN", "8"),
        ("48", "-inf"),
        ("1e400", "8"),
        ("480", "80"),
    ];
    let nodes: String = bad
        .iter()
        .enumerate()
        .map(|(i, (lat, lon))| node(i as i64 + 1, lat, lon))
        .collect();
    let data = OsmData::from_xml(format!("<osm>{nodes}</osm>").as_bytes()).unwrap();
    assert_eq!((data.nodes.len(), data.report.bad_elements), (0, bad.len()));
    // A map that was made in memory fails here.
    let (mut data, georeference) =
        row_of_houses(3, &[("highway", "residential")], &[("building", "yes")]);
    let first = *data.nodes.keys().next().unwrap();
    for position in [
        LonLat::new(f64::NAN, 48.0),
        LonLat::new(8.0, f64::INFINITY),
        LonLat::new(8.0, 1e300),
    ] {
        data.nodes.get_mut(&first).unwrap().position = position;
        match generate(&data, georeference, 1, &GenerateOptions::default()) {
            Ok(world) => {
                let finite = |v: &openbench_scene::Vertex| v.position.iter().all(|c| c.is_finite());
                assert!(world.scene.vertices.iter().all(finite));
            }
            Err(error) => assert!(
                error.to_string().contains("cut out") || error.to_string().contains("origin"),
                "{error}"
            ),
        }
    }
}

#[test]
fn buildings_without_area_are_counted_and_the_others_are_built() {
    let (mut data, georeference) =
        row_of_houses(3, &[("highway", "residential")], &[("building", "yes")]);
    let nodes: Vec<i64> = data.nodes.keys().copied().take(2).collect();
    let flat = |id: i64, nodes: Vec<i64>| Way {
        id,
        nodes,
        tags: Tags::from([("building", "yes")]),
    };
    let (a, b) = (nodes[0], nodes[1]);
    for (id, nodes) in [
        (800, vec![a, b, a]),
        (801, vec![a, a, a, a]),
        (802, vec![a, b, a, b, a]),
        (803, vec![a, b]),
    ] {
        data.ways.insert(id, flat(id, nodes));
    }
    let world = made(&data, georeference);
    assert_eq!(world.scene.doors.len(), 3);
    let said = world.warnings.join("; ");
    assert!(
        said.contains("4 buildings without a closed outline"),
        "{said}"
    );
}

#[test]
fn a_footprint_that_crosses_itself_many_times_is_a_building() {
    // A star of 21 points, drawn through its middle.
    let star: Vec<(f64, f64)> = (0..21)
        .map(|i| {
            let p = MapPoint::new(20.0, 20.0)
                .offset(std::f64::consts::TAU * f64::from(i) * 10.0 / 21.0, 12.0);
            (p.x, p.y)
        })
        .collect();
    let road: &[(f64, f64)] = &[(-30.0, 0.0), (70.0, 0.0)];
    for shape in ["flat", "gabled", "hipped", "mansard", "pyramidal", "dome"] {
        let tags = [
            ("building", "yes"),
            ("roof:shape", shape),
            ("building:levels", "4"),
        ];
        let (data, georeference) = map_of(&[(&star, &tags), (road, &[("highway", "residential")])]);
        let world = made(&data, georeference);
        assert!(
            (100..20_000).contains(&world.scene.triangles.len()),
            "{shape}: {}",
            world.scene.triangles.len()
        );
        assert!(
            world
                .scene
                .vertices
                .iter()
                .all(|v| v.position.iter().all(|c| c.abs() < 2_000.0)),
            "{shape}"
        );
    }
}

#[test]
fn implausible_parts_are_left_out_or_bounded() {
    let house = rectangle((0.0, 5.0), (20.0, 15.0));
    let away = rectangle((60.0, 5.0), (70.0, 15.0));
    let bow_tie = [(1.0, 6.0), (9.0, 14.0), (9.0, 6.0), (1.0, 14.0)];
    let part = |more: &[(&'static str, &'static str)]| {
        let mut tags = vec![("building:part", "yes")];
        tags.extend(more);
        tags
    };
    let (lost, upside_down, endless) = (
        part(&[]),
        part(&[("height", "3"), ("min_height", "30")]),
        part(&[
            ("height", "1e300"),
            ("min_height", "NaN"),
            ("building:levels", "-7"),
            ("building:min_level", "1e9"),
        ]),
    );
    let (data, georeference) = map_of(&[
        (&house, &[("building", "yes")]),
        (&away, &lost),
        (&house, &upside_down),
        (&bow_tie, &endless),
        (&[(-30.0, 0.0), (70.0, 0.0)], &[("highway", "residential")]),
    ]);
    let world = made(&data, georeference);
    assert!(
        world
            .warnings
            .iter()
            .any(|w| w.starts_with("1 parts of buildings lie in no building")),
        "{:?}",
        world.warnings
    );
    assert!(world.scene.vertices.iter().all(|v| v.position[2] < 100.0));
    assert_eq!(world.scene.doors.len(), 1);
}
