//! Drawn neighbourhoods as worlds: built whole, reached everywhere, the same for one seed.
#![allow(clippy::print_stdout)]

use openbench_bench::worlds::{neighbourhood_suite, suite_named, suite_of_seed};
use openbench_bench::{Prepared, WorldSource, builtin_suite};
use openbench_neighbourhoods::{Kind, draw};
use openbench_osm::OsmMap;

/// Seeds that are built for each kind.
const SEEDS: std::ops::Range<u64> = 1..4;

#[test]
fn every_door_of_the_map_is_built_and_reached() {
    let (mut doors, mut reached) = (0, 0);
    for kind in Kind::ALL {
        for seed in SEEDS {
            let here = draw(kind, seed);
            let map = OsmMap::new(&here.map, here.georeference);
            let suite = suite_named(&here.name()).unwrap();
            let prepared = Prepared::new(suite, None).unwrap();
            let world = &prepared.world;
            assert_eq!(world.name, here.name());
            assert_eq!(
                world.scene.doors.len(),
                map.entrances.len(),
                "{}",
                here.name()
            );
            for (door, approach) in world.scene.doors.iter().zip(&prepared.approach) {
                doors += 1;
                reached += usize::from(approach.is_some());
                if approach.is_none() {
                    println!("{}: {} is not reached", here.name(), door.address);
                }
            }
        }
    }
    println!("{reached} of {doors} doors are reached");
    assert!(reached * 1000 >= doors * 995, "{reached} of {doors}");
}

#[test]
fn scenery_shuts_no_door_off() {
    let mut drawn_kerbs = 0;
    for kind in Kind::ALL {
        for seed in SEEDS {
            let suite = neighbourhood_suite(kind, seed).unwrap();
            let mut varied = suite.clone();
            for number in ["ground", "shapes", "clutter", "relief"] {
                let key = format!("scenery.{number}");
                varied.conditions.set(&key, "1").unwrap();
            }
            let [plain, varied] = [suite, varied].map(|s| Prepared::world_of(s).unwrap());
            let pairs = plain.approach.iter().zip(&varied.approach);
            for (number, (before, with)) in pairs.enumerate() {
                let door = &varied.world.scene.doors[number].address;
                let is_kept = before.is_none() || with.is_some();
                assert!(is_kept, "{}: {door}", varied.suite.name);
            }
            drawn_kerbs += varied.world.scenery.unwrap().kerbs;
        }
    }
    assert!(drawn_kerbs > 50, "{drawn_kerbs}");
}

#[test]
fn a_seed_is_another_neighbourhood_and_seed_0_the_built_in_world() {
    assert_eq!(
        suite_of_seed("small", 0).unwrap(),
        builtin_suite("small").unwrap()
    );
    let drawn = suite_of_seed("small", 7).unwrap();
    assert_eq!(drawn, neighbourhood_suite(Kind::Small, 7).unwrap());
    assert_eq!(drawn, suite_named("small-7").unwrap());
    assert_eq!(drawn.name, "small-7");
    let source = WorldSource::Drawn {
        kind: "small".into(),
        seed: 7,
    };
    assert_eq!(drawn.world, source);
    assert_ne!(drawn, suite_of_seed("small", 8).unwrap());
    // The seed of a run changes noise, and not the suite.
    assert_eq!(drawn.clone().with_seed(3), drawn);
    assert!(suite_named("small-07").is_err());
}
