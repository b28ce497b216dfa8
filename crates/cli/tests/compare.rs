//! Several seeds, and systems beside each other. Yardsticks drive, since they need no models.

mod common;

use common::Place;
use common::town::{HERE, town};

/// Two doors and three episodes, with annotations.
const DELIVERIES: &str = r#"{"instruction": "A box to unit1, building1.", "deliveries": [{"building": "building1", "unit": "unit1"}]}
{"instruction": "A bag to unit2, building2.", "deliveries": [{"building": "building2", "unit": "unit2"}]}
{"instruction": "To unit1, building1, then to unit2, building2.", "deliveries": [{"building": "building1", "unit": "unit1"}, {"building": "building2", "unit": "unit2"}], "before": [[0, 1]]}
"#;

fn place() -> Place {
    let place = town();
    place.file("three.jsonl", DELIVERIES);
    place
}

fn drive(place: &Place, more: &str) -> common::Ran {
    place.openbench(&format!(
        "{HERE} --deliveries three.jsonl --record none {more}"
    ))
}

#[test]
fn the_means_over_seeds_are_written_and_seeds_that_are_done_are_kept() {
    let place = place();
    let ran = drive(&place, "--agent omniscient --seeds 3..5 --out runs --json");
    let means = ran.succeeded().json();
    assert_eq!(means["seeds"], serde_json::json!([3, 4, 5]));
    assert_eq!(means["clustered_by"], "episode");
    let measures = means["measures"].as_array().unwrap();
    let success = measures.iter().find(|m| m["name"] == "sr_2m").unwrap();
    assert_eq!(success["mean"], 1.0);
    assert_eq!(success["runs"], serde_json::json!([1.0, 1.0, 1.0]));
    assert_eq!(place.json("runs/means.json"), means);
    assert_eq!(place.json("runs/seed-4/results.json")["seed"], 4);
    // Output that is not a terminal gets a line for each delivery.
    let line = "3 of 3 episodes: 2.1 unit2, building2: delivered";
    assert!(ran.stderr.contains(line), "{}", ran.stderr);

    // The means are verified with the runs.
    let verified = place.openbench("verify runs");
    let said = &verified.succeeded().stdout;
    assert!(
        said.contains("seed-5: 3 episodes") && said.contains("the means of"),
        "{said}"
    );
    let text = place.read("runs/means.json");
    place.file(
        "runs/means.json",
        text.replacen("\"mean\": 1.0", "\"mean\": 0.9", 1),
    );
    let altered = place.openbench("verify runs");
    assert_eq!(altered.code, 1, "{}", altered.stderr);
    let why = "means.json is not what the run gives";
    assert!(altered.stderr.contains(why), "{}", altered.stderr);
    place.file("runs/means.json", text);

    let again = drive(&place, "--agent omniscient --seeds 4..6 --out runs");
    again.succeeded();
    assert!(again.stderr.contains("seed 4 is done already"));
    assert!(again.stderr.contains("seed 5 is done already"));
    assert!(!again.stderr.contains("seed 6 is done already"));
    // What is done is kept, whatever was left of another seed.
    let again = drive(
        &place,
        "--agent omniscient --seeds 4..4 --out runs --discard",
    );
    assert!(again.succeeded().stderr.contains("seed 4 is done already"));
    // Another agent in the same folder is another run.
    let other = "--agent straight-line --seeds 4..4 --out runs";
    drive(&place, other).refused_with(&["seed-4", "its agent is omniscient", "--discard"]);
    assert_eq!(
        place.json("runs/seed-4/results.json")["agent"],
        "omniscient"
    );
    let other = drive(&place, &format!("{other} --discard"));
    assert!(!other.succeeded().stderr.contains("is done already"));
    assert_eq!(
        place.json("runs/seed-4/results.json")["agent"],
        "straight-line"
    );
    place
        .openbench("compare runs")
        .refused_with(&["several agents or settings"]);
    // A single run would be taken for all seeds.
    drive(&place, "--agent omniscient --out single").succeeded();
    drive(&place, "--agent omniscient --seeds 1..2 --out single")
        .refused_with(&["single has a single run"]);
    drive(&place, "--agent omniscient --out runs").refused_with(&["runs of several seeds"]);
    assert!(!place.path("runs/results.json").exists());
}

