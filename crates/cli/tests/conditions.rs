//! `openbench run --condition`: what makes runs harder is drawn, recorded and verified.

mod common;

use common::{Place, Ran};
use openbench_bench::worlds::hashes::hash_bytes;
use serde_json::Value;

/// One delivery in the smallest built-in world.
const SUITE: &str = "name = 'one'\n[world.builtin]\nname = 'small'\nseed = 1\n\
    [[episodes]]\ninstruction = 'Box to unit 1, building 3.'\n\
    [[episodes.deliveries]]\nbuilding = 'building3'\nunit = 'unit1'\n";

fn place() -> Place {
    let place = Place::new();
    place.file("one.toml", SUITE);
    place
}

/// Drives by the truth, so that a run takes a second.
fn run(place: &Place, more: &str) -> Ran {
    place.openbench(&format!(
        "run one.toml --agent omniscient --record none --json {more}"
    ))
}

#[test]
fn what_is_drawn_is_in_the_results_and_verified() {
    let place = place();
    let conditions = "--condition map=city --condition start=5m";
    let results = run(&place, &format!("{conditions} --seed 3 --out r"))
        .succeeded()
        .json();
    assert_eq!(
        results["conditions"],
        serde_json::json!({"map": "city", "start": "5m"})
    );
    let drawn = &results["drawn_map"];
    assert_eq!(drawn["buildings"], 3);
    assert!(drawn["building_shift_m"].as_f64().unwrap() > 0.1, "{drawn}");
    assert!(drawn["frame"]["x"].as_f64().unwrap() != 0.0, "{drawn}");
    // The public map has an origin of its own, whole metres away.
    let moved = |axis: &str| {
        let public = results["public_frame"][axis].as_f64().unwrap();
        public - drawn["frame"][axis].as_f64().unwrap()
    };
    assert!(moved("x") != 0.0 && (moved("x") - moved("x").round()).abs() < 1e-6);
    assert_eq!(moved("yaw"), 0.0);
    let told = &results["episodes"][0]["start"]["pose"];
    assert_eq!(told["covariance"][0][0], 25.0, "{told}");
    // The world is the right one still.
    assert_eq!(results["deliveries"][0]["success_2m"], true);
    place.openbench("verify r").succeeded();
    // A number that the suite's level does not have.
    let other = place.read("r/run.json").replace("\"city\"", "\"good\"");
    place.file("r/run.json", other);
    assert_ne!(place.openbench("verify r").code, 0);
}

#[test]
fn computing_costs_time_that_is_recorded_and_repeats() {
    let place = place();
    let charged = |out: &str| {
        let words = format!("run one.toml --record none --json --seed 4 --out {out}");
        let words = format!("{words} --set reader=truth --condition compute=charged");
        place.openbench(&words).succeeded().json()
    };
    let results = charged("a");
    let computing = &results["episodes"][0]["computing"];
    let number = |key: &str| computing[key].as_f64().unwrap();
    assert!(number("busy_s") > 5.0, "{computing}");
    assert!(number("latest_s") > 0.4, "{computing}");
    assert!(computing["work"]["registration"].as_u64().unwrap() > 100);
    assert!(computing["work"]["reading"].as_u64().unwrap() > 0);
    assert_eq!(results["deliveries"][0]["success_2m"], true);
    place.openbench("verify a --agent").succeeded();
    let twice =
        place.openbench("run one.toml --condition compute=charged --set thinking=charged --out b");
    assert_eq!(twice.code, 2);
    assert!(twice.stderr.contains("charged twice"), "{}", twice.stderr);
}

#[test]
fn all_conditions_together_repeat_on_any_number_of_threads() {
    let place = place();
    // A second episode, so that there is something to do for two threads.
    let (head, episode) = SUITE.split_once("[[episodes]]").unwrap();
    place.file(
        "one.toml",
        format!("{head}[[episodes]]{episode}[[episodes]]{episode}"),
    );
    let all = "map=city start=5m robot=worn camera=cheap light=night weather=rain lidar=real \
               doors=drawn plates=real scenery=varied compute=charged";
    let conditions: String = all
        .split_whitespace()
        .map(|word| format!("--condition {word} "))
        .collect();
    let run = |jobs: u32| {
        let words = format!("{conditions} --seed 3 --jobs {jobs} --out r{jobs}");
        run(&place, &words).succeeded().json()
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one["conditions"].as_object().unwrap().len(), 11);
    for key in ["episodes", "deliveries", "doors"] {
        assert_eq!(one[key], two[key], "{key}");
    }
    assert_eq!(one["provenance"]["hashes"], two["provenance"]["hashes"]);
    assert!(one["deliveries"][0]["path_m"].as_f64().unwrap() > 10.0);
    place.openbench("verify r2 --agent").succeeded();
}

#[test]
fn each_seed_has_a_map_of_its_own() {
    let place = place();
    run(&place, "--condition map=good --seeds 1..2 --out both").succeeded();
    let map = |seed: u32| -> Value {
        let results = place.json(&format!("both/seed-{seed}/results.json"));
        results["provenance"]["hashes"]["map"].clone()
    };
    assert_ne!(map(1), map(2));
    let again = run(&place, "--condition map=good --seed 2 --out one")
        .succeeded()
        .json();
    assert_eq!(again["provenance"]["hashes"]["map"], map(2));
    place.openbench("verify both").succeeded();
}

