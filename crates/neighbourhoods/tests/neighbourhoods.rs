//! What holds for every drawn neighbourhood.
#![allow(clippy::print_stdout)]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use openbench_core::{Address, MapPoint};
use openbench_geometry::{Bounds, Segment, segments, sides};
use openbench_neighbourhoods::{Kind, Neighbourhood, draw};
use openbench_osm::{Building, Location, OsmData, OsmMap, Road, locate, without_doors};

const SEEDS: u64 = 200;
/// Files keep positions to a centimetre.
const EXACT_M: f64 = 0.03;

/// The neighbourhoods of all kinds and many seeds: drawing them takes longer than any check.
static ALL: LazyLock<Vec<(Neighbourhood, OsmMap)>> = LazyLock::new(|| {
    let kinds = Kind::ALL.into_iter();
    let drawn = kinds.flat_map(|kind| (0..SEEDS).map(move |seed| draw(kind, seed)));
    let projected = drawn.map(|here| {
        let map = OsmMap::new(&here.map, here.georeference);
        (here, map)
    });
    projected.collect()
});

fn for_each(check: impl Fn(&Neighbourhood, &OsmMap)) {
    ALL.iter().for_each(|(here, map)| check(here, map));
}

fn of_kind(kind: Kind) -> impl Iterator<Item = &'static (Neighbourhood, OsmMap)> {
    ALL.iter().filter(move |(here, _)| here.kind == kind)
}

fn outline_points(building: &Building) -> Vec<MapPoint> {
    let mut points = Vec::new();
    for side in sides(&building.polygon.outer) {
        let steps = side.length().ceil() as usize;
        points.extend((0..steps).map(|i| side.at(i as f64 / steps as f64)));
    }
    points
}

/// Whether a point of one outline is deeper inside the other than outlines are exact.
fn overlap(a: &Building, b: &Building) -> bool {
    let inside =
        |p: &MapPoint| b.polygon.contains(*p) && b.polygon.distance_to_boundary(*p) > EXACT_M;
    outline_points(a).iter().any(inside)
}

