//! No simple rule on the public map finds the doors.
#![allow(clippy::print_stdout)]

mod rules;

use openbench_core::MapPoint;
use openbench_neighbourhoods::{Kind, Neighbourhood, draw};
use openbench_osm::{OsmMap, without_doors};

use rules::Found;

/// Seeds for validation: nothing is tuned on them.
const SEEDS: std::ops::Range<u64> = 10_000..10_100;

#[test]
fn the_best_of_five_rules_finds_few_doors() {
    let mut found = Found::default();
    for kind in Kind::ALL {
        for seed in SEEDS {
            count(&draw(kind, seed), &mut found);
        }
    }
    let best = found.report();
    assert!(best <= 0.2, "{best}");
}

/// Adds the doors of a neighbourhood.
fn count(here: &Neighbourhood, found: &mut Found) {
    let map = OsmMap::new(&here.map, here.georeference);
    let public = OsmMap::new(&without_doors(&here.map), here.georeference);
    for (index, building) in map.buildings.iter().enumerate() {
        let own = map
            .entrances
            .iter()
            .filter(|door| door.building == Some(index));
        let doors: Vec<MapPoint> = own.map(|door| door.position).collect();
        let Some(known) = public
            .buildings
            .iter()
            .find(|b| b.element == building.element)
        else {
            panic!("{}: {} is not public", here.name(), building.element);
        };
        found.add(&public, known, &doors);
    }
}
