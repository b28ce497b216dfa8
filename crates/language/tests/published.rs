//! The published instruction files and the project's own list in six languages, if the folder
//! `../shared/data` exists.

#[path = "../../skips.rs"]
mod skips;
mod support;

use std::path::Path;

use openbench_core::{Address, MapPoint};
use openbench_language::{GrammarPlanner, PlanRequest, Planner};
use openbench_osm::{OsmData, OsmMap};
use serde::Deserialize;
use skips::shared_data;
use support::{Flat, Straight, doors, numbered, plan};

/// Writes to standard error even if the test passes.
fn note(text: &str) {
    let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{text}\n").as_bytes());
}

fn open(path: &Path) -> OsmMap {
    let data = OsmData::read(path).unwrap();
    let georeference = openbench_osm::default_georeference(&data).unwrap();
    OsmMap::new(&data, georeference)
}

#[derive(Deserialize)]
struct Case {
    lang: String,
    instruction: String,
    deliveries: Vec<Address>,
}

#[test]
fn instructions_in_six_languages() {
    let Some(path) = shared_data("language/instructions.json") else {
        return;
    };
    let cases: Vec<Case> = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert!(cases.len() >= 20);
    let planner = GrammarPlanner::new();
    for map in [numbered(12), numbered(0)] {
        for case in &cases {
            let plan = plan(&planner, &map, &Flat, &case.instruction).unwrap();
            let found: Vec<Address> = plan.deliveries.iter().map(|d| d.address()).collect();
            assert_eq!(
                found, case.deliveries,
                "{}: {}",
                case.lang, case.instruction
            );
        }
    }
}

#[test]
fn published_instruction_files() {
    let singles =
        "building11/unit3 building6/unit1 building7/unit2 building11/unit2 building11/unit1";
    // As the crow flies from the origin to the buildings' middles; the published truths, which are
    // matched by door, stand in other orders.
    let sequence =
        "building7/unit2 building11/unit3 building11/unit2 building11/unit1 building6/unit1";
    let small = "building3/unit1 building2/unit1 building1/unit1 building1/unit1 building2/unit1";
    for (world, file, wanted) in [
        ("medium", "delivery_instructions_medium.txt", singles),
        ("medium", "delivery_instructions_medium2.txt", sequence),
        ("small", "delivery_instructions_small.txt", small),
        (
            "small",
            "delivery_instructions_small2.txt",
            "building2/unit1 building1/unit1 building3/unit1",
        ),
    ] {
        let Some(folder) = shared_data(&format!("openbench/{world}")) else {
            return;
        };
        let map = open(&folder.join(format!("{world}.osm")));
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let plan_line = |line: &str| {
            let plan = plan(&GrammarPlanner::new(), &map, &Straight, line).unwrap();
            assert!(
                plan.deliveries.iter().all(|d| d.problem.is_none()),
                "{line}"
            );
            doors(&plan)
        };
        let found: Vec<String> = text
            .lines()
            .filter(|l| !l.trim().is_empty())
            .map(plan_line)
            .collect();
        assert_eq!(found.join(" "), wanted, "{file}");
    }
}

/// Every building of a real map with a name of its own is found by that name.
#[test]
fn names_of_real_places_are_found() {
    for file in ["osm/ajou_campus.osm", "osm/monaco.osm.pbf"] {
        let Some(path) = shared_data(file) else {
            return;
        };
        let map = open(&path);
        let planner = GrammarPlanner::new();
        let (mut wrong, start) = (Vec::new(), std::time::Instant::now());
        let mut asked = 0_usize;
        for building in &map.buildings {
            let Some(name) = building
                .name
                .as_deref()
                .filter(|_| building.tags.has("name"))
            else {
                continue;
            };
            if map
                .buildings
                .iter()
                .filter(|b| b.name.as_deref() == Some(name))
                .count()
                > 1
            {
                continue;
            }
            asked += 1;
            let instruction = format!("Please take this parcel to unit 2 of {name}.");
            let found = plan(&planner, &map, &Flat, &instruction)
                .map(|p| doors(&p))
                .unwrap_or_default();
            if found != format!("{name}/unit2") {
                wrong.push(format!("{name} -> {found}"));
            }
            if asked >= 150 {
                break;
            }
        }
        let each = start.elapsed() / u32::try_from(asked.max(1)).unwrap();
        note(&format!(
            "{file}: {each:?} an instruction, {} buildings",
            map.buildings.len()
        ));
        assert!(
            asked > 50 && wrong.len() * 20 <= asked,
            "{file}: {} of {asked}: {wrong:#?}",
            wrong.len()
        );
    }
}

/// The grammar alone takes well under a millisecond; each plan collects the map's names anew.
#[test]
fn planning_takes_little_time() {
    let map = numbered(14);
    let planner = GrammarPlanner::new();
    let text = "Please deliver this item into unit3, building11. \
                Please deliver this package into unit1, building6.";
    let request = PlanRequest {
        instruction: text,
        map: &map,
        start: MapPoint::default(),
        times: &Flat,
    };
    let start = std::time::Instant::now();
    for _ in 0..100 {
        planner.plan(&request).unwrap();
    }
    let each = start.elapsed() / 100;
    note(&format!("{each:?} an instruction"));
    assert!(each.as_millis() < 5, "{each:?}");
}
