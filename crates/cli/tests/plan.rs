//! `openbench plan`: always JSON; exit code 1 where something cannot be delivered.

mod common;

use common::Ran;
use common::endpoint::reader_that_says;
use common::town::{NOBODY, town};
use serde_json::{Value, json};

fn plan(instruction: &str) -> Ran {
    town().openbench_with(&["plan", "--map", "town.osm", instruction])
}

fn doors(plan: &Value) -> Vec<String> {
    let delivery = |d: &Value| {
        format!(
            "{} {}",
            d["building"].as_str().unwrap(),
            d["unit"].as_str().unwrap_or("-")
        )
    };
    plan["deliveries"]
        .as_array()
        .unwrap()
        .iter()
        .map(delivery)
        .collect()
}

#[test]
fn a_plan_has_the_keys_that_programs_read() {
    let expected = json!({
        "planner": "grammar",
        "deliveries": [{
            "instruction_index": 0,
            "item": "a box",
            "building": "building1",
            "unit": "unit1",
            "steps": [{ "mode": "navigate", "target": "building1" }, { "mode": "explore",
            "target": "unit1" }],
            "confidence": 1.0,
            "problem": null
        }]
    });
    assert_eq!(
        plan("Bring a box to unit1, building1.").succeeded().json(),
        expected
    );
}

#[test]
fn the_order_that_is_asked_for_is_kept() {
    let ran = plan("Bring a box to unit2, building2, then a bag to unit1, building1.");
    assert_eq!(
        doors(&ran.succeeded().json()),
        ["building2 unit2", "building1 unit1"]
    );
}

#[test]
fn several_items_for_one_door_are_one_delivery() {
    let ran = plan("Bring a box to unit1, building1. Bring a letter to unit1, building1.");
    assert_eq!(doors(&ran.succeeded().json()), ["building1 unit1"]);
}

#[test]
fn a_building_that_the_map_lacks_is_a_problem_of_its_delivery() {
    let ran = plan("A box to unit1, building7, and a bag to unit2, building2.");
    let plan = ran.json();
    let problem_of = |building: &str| {
        plan["deliveries"]
            .as_array()
            .unwrap()
            .iter()
            .find(|d| d["building"] == building)
            .unwrap()["problem"]
            .clone()
    };
    assert_eq!((ran.code, problem_of("building2")), (1, Value::Null));
    let problem = problem_of("building7");
    assert!(
        problem.as_str().unwrap().contains("building1, building2"),
        "{problem}"
    );
}

#[test]
fn what_is_no_instruction_is_an_empty_plan_and_said() {
    for instruction in ["The weather is fine today.", "", "🦀", "unit unit unit"] {
        let ran = plan(instruction);
        assert_eq!(
            (ran.code, &ran.json()["deliveries"]),
            (1, &json!([])),
            "{instruction}"
        );
        assert!(
            ran.stderr.contains("name a building and a unit"),
            "{}",
            ran.stderr
        );
    }
}

#[test]
fn a_long_instruction_is_no_trouble_and_one_too_long_is_said() {
    let ran = plan(&"Bring a box to unit1, building1. ".repeat(150));
    assert_eq!(doors(&ran.succeeded().json()), ["building1 unit1"]);
    let ran = plan(&"Bring a box to unit1, building1. ".repeat(2000));
    assert!(
        ran.code == 1 && ran.stderr.contains("20,000 characters"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_planner_out_of_reach_is_a_problem_that_names_its_address() {
    let ran = town().openbench(&format!("plan --map town.osm --planner {NOBODY} Hello"));
    assert_eq!((ran.code, &ran.json()["deliveries"]), (1, &json!([])));
    assert!(ran.stderr.contains("127.0.0.1:9"), "{}", ran.stderr);
}

#[test]
fn a_chat_model_that_talks_nonsense_is_a_problem() {
    let ran = town().openbench(&format!(
        "plan --map town.osm --planner {} Hello",
        reader_that_says("Gladly!")
    ));
    assert_eq!(
        (ran.code, &ran.json()["deliveries"]),
        (1, &json!([])),
        "{}",
        ran.stderr
    );
}

#[test]
fn an_unknown_planner_is_refused() {
    town()
        .openbench("plan --map town.osm --planner oracle Hello")
        .refused_with(&["oracle", "grammar"]);
}

#[test]
fn published_maps_are_planned_on() {
    for world in ["small", "medium"] {
        let Some(map) = common::shared_data(&format!("openbench/{world}/{world}.osm")) else {
            return;
        };
        let map = map.display().to_string();
        let ran = town().openbench_with(&[
            "plan",
            "--map",
            &map,
            "Please deliver this box into unit1, building3.",
        ]);
        assert_eq!(
            doors(&ran.succeeded().json()),
            ["building3 unit1"],
            "{world}"
        );
    }
}

#[test]
fn a_campus_is_planned_on_by_the_names_of_its_buildings() {
    let Some(map) = common::shared_data("osm/ajou_campus.osm") else {
        return;
    };
    let map = map.display().to_string();
    let ran = town().openbench_with(&[
        "plan",
        "--map",
        &map,
        "Take a parcel to unit 2 of Yulgok Hall.",
    ]);
    assert_eq!(doors(&ran.succeeded().json()), ["율곡관 unit2"]);
}