#[test]
fn systems_are_compared_and_what_they_were_told_is_said() {
    let place = place();
    for agent in ["omniscient", "random"] {
        let words = format!("--agent {agent} --seeds 0..1 --out {agent}");
        let said = drive(&place, &words);
        let told = &said.succeeded().stdout;
        assert!(
            told.contains(&format!("{agent}: {agent}, 2 runs of town")),
            "{told}"
        );
        assert!(told.contains("this run is a yardstick"), "{told}");
        let means = place.json(&format!("{agent}/means.json"));
        assert_eq!(means["system"]["agent"], *agent);
    }
    let ran = place.openbench("compare omniscient random");
    let text = &ran.succeeded().stdout;
    for part in [
        "A  omniscient: omniscient, 2 runs of town",
        "this run is a yardstick",
        "only A succeeded",
        "McNemar p =",
        "whole\nepisodes are resampled",
        "2 episodes cannot show a difference at 5 %; it takes 6 at least",
        "is found with 80 % probability",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let json = place.openbench("compare random omniscient random --json");
    let json = json.succeeded().json();
    let rows = json["measures"].as_array().unwrap();
    let success = rows.iter().find(|row| row["name"] == "sr_2m").unwrap();
    assert_eq!(success["means"][1], 1.0);
    assert_eq!(success["differences"][0]["pairs"], 4);
    assert_eq!(success["differences"][1]["mean"], 0.0);
    assert_eq!(json["tests"].as_array().unwrap().len(), 2);
    // One alone says how many episodes a comparison takes.
    let alone = place.openbench("compare omniscient --points 5 --json");
    assert!(alone.succeeded().json()["to_tell"]["pairs"].as_u64() > Some(50));
}

#[test]
fn what_did_not_run_the_same_is_not_compared() {
    let place = place();
    drive(&place, "--agent omniscient --seed 1 --out one").succeeded();
    drive(&place, "--agent omniscient --seed 2 --out two").succeeded();
    let refused = place.openbench("compare one two");
    refused.refused_with(&["two has no run of suite town with seed 1"]);
    place
        .openbench("compare one nowhere")
        .refused_with(&["nowhere", "no results.json"]);
    place
        .openbench("compare . one")
        .refused_with(&["has no run"]);
    std::fs::create_dir(place.path("both")).unwrap();
    for copy in ["a", "b"] {
        std::fs::create_dir(place.path(&format!("both/{copy}"))).unwrap();
        place.file(
            &format!("both/{copy}/results.json"),
            place.read("one/results.json"),
        );
    }
    place
        .openbench("compare both")
        .refused_with(&["two runs of suite town with seed 1"]);
    place.file("edited.json", "{}");
    place
        .openbench("compare edited.json")
        .refused_with(&["edited.json"]);
}

#[test]
fn yardsticks_say_what_they_are_and_have_no_settings() {
    let place = place();
    let ran = drive(&place, "--agent omniscient --out one");
    let text = &ran.succeeded().stdout;
    assert!(text.starts_with("note     the agent was told what no robot can know"));
    let report = place.read("one/report.html");
    assert!(report.contains("the agent was told what no robot can know"));
    let refused = drive(&place, "--agent random --set speed=1 --out none");
    refused.refused_with(&["speed", "the agent random has no settings"]);
    place.openbench("verify one --agent").succeeded();
}

#[test]
fn plates_in_view_are_read_without_a_model() {
    let place = place();
    let ran = drive(&place, "--set reader=truth:8 --out one --json");
    let results = ran.succeeded().json();
    assert_eq!(
        results["metrics"]["sr_2m"], 1.0,
        "{}",
        results["deliveries"]
    );
    assert_eq!(results["provenance"]["uses_truth"], true);
    assert_eq!(results["settings"]["reader"]["value"], "truth:8");
    let refused = drive(&place, "--set reader=truth:tall --out two");
    refused.refused_with(&["tall", "pixels above 0"]);
}