/// Half the width of a way with its pavements, metres.
fn half_width(road: &Road) -> f64 {
    let pavement = if road.tags.is("sidewalk", "both") {
        1.8
    } else {
        0.0
    };
    road.tags.metres("width").unwrap() / 2.0 + pavement
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_others() {
    for kind in Kind::ALL {
        let maps: BTreeSet<Vec<u8>> = (0..20).map(|seed| draw(kind, seed).map.to_xml()).collect();
        assert_eq!(maps.len(), 20);
        let again: BTreeSet<Vec<u8>> = (0..20).map(|seed| draw(kind, seed).map.to_xml()).collect();
        assert_eq!(maps, again);
    }
}

#[test]
fn a_map_is_equal_after_writing_and_reading() {
    for_each(|here, _| {
        let read = OsmData::from_xml(&here.map.to_xml()).unwrap();
        assert_eq!(read.nodes, here.map.nodes, "{}", here.name());
        assert_eq!(read.ways, here.map.ways, "{}", here.name());
        assert_eq!(read.relations, here.map.relations, "{}", here.name());
        assert!(read.report.notes().is_empty(), "{:?}", read.report.notes());
    });
}

#[test]
fn buildings_overlap_neither_each_other_nor_streets() {
    for_each(|here, map| {
        for (i, a) in map.buildings.iter().enumerate() {
            for b in &map.buildings[i + 1..] {
                let near = a.polygon.bounds().meets(b.polygon.bounds(), 0.0);
                let apart = !near || !overlap(a, b) && !overlap(b, a);
                assert!(apart, "{}: {} and {}", here.name(), a.element, b.element);
            }
            for road in map.roads.iter().filter(|road| road.tags.has("name")) {
                let free = segments(&road.points).all(|stretch| {
                    let mut walls = a.polygon.sides();
                    walls.all(|wall| wall.distance_to(stretch) > half_width(road))
                });
                assert!(free, "{}: {} in {}", here.name(), a.element, road.way);
            }
        }
    });
}

#[test]
fn all_streets_and_paths_are_connected() {
    for_each(|here, map| {
        let mut ways_of_node = BTreeMap::<i64, Vec<usize>>::new();
        for (i, road) in map.roads.iter().enumerate() {
            for node in &road.nodes {
                ways_of_node.entry(*node).or_default().push(i);
            }
        }
        let (mut seen, mut open) = (BTreeSet::from([0]), vec![0]);
        while let Some(road) = open.pop() {
            for next in map.roads[road].nodes.iter().flat_map(|n| &ways_of_node[n]) {
                if seen.insert(*next) {
                    open.push(*next);
                }
            }
        }
        assert_eq!(seen.len(), map.roads.len(), "{}", here.name());
    });
}

#[test]
fn doors_are_in_walls_with_free_ground_in_front() {
    for_each(|here, map| {
        for door in &map.entrances {
            let building = &map.buildings[door.building.unwrap()];
            let foot = building.polygon.nearest_boundary_point(door.position);
            assert!(
                foot.point.distance(door.position) < EXACT_M,
                "{}",
                here.name()
            );
            let front = Segment::new(
                door.position.offset(foot.normal, 0.6),
                door.position.offset(foot.normal, 1.5),
            );
            let around = Bounds::of_point(door.position).grown(3.0);
            let walls = map
                .buildings
                .iter()
                .filter(|other| other.polygon.bounds().meets(around, 0.0))
                .flat_map(|other| other.polygon.sides());
            let barriers = map.barriers.iter().flat_map(|b| segments(&b.points));
            let nearest = walls
                .chain(barriers)
                .map(|solid| solid.distance_to(front))
                .fold(f64::INFINITY, f64::min);
            assert!(
                nearest > 0.45,
                "{}: node {}: {nearest}",
                here.name(),
                door.node
            );
        }
    });
}

#[test]
fn every_door_has_an_address_of_its_own() {
    for_each(|here, map| {
        let public = OsmMap::new(&without_doors(&here.map), here.georeference);
        let mut addresses = BTreeSet::new();
        for (i, building) in map.buildings.iter().enumerate() {
            let doors: Vec<_> = map
                .entrances
                .iter()
                .filter(|d| d.building == Some(i))
                .collect();
            let Some(name) = &building.name else {
                assert!(doors.is_empty(), "{}: {}", here.name(), building.element);
                continue;
            };
            let (count, element) = (doors.len(), building.element);
            assert!(
                (1..=20).contains(&count),
                "{}: {element}: {count}",
                here.name()
            );
            for door in doors {
                let address = Address::new(name.clone(), format!("unit{}", door.units[0]));
                let known = locate(map, &address);
                let Location::Unit { entrance, building } = known else {
                    panic!("{}: {address}: {known:?}", here.name());
                };
                assert_eq!((map.entrances[entrance].node, building), (door.node, i));
                let Location::Building(found) = locate(&public, &address) else {
                    panic!("{}: {address} is not found", here.name());
                };
                assert_eq!(public.buildings[found].element, building_of(map, i));
                assert!(addresses.insert(address.to_string()), "{address}");
            }
        }
    });
}

fn building_of(map: &OsmMap, index: usize) -> openbench_osm::ElementId {
    map.buildings[index].element
}

#[test]
fn kinds_are_as_large_as_the_built_in_worlds() {
    // Buildings with a name and doors of the built-in worlds: 3 and 8, 14 and 38, 22 and 61.
    for (kind, homes, doors) in [
        (Kind::Small, 3.0..9.0, 7.0..18.0),
        (Kind::Medium, 11.0..24.0, 28.0..56.0),
        (Kind::Large, 20.0..44.0, 50.0..110.0),
    ] {
        let (mut all_homes, mut all_doors) = (0, 0);
        for (here, map) in of_kind(kind) {
            let own = map.buildings.iter().filter(|b| b.name.is_some()).count();
            assert!(
                own >= 2 && map.entrances.len() >= 3,
                "{}: {own}",
                here.name()
            );
            all_homes += own;
            all_doors += map.entrances.len();
        }
        let mean = |sum: usize| sum as f64 / SEEDS as f64;
        println!(
            "{kind}: {} homes, {} doors",
            mean(all_homes),
            mean(all_doors)
        );
        assert!(
            homes.contains(&mean(all_homes)),
            "{kind}: {}",
            mean(all_homes)
        );
        assert!(
            doors.contains(&mean(all_doors)),
            "{kind}: {}",
            mean(all_doors)
        );
    }
}

#[test]
fn the_start_is_in_a_street_and_neither_the_origin_nor_the_middle() {
    let (mut from_origin, mut from_middle) = (0.0, 0.0);
    for_each(|here, map| {
        let start = here.start.point();
        let on_a_street = map.roads.iter().any(|road| {
            segments(&road.points).any(|s| s.distance_to_point(start) < half_width(road))
        });
        assert!(on_a_street, "{}", here.name());
        let nearest = map.nearest_building(start).unwrap();
        assert!(
            map.distance_to_building(nearest, start) > 1.5,
            "{}",
            here.name()
        );
    });
    for (here, map) in of_kind(Kind::Large) {
        let boxes = map.buildings.iter().map(|b| b.polygon.bounds());
        let middle = boxes.reduce(Bounds::union).unwrap().middle();
        from_origin += here.start.point().distance(MapPoint::default()) / SEEDS as f64;
        from_middle += here.start.point().distance(middle) / SEEDS as f64;
    }
    assert!(
        from_origin > 30.0 && from_middle > 30.0,
        "{from_origin} {from_middle}"
    );
}
