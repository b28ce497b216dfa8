use std::collections::BTreeSet;
use std::fmt::Write;

use openbench_core::Georeference;
use openbench_geometry::Polygon;
use proptest::prelude::*;

use super::*;
use crate::map::Building;

/// Metres of a degree near the equator and the origin, about.
const METRES: f64 = 111_000.0;

fn place() -> Georeference {
    Georeference::tangent_plane(openbench_core::LonLat::default())
}

/// Rows of ten houses of 10 by 8 m, wall to wall, along streets 40 m apart. Every house has a name
/// and an address node inside; the street is a way.
fn town(rows: usize) -> OsmData {
    let mut xml = String::from("<osm version=\"0.6\">");
    let mut node = |id: usize, x: f64, y: f64, tags: &str| {
        let (lat, lon) = (y / METRES, x / METRES);
        let _ = write!(
            xml,
            "<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\">{tags}</node>"
        );
    };
    for row in 0..rows {
        let y = row as f64 * 40.0;
        for column in 0..=10 {
            let x = column as f64 * 10.0;
            node(row * 100 + column + 1, x, y, "");
            node(row * 100 + column + 21, x, y + 8.0, "");
            node(row * 100 + column + 41, x, y - 10.0, "");
            if column < 10 {
                let number = row * 10 + column + 1;
                let tag = format!("<tag k=\"addr:housenumber\" v=\"{number}\"/>");
                node(row * 100 + column + 61, x + 5.0, y + 4.0, &tag);
            }
        }
    }
    for row in 0..rows {
        let reference =
            |column: usize, at: usize| format!("<nd ref=\"{}\"/>", row * 100 + column + at);
        for column in 0..10 {
            let corners = [(0, 1), (1, 1), (1, 21), (0, 21), (0, 1)];
            let nodes: String = corners
                .map(|(side, at)| reference(column + side, at))
                .concat();
            let id = row * 100 + column + 1;
            let name = row * 10 + column + 1;
            let _ = write!(
                xml,
                "<way id=\"{id}\">{nodes}<tag k=\"building\" v=\"house\"/>\
                 <tag k=\"name\" v=\"building{name}\"/></way>"
            );
        }
        let nodes: String = (0..=10).map(|column| reference(column, 41)).collect();
        let id = row * 100 + 50;
        let _ = write!(
            xml,
            "<way id=\"{id}\">{nodes}<tag k=\"highway\" v=\"residential\"/></way>"
        );
    }
    OsmData::from_xml((xml + "</osm>").as_bytes()).unwrap()
}

fn disturbed(data: &OsmData, errors: MapErrors, seed: u64) -> Disturbed {
    disturb(data, place(), &errors, &BTreeSet::new(), seed).unwrap()
}

fn buildings(data: &OsmData) -> Vec<Building> {
    OsmMap::new(data, place()).buildings
}

/// The building of that name.
fn named<'a>(buildings: &'a [Building], name: &Option<String>) -> &'a Building {
    buildings.iter().find(|b| b.name == *name).unwrap()
}

