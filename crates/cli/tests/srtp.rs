//! `openbench srtp`: how many instructions a planner understands.

mod common;

use common::Place;

const DOOR: &str = r#"{"building": "building3", "unit": "unit1"}"#;

#[test]
fn planners_are_scored_by_language_and_difficulty() {
    let scores = Place::new()
        .openbench("srtp --split development --json")
        .succeeded()
        .json();
    assert_eq!(scores["planner"], "grammar");
    let of = |share: &serde_json::Value| share["instructions"].as_u64().unwrap();
    for group in ["languages", "difficulties"] {
        let sum: u64 = scores[group].as_object().unwrap().values().map(of).sum();
        assert_eq!(sum, of(&scores["all"]), "{group}");
    }
    let table = Place::new()
        .openbench("srtp --split development")
        .succeeded()
        .stdout
        .clone();
    let hard = Place::new()
        .openbench("srtp --split development --difficulty hard --json")
        .succeeded()
        .json();
    assert_eq!(of(&hard["all"]), of(&scores["difficulties"]["hard"]));
    for word in [
        "all",
        "hard",
        "ja",
        "95 % interval",
        "The paper's table",
        "not run here",
    ] {
        assert!(table.contains(word), "{word} in {table}");
    }
}

#[test]
fn instructions_of_ones_own_are_scored_and_what_was_misunderstood_is_told() {
    let place = Place::new();
    let line = |instruction: &str| {
        format!(r#"{{"instruction": "{instruction}", "deliveries": [{DOOR}]}}"#)
    };
    place.file(
        "mine.jsonl",
        line("Box to unit 1, building 3") + "\n" + &line("Box to unit 2, building 4"),
    );
    place.file(
        "mine.json",
        format!("[{}]", line("Box to unit 1, building 3")),
    );
    let scores = place
        .openbench("srtp --data mine.jsonl --json")
        .succeeded()
        .json();
    assert_eq!(
        (&scores["all"]["instructions"], &scores["all"]["right"]),
        (&2.into(), &1.into())
    );
    assert_eq!(scores["wrong"][0]["planned"][0]["building"], "building4");
    assert_eq!(
        place
            .openbench("srtp --data mine.json --json")
            .succeeded()
            .json()["all"]["srtp"],
        1.0
    );
}

#[test]
fn files_that_are_none_are_refused_with_their_place() {
    let place = Place::new();
    place.file(
        "bad.jsonl",
        format!("{{\"instruction\": \"x\", \"deliveries\": [{DOOR}]}}\n{{\"instruction\": 3}}\n"),
    );
    place
        .openbench("srtp --data bad.jsonl")
        .refused_with(&["bad.jsonl:2", "instruction"]);
    place
        .openbench("srtp --data none.jsonl")
        .refused_with(&["none.jsonl"]);
    place
        .openbench("srtp --split test --data bad.jsonl")
        .refused_with(&["--split", "--data"]);
    place
        .openbench("srtp --planner parrot")
        .refused_with(&["parrot", "grammar"]);
    place
        .openbench("srtp --planner grammar --bare")
        .refused_with(&["grammar", "chat model"]);
    place
        .openbench("srtp --planner local:no-such-model")
        .refused_with(&["local:no-such-model"]);
}
