//! Maps of real places. Skipped with a message if the data folder is absent.
#![allow(clippy::print_stderr)]

#[path = "../../skips.rs"]
mod skips;

use std::time::Instant;

use openbench_core::{Address, MapPoint};
use openbench_osm::{
    Location, OsmData, OsmMap, add_entrance, default_georeference, locate, without_doors,
};
use skips::shared_data;

fn open(name: &str) -> Option<(OsmData, OsmMap)> {
    let path = shared_data(name)?;
    let start = Instant::now();
    let data = OsmData::read(&path).unwrap();
    let read = start.elapsed();
    let map = OsmMap::new(&data, default_georeference(&data).unwrap());
    eprintln!(
        "{name}: read in {read:?}, map in {:?}; {} nodes, {} ways, {} relations; \
         {} buildings, {} roads, {} barriers, {} areas, {} entrances, {:?}, {:?}",
        start.elapsed() - read,
        data.nodes.len(),
        data.ways.len(),
        data.relations.len(),
        map.buildings.len(),
        map.roads.len(),
        map.barriers.len(),
        map.areas.len(),
        map.entrances.len(),
        data.report,
        map.report
    );
    Some((data, map))
}

#[test]
fn the_published_worlds_lie_where_their_map_says() {
    for (name, buildings, roads) in [("small", 3, 0), ("medium", 14, 3)] {
        let Some((data, map)) = open(&format!("openbench/{name}/{name}.osm")) else {
            return;
        };
        assert_eq!(
            default_georeference(&data).unwrap().to_string(),
            "utm:50N,-500000,-4483000"
        );
        assert_eq!((map.buildings.len(), map.roads.len()), (buildings, roads));
        assert!(
            map.buildings
                .iter()
                .all(|b| b.polygon.centroid().distance(MapPoint::default()) < 300.0)
        );
        assert_eq!(map.report, Default::default());
        for number in 1..=buildings {
            let name = format!("building{number}");
            let Location::Building(i) = locate(&map, &Address::new(&name, "unit1")) else {
                panic!("{name}")
            };
            assert_eq!(map.buildings[i].name.as_deref(), Some(name.as_str()));
        }
    }
}

#[test]
fn a_door_survives_writing_and_reading() {
    let Some((mut data, map)) = open("openbench/medium/medium.osm") else {
        return;
    };
    let building = &map.buildings[4];
    let address = Address::new(building.name.clone().unwrap(), "unit2");
    let wall = building
        .polygon
        .nearest_boundary_point(MapPoint::new(0.0, 0.0));
    let door = add_entrance(
        &mut data,
        &map.projection,
        building.element,
        wall.point.offset(wall.normal, 0.4),
        &address,
    )
    .unwrap();
    assert!(door.position.distance(wall.point) < 0.06);
    let back = OsmData::from_xml(&data.to_xml()).unwrap();
    let map = OsmMap::new(&back, map.projection.georeference());
    assert_eq!(
        locate(&map, &address),
        Location::Unit {
            entrance: 0,
            building: 4
        }
    );
    assert_eq!(map.entrances[0].position, door.position);
}

#[test]
fn cities_are_read_whole() {
    for (name, buildings, roads) in [
        ("osm/monaco.osm.pbf", 23_000..24_000, 2_000..5_000),
        // A map of roads with almost no buildings.
        ("osm/porto_portugal.osm.pbf", 5..100, 50_000..60_000),
        ("osm/ajou_campus.osm", 50..500, 100..2_000),
    ] {
        let Some((data, map)) = open(name) else {
            continue;
        };
        assert!(
            buildings.contains(&map.buildings.len()),
            "{} buildings",
            map.buildings.len()
        );
        assert!(
            roads.contains(&map.roads.len()),
            "{} roads",
            map.roads.len()
        );
        assert_eq!(data.report.bad_elements, 0);
        let start = Instant::now();
        for building in map.buildings.iter().step_by(10) {
            let inside = building.polygon.interior_point();
            let nearest = map.nearest_building(inside).unwrap();
            assert_eq!(map.distance_to_building(nearest, inside), 0.0);
        }
        eprintln!(
            "{name}: {} look-ups in {:?}",
            map.buildings.len().div_ceil(10),
            start.elapsed()
        );
    }
}

#[test]
fn a_city_reads_the_same_from_xml_and_pbf() {
    let Some(path) = shared_data("osm/monaco.osm.pbf") else {
        return;
    };
    let data = OsmData::read(&path).unwrap();
    let back = OsmData::from_xml(&data.to_xml()).unwrap();
    assert!(back.nodes == data.nodes && back.ways == data.ways && back.relations == data.relations);
    assert_eq!(back.report, data.report);
}

#[test]
fn a_truncated_city_is_an_error() {
    let Some(path) = shared_data("osm/porto_portugal.osm.pbf") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    for length in [1, 3, 100, bytes.len() / 2, bytes.len() - 1] {
        let error = OsmData::from_bytes(&bytes[..length])
            .unwrap_err()
            .to_string();
        assert!(error.contains("byte") || error.contains("line"), "{error}");
    }
}

#[test]
fn a_door_is_found_in_the_building_it_was_written_for() {
    for (name, step) in [("osm/ajou_campus.osm", 1), ("osm/monaco.osm.pbf", 5)] {
        let Some((mut data, map)) = open(name) else {
            continue;
        };
        let named = |i: &usize| {
            let name = map.buildings[*i].name.clone()?;
            let known = locate(
                &map,
                &Address {
                    building: name.clone(),
                    unit: None,
                },
            );
            (known == Location::Building(*i)).then(|| Address::new(name, "unit 77"))
        };
        let addresses: Vec<_> = (0..map.buildings.len())
            .filter_map(|i| Some((i, named(&i)?)))
            .step_by(step)
            .collect();
        let start = Instant::now();
        for (i, address) in &addresses {
            let building = &map.buildings[*i];
            let at = building.polygon.interior_point();
            add_entrance(&mut data, &map.projection, building.element, at, address).unwrap();
        }
        eprintln!(
            "{name}: {} doors written in {:?}",
            addresses.len(),
            start.elapsed()
        );
        let edited = OsmMap::new(&data, map.projection.georeference());
        for (i, address) in &addresses {
            let found = locate(&edited, address);
            assert!(
                matches!(found, Location::Unit { building, .. } if building == *i),
                "{address}: {found:?}"
            );
        }
        let public = OsmMap::new(&without_doors(&data), map.projection.georeference());
        assert_eq!(public.buildings.len(), map.buildings.len());
        assert!(public.entrances.is_empty());
    }
}
