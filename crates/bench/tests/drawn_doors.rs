//! Doors that are drawn where the map of a real place has none.
#![allow(clippy::print_stdout)]

#[path = "../../neighbourhoods/tests/rules/mod.rs"]
mod rules;

use std::collections::BTreeMap;

use openbench_bench::worlds::{load, load_with, source_named};
use openbench_bench::{Prepared, Suite, WorldSource, builtin_suite};
use openbench_core::{Address, MapPoint};
use openbench_osm::OsmMap;
use openbench_scene::World;
use openbench_scene::generate::Alterations;

use rules::Found;

/// Seeds for validation: nothing is tuned on them.
const SEEDS: std::ops::Range<u64> = 10_000..10_001;
const PLACES: [&str; 5] = ["krems", "heidelberg", "campus", "bayreuth", "monaco"];

fn world(name: &str, drawn_doors: Option<u64>) -> World {
    let source = WorldSource::Builtin {
        name: name.to_owned(),
        seed: 1,
    };
    let by = Alterations {
        drawn_doors,
        ..Alterations::default()
    };
    load_with(&source, by).unwrap()
}

fn suite(name: &str, seed: u64) -> Suite {
    let mut suite = builtin_suite(name).unwrap();
    suite.conditions.set("doors", "drawn").unwrap();
    suite.with_seed(seed)
}

/// The doors of a world by the number of their building in its public map.
fn by_building(world: &World, map: &OsmMap) -> BTreeMap<usize, Vec<MapPoint>> {
    let mut doors: BTreeMap<usize, Vec<MapPoint>> = BTreeMap::new();
    for door in &world.scene.doors {
        let entrance = door.doorway.unwrap();
        let inside = entrance.transform(-0.3, 0.0);
        let building = map.nearest_building(inside).unwrap();
        doors.entry(building).or_default().push(entrance.point());
    }
    doors
}

#[test]
fn the_best_of_five_rules_finds_few_drawn_doors() {
    let mut all = Found::default();
    for name in PLACES {
        let mut here = Found::default();
        for seed in SEEDS {
            let world = world(name, Some(seed));
            let map = OsmMap::new(&world.map, world.georeference);
            for (building, doors) in by_building(&world, &map) {
                here.add(&map, &map.buildings[building], &doors);
                all.add(&map, &map.buildings[building], &doors);
            }
            println!("{name}, seed {seed}: {}", world.doors.unwrap().describe());
        }
        println!("{name}:");
        here.report();
    }
    println!("all places:");
    let best = all.report();
    assert!(all.all > 600, "{}", all.all);
    assert!(best <= 0.2, "{best}");
}

#[test]
fn without_the_condition_the_first_rule_finds_them() {
    let world = world("krems", None);
    assert!(world.doors.is_none());
    let map = OsmMap::new(&world.map, world.georeference);
    let mut found = Found::default();
    for (building, doors) in by_building(&world, &map) {
        found.add(&map, &map.buildings[building], &doors);
    }
    assert!(found.all > 10 && found.report() > 0.9);
}

#[test]
fn numbers_that_are_mapped_stay_and_others_differ_from_seed_to_seed() {
    let numbers = |seed: u64| -> Vec<Option<String>> {
        let world = world("heidelberg", Some(seed));
        let map = OsmMap::new(&world.map, world.georeference);
        let number = |tags: &openbench_osm::Tags| tags.get("addr:housenumber").map(str::to_owned);
        map.buildings.iter().map(|b| number(&b.tags)).collect()
    };
    let xml = include_str!("../data/places/heidelberg.osm");
    let data = openbench_osm::OsmData::from_xml(xml.as_bytes()).unwrap();
    let georeference = openbench_osm::default_georeference(&data).unwrap();
    let map = OsmMap::new(&data, georeference);
    let (one, other) = (numbers(1), numbers(2));
    assert_ne!(one, other);
    for (i, building) in map.buildings.iter().enumerate() {
        if let Some(mapped) = building.tags.get("addr:housenumber") {
            assert_eq!(one[i].as_deref(), Some(mapped));
        }
    }
}

#[test]
fn drawn_doors_are_reached_and_deliveries_follow_them() {
    let one = Prepared::new(suite("krems", 10_001), None).unwrap();
    let doors = &one.world.scene.doors;
    let drawn = one.world.doors.unwrap();
    assert_eq!(drawn.mapped + drawn.doors, doors.len());
    assert_eq!(drawn.front + drawn.flank + drawn.back, drawn.doors);
    let reached = one.approach.iter().flatten().count();
    println!("{reached} of {} doors are reached", doors.len());
    assert!(reached * 20 >= doors.len() * 19, "{reached}");
    let mut addresses: Vec<String> = doors.iter().map(|d| d.address.to_string()).collect();
    addresses.sort();
    addresses.dedup();
    assert_eq!(addresses.len(), doors.len());
    let lengths = |suite: &Suite| -> Vec<usize> {
        let episodes = suite.episodes.iter();
        episodes.map(|e| e.deliveries.len()).collect()
    };
    assert_eq!(lengths(&one.suite), lengths(&suite("krems", 10_001)));
    for target in one.episodes.iter().flat_map(|episode| &episode.targets) {
        let reached = target.door.and_then(|door| one.approach[door]);
        assert!(reached.is_some(), "{}", target.address);
    }
    let other = one.of_seed(10_002).unwrap().unwrap();
    assert_ne!(other.suite.episodes, one.suite.episodes);
    assert_eq!(lengths(&other.suite), lengths(&one.suite));
    // What a run keeps draws the same deliveries.
    let again = other.of_seed(10_001).unwrap().unwrap();
    assert_eq!(again.suite, one.suite);
}

#[test]
fn where_the_map_has_all_doors_the_condition_changes_nothing() {
    let source = source_named("medium-10001");
    let by = Alterations {
        drawn_doors: Some(7),
        ..Alterations::default()
    };
    let altered = load_with(&source, by).unwrap();
    assert_eq!(load(&source).unwrap().scene, altered.scene);
    assert_eq!(altered.doors, None);
    let usual = builtin_suite("small").unwrap();
    let same = Prepared::new(suite("small", 7), None).unwrap();
    assert_eq!(usual.episodes, same.suite.episodes);
}

#[test]
fn one_seed_has_one_world() {
    let doors = |seed| world("monaco", Some(seed)).scene.doors;
    let addresses = |seed| -> Vec<Address> { doors(seed).into_iter().map(|d| d.address).collect() };
    assert_eq!(doors(5), doors(5));
    assert_ne!(addresses(5), addresses(6));
}