/// The greatest distance between the corners of two outlines.
fn farthest(a: &Polygon, b: &Polygon) -> f64 {
    assert_eq!(a.outer.len(), b.outer.len());
    let pairs = a.outer.iter().zip(&b.outer);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn without_errors_the_map_stays_as_it_is() {
    let right = town(3);
    let same = disturbed(&right, MapErrors::EXACT, 1);
    assert_eq!(same.frame, Pose2::default());
    let after = buildings(&same.map);
    for a in buildings(&right) {
        let b = named(&after, &a.name);
        assert!(farthest(&a.polygon, &b.polygon) < 0.02);
    }
}

#[test]
fn each_building_is_shifted_on_its_own_and_the_map_as_a_whole() {
    let right = town(20);
    let errors = MapErrors {
        rotation_deg: 1.0,
        ..MapErrors::CITY
    };
    let errors = MapErrors {
        missing: 0.0,
        ..errors
    };
    let wrong = disturbed(&right, errors, 5);
    let (before, after) = (buildings(&right), buildings(&wrong.map));
    assert_eq!(before.len(), after.len());
    let mut squares = 0.0;
    for a in &before {
        let b = named(&after, &a.name);
        for (corner, moved) in a.polygon.outer.iter().zip(&b.polygon.outer) {
            let expected = wrong.beside(Some(a.element), *corner);
            assert!(moved.distance(expected) < 0.02);
        }
        let shift = wrong.buildings[&a.element].shift;
        squares += shift.x * shift.x + shift.y * shift.y;
    }
    let deviation = libm::sqrt(squares / (2.0 * before.len() as f64));
    assert!((deviation - 1.5).abs() < 0.2, "{deviation}");
    // The address inside a house moves with it, and the street with the whole map only.
    let map = OsmMap::new(&wrong.map, place());
    let inside = |node: &&crate::element::Node| {
        let at = map.projection.to_map(node.position);
        map.distance_to_building(map.nearest_building(at).unwrap(), at) < 0.02
    };
    let addresses = wrong.map.nodes.values().filter(|n| !n.tags.is_empty());
    assert_eq!(addresses.filter(inside).count(), 200);
    let street = &OsmMap::new(&right, place()).roads[0].points;
    for at in street {
        let expected = wrong.beside(None, *at);
        let mut nodes = map.roads.iter().flat_map(|road| &road.points);
        assert!(nodes.any(|node| node.distance(expected) < 0.02));
    }
}

#[test]
fn a_missing_building_leaves_no_trace() {
    let right = town(20);
    let errors = MapErrors {
        missing: 0.3,
        ..MapErrors::EXACT
    };
    let wrong = disturbed(&right, errors, 2);
    let is_missing = |e: &&BuildingError| e.state == MapState::Missing;
    let missing = wrong.buildings.values().filter(is_missing).count();
    assert!((40..80).contains(&missing), "{missing} of 200");
    let left = buildings(&wrong.map);
    assert_eq!(left.len(), 200 - missing);
    // Neither its address nor a gap in the numbers is left.
    let addresses = wrong.map.nodes.values().filter(|n| !n.tags.is_empty());
    assert_eq!(addresses.count(), 200 - missing);
    let numbers = wrong.map.nodes.keys().copied();
    assert!(numbers.eq(1..=wrong.map.nodes.len() as i64));
    let used: BTreeSet<i64> = wrong
        .map
        .ways
        .values()
        .flat_map(|way| way.nodes.clone())
        .collect();
    let is_unused = |n: &&crate::element::Node| n.tags.is_empty() && !used.contains(&n.id);
    assert_eq!(wrong.map.nodes.values().filter(is_unused).count(), 0);
}

#[test]
fn buildings_that_get_a_delivery_are_spared_where_the_errors_say_so() {
    let right = town(3);
    let ordered: BTreeSet<ElementId> = buildings(&right)[..10].iter().map(|b| b.element).collect();
    let wrong_ones = |spares_ordered| {
        let errors = MapErrors {
            missing: 0.8,
            spares_ordered,
            ..MapErrors::EXACT
        };
        let wrong = disturb(&right, place(), &errors, &ordered, 3).unwrap();
        let states = ordered.iter().map(|element| wrong.buildings[element].state);
        states.filter(|state| *state != MapState::Right).count()
    };
    assert_eq!(wrong_ones(true), 0);
    assert!(wrong_ones(false) > 5);
}

#[test]
fn wrong_numbers_are_those_of_no_building() {
    let right = town(4);
    let errors = MapErrors {
        wrong_numbers: 0.5,
        unnamed: 0.2,
        ..MapErrors::EXACT
    };
    let wrong = disturbed(&right, errors, 1);
    let names: Vec<Option<String>> = buildings(&wrong.map).into_iter().map(|b| b.name).collect();
    let given: BTreeSet<&String> = names.iter().flatten().collect();
    let unnamed = names.iter().filter(|name| name.is_none()).count();
    assert_eq!(given.len() + unnamed, 40, "each name is given once");
    let is_wrong = |e: &&BuildingError| e.state == MapState::WrongNumber;
    let wrong_numbers = wrong.buildings.values().filter(is_wrong).count();
    let true_names = names.iter().flatten().filter(|name| {
        let number: usize = name["building".len()..].parse().unwrap();
        (1..=40).contains(&number)
    });
    assert_eq!(true_names.count(), 40 - unnamed - wrong_numbers);
    assert!(
        wrong_numbers > 5 && unnamed > 2,
        "{wrong_numbers}, {unnamed}"
    );
    // Addresses inside do not tell the right number.
    let addresses = wrong.map.nodes.values().filter(|n| !n.tags.is_empty());
    assert_eq!(addresses.count(), 40 - unnamed - wrong_numbers);
    // The order of the buildings does not tell their names: it is that of their places.
    let map = OsmMap::new(&wrong.map, place());
    let wests = map.buildings.iter().map(|b| b.polygon.bounds().low.x);
    assert!(wests.is_sorted_by(|a, b| *a <= *b + 0.02));
}

#[test]
fn invented_buildings_stand_free_and_their_numbers_do_not_tell() {
    let right = town(10);
    let errors = MapErrors {
        invented: 0.2,
        ..MapErrors::EXACT
    };
    let wrong = disturbed(&right, errors, 4);
    assert!(wrong.invented.len() > 10, "{}", wrong.invented.len());
    let map = OsmMap::new(&wrong.map, place());
    let is_invented = |b: &Building| {
        let middle = b.polygon.centroid();
        let mut invented = wrong.invented.iter();
        invented.any(|outline| outline.centroid().distance(middle) < 0.1)
    };
    let positions: Vec<usize> = (0..map.buildings.len())
        .filter(|i| is_invented(&map.buildings[*i]))
        .collect();
    // They have numbers as the others have, and none has that of another one.
    let names: BTreeSet<&String> = map
        .buildings
        .iter()
        .filter_map(|b| b.name.as_ref())
        .collect();
    assert_eq!(names.len(), map.buildings.len());
    assert_eq!(positions.len(), wrong.invented.len());
    assert!(positions[0] < 50, "all of them at the end");
    for i in positions {
        for corner in &map.buildings[i].polygon.outer {
            let near = map.buildings_within(*corner, 1.9);
            assert_eq!(near, [i]);
        }
    }
}

#[test]
fn one_more_kind_of_error_leaves_the_others_alone() {
    let right = town(5);
    let one = disturbed(&right, MapErrors::GOOD, 9);
    let errors = MapErrors {
        invented: 0.1,
        wrong_numbers: 0.1,
        road_shift_m: 2.0,
        simplified: 0.5,
        ..MapErrors::GOOD
    };
    let more = disturbed(&right, errors, 9);
    for (a, b) in one.buildings.values().zip(more.buildings.values()) {
        assert_eq!(a.shift, b.shift);
    }
    assert_eq!(
        one.map.to_xml(),
        disturbed(&right, MapErrors::GOOD, 9).map.to_xml()
    );
    assert_ne!(
        one.map.to_xml(),
        disturbed(&right, MapErrors::GOOD, 8).map.to_xml()
    );
}

#[test]
fn a_building_with_many_corners_becomes_a_rectangle_and_roads_vanish() {
    let mut right = town(2);
    // An L: the corner of the first house is cut out.
    right.nodes.get_mut(&1).unwrap().position.lat = 3.0 / METRES;
    let extra = crate::element::Node {
        id: 999,
        position: openbench_core::LonLat::new(5.0 / METRES, 3.0 / METRES),
        ..Default::default()
    };
    right.nodes.insert(999, extra);
    right.ways.get_mut(&1).unwrap().nodes.insert(1, 999);
    let errors = MapErrors {
        simplified: 1.0,
        missing_roads: 1.0,
        ..MapErrors::EXACT
    };
    let wrong = disturbed(&right, errors, 1);
    let simplified = wrong.buildings.values().filter(|e| e.is_simplified);
    assert_eq!(simplified.count(), 1, "the others are rectangles already");
    let map = OsmMap::new(&wrong.map, place());
    assert!(map.roads.is_empty() && wrong.missing_roads == 2);
    assert_eq!(map.buildings[0].polygon.outer.len(), 4);
    assert!((map.buildings[0].polygon.area() - 80.0).abs() < 1.0);
}

#[test]
fn a_map_without_any_building_left_is_refused() {
    let errors = MapErrors {
        missing: 1.0,
        ..MapErrors::EXACT
    };
    let refused = disturb(&town(1), place(), &errors, &BTreeSet::new(), 1).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("none of the map's 10 buildings")
    );
    // One that has none before is not made worse.
    assert!(disturb(&OsmData::default(), place(), &errors, &BTreeSet::new(), 1).is_ok());
}