#[test]
fn suites_have_conditions_and_the_command_line_changes_them() {
    let place = place();
    // Tables come last in TOML, so the map's follows the suite's own keys.
    place.file(
        "hard.toml",
        format!("start = 'block'\n{SUITE}[map]\nlevel = 'poor'\nmissing = 0.0\n"),
    );
    let words =
        "run hard.toml --agent omniscient --record none --json --condition start=10m --out r";
    let results = place.openbench(words).succeeded().json();
    assert_eq!(results["conditions"]["start"], "10m");
    assert_eq!(results["conditions"]["map"]["missing"], 0.0);
    assert_eq!(results["conditions"]["map"]["shift_m"], 4.0);
}

#[test]
fn an_agent_that_needs_a_pose_says_so_and_finds_it_on_the_map() {
    let place = place();
    let delivery = |fixes: &str| {
        let words = format!(
            "run one.toml --record none --json --condition start=block --set fixes={fixes} --out r"
        );
        place.openbench(&words).succeeded().json()["deliveries"][0].clone()
    };
    let without = delivery("none");
    assert_eq!(without["failure"], "lost", "{without}");
    let detail = without["failure_detail"].as_str().unwrap();
    assert!(detail.contains("within 75 m"), "{detail}");
    let found = delivery("osm");
    assert_eq!(found["success_2m"], true, "{found}");
}

#[test]
fn what_there_is_not_is_refused_with_what_there_is() {
    let place = place();
    for (condition, expected) in [
        ("map=village", "write one of exact, good, city, poor"),
        ("maps=city", "there are map, start"),
        ("map.shift_m=-1", "give a number from 0 to 100"),
        ("map.missing=1.5", "give a number from 0 to 1"),
        ("map.shift=1", "there is no `shift`"),
        ("map", "KEY=VALUE"),
        ("map.missing=1", "none of the map's 3 buildings"),
    ] {
        let spare = if condition == "map.missing=1" {
            "--condition map.spares_ordered=false"
        } else {
            ""
        };
        let ran = run(&place, &format!("{spare} --condition {condition}"));
        assert_eq!(ran.code, 2, "{condition}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{condition}: {}", ran.stderr);
    }
}

#[test]
fn the_wrong_map_can_be_seen_and_kept() {
    let place = place();
    let words = "--condition map.shift_m=3 --seed 3";
    let drawn = format!("world map one.toml {words} --out map.svg --osm wrong.osm");
    let said = place.openbench(&drawn).succeeded().stdout.clone();
    assert!(said.contains("the public map is moved by"), "{said}");
    assert!(place.read("map.svg").contains("<path class=\"public\""));
    // The map that a run with that seed gives to its agents.
    let results = run(&place, &format!("{words} --out r")).succeeded().json();
    let hash = results["provenance"]["hashes"]["map"].as_str().unwrap();
    assert_eq!(hash, hash_bytes(place.read("wrong.osm").as_bytes()));
    let refused = place.openbench("world map one.toml --out map.png");
    refused.refused_with(&["map.png", ".svg"]);
}

#[test]
fn plates_as_in_streets_are_drawn_recorded_and_verified() {
    let place = place();
    let conditions = "--condition plates=real --condition plates.missing=0";
    let results = run(&place, &format!("{conditions} --seed 3 --out r"))
        .succeeded()
        .json();
    let drawn = &results["drawn_plates"];
    assert_eq!(drawn["doors"], 8, "{drawn}");
    assert_eq!(drawn["missing"], 0, "{drawn}");
    assert_eq!(drawn["test_typefaces"], false, "{drawn}");
    place.openbench("verify r").succeeded();
    let plain = run(&place, "--seed 3 --out p").succeeded().json();
    assert_eq!(plain["drawn_plates"], Value::Null);
    let (real, plain) = (&results["provenance"], &plain["provenance"]);
    assert_ne!(real["hashes"]["world"], plain["hashes"]["world"]);
    assert_eq!(real["hashes"]["map"], plain["hashes"]["map"]);
}

#[test]
fn streets_that_differ_are_drawn_recorded_and_verified() {
    let place = place();
    let results = run(&place, "--condition scenery=varied --seed 3 --out r")
        .succeeded()
        .json();
    let drawn = &results["drawn_scenery"];
    assert!(drawn["clutter"].as_object().unwrap().len() > 2, "{drawn}");
    assert_eq!(results["conditions"]["scenery"], "varied");
    place.openbench("verify r").succeeded();
    let plain = run(&place, "--seed 3 --out p").succeeded().json();
    assert_eq!(plain["drawn_scenery"], Value::Null);
    let (varied, plain) = (&results["provenance"], &plain["provenance"]);
    assert_ne!(varied["hashes"]["world"], plain["hashes"]["world"]);
    assert_eq!(varied["hashes"]["map"], plain["hashes"]["map"]);
    let words = "world show small --condition scenery=varied --out v.jpg";
    place.openbench(words).succeeded();
    let refused = place.openbench("run one.toml --condition scenery.clutter=2 --out x");
    refused.refused_with(&["clutter = 2", "from 0 to 1"]);
}

#[test]
fn drawn_doors_are_counted_where_the_map_has_all_of_them() {
    let place = place();
    let results = run(&place, "--condition doors=drawn --seed 3 --out r");
    let drawn = &results.succeeded().json()["drawn_doors"];
    assert_eq!(
        (&drawn["mapped"], &drawn["doors"]),
        (&8.into(), &0.into()),
        "{drawn}"
    );
    place.openbench("verify r").succeeded();
    let plain = run(&place, "--seed 3 --out p").succeeded().json();
    assert_eq!(plain["drawn_doors"], Value::Null);
}