proptest! {
    /// Whatever the errors: the same elements refer to each other, and each outline is a polygon.
    #[test]
    fn every_disturbed_map_is_whole(
        seed in any::<u64>(),
        shares in proptest::array::uniform6(0.0..0.9_f64),
        metres in proptest::array::uniform4(0.0..8.0_f64),
    ) {
        let [missing, invented, wrong_numbers, unnamed, simplified, missing_roads] = shares;
        let [shift_m, building_shift_m, swelling_m, road_shift_m] = metres;
        let errors = MapErrors {
            shift_m,
            rotation_deg: 2.0,
            building_shift_m,
            missing,
            invented,
            wrong_numbers,
            unnamed,
            simplified,
            swelling_m,
            road_shift_m,
            missing_roads,
            spares_ordered: true,
        };
        let right = town(2);
        let ordered = BTreeSet::from([ElementId::way(1)]);
        let wrong = disturb(&right, place(), &errors, &ordered, seed).unwrap();
        let map = OsmMap::new(&wrong.map, place());
        let is_missing = |e: &&BuildingError| e.state == MapState::Missing;
        let missing = wrong.buildings.values().filter(is_missing).count();
        prop_assert_eq!(map.buildings.len(), 20 - missing + wrong.invented.len());
        prop_assert_eq!(map.report.broken_buildings, 0);
        prop_assert_eq!(map.roads.len(), 2 - wrong.missing_roads);
        for way in wrong.map.ways.values() {
            prop_assert!(way.nodes.iter().all(|node| wrong.map.nodes.contains_key(node)));
        }
    }
}
