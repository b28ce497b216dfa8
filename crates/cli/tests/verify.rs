//! `openbench verify`: a run repeats to the bit, and a run that was changed does not.

mod common;

use common::Place;
use common::endpoint::{NOTHING, UNIT_1, endpoint, reader_that_says, says};
use common::town::{deliver, town};
use serde_json::Value;

/// A finished run in `run`.
fn a_run() -> Place {
    let place = town();
    place.file(
        "one.txt",
        "To unit1, building1.\nA box to unit1, building1.\n",
    );
    let words = format!(
        "--deliveries one.txt --targets planner --out run --record none --set reader={}",
        reader_that_says(UNIT_1)
    );
    deliver(&place, &words).succeeded();
    place
}

/// Changes the recorded actions of the second episode.
fn tamper(place: &Place, change: impl FnOnce(&mut Value)) {
    let mut actions = place.json("run/episodes/001.actions.json");
    change(&mut actions);
    place.file("run/episodes/001.actions.json", actions.to_string());
}

#[test]
fn a_run_repeats_to_the_bit() {
    let place = a_run();
    let ran = place.openbench("verify run");
    assert_eq!(
        ran.succeeded().stdout,
        "run: 2 episodes: files and actions agree\n"
    );
}

#[test]
fn a_run_that_ends_before_any_time_is_simulated_verifies() {
    let place = town();
    let line = r#"{"instruction": "la la la", "deliveries": [{"building": "building1", "unit": "unit1"}]}"#;
    place.file("la.jsonl", line);
    let reader = reader_that_says(UNIT_1);
    let words = format!("--deliveries la.jsonl --out run --record none --set reader={reader}");
    deliver(&place, &words).succeeded();
    assert_eq!(
        place.json("run/results.json")["metrics"]["sim_seconds"],
        0.0
    );
    assert_eq!(place.json("run/results.json")["metrics"]["srtp"], 0.0);
    place.openbench("verify run").succeeded();
}

#[test]
fn a_run_among_people_repeats_to_the_bit_on_any_number_of_threads() {
    let place = town();
    place.file(
        "one.txt",
        "To unit1, building1.\nA box to unit1, building1.\n",
    );
    let reader = reader_that_says(UNIT_1);
    let run = |out: &str, jobs: u32| {
        let words = format!(
            "--deliveries one.txt --targets planner \
             --pedestrians 6 --seed 5 --jobs {jobs} --out {out} --json --set \
            reader={reader}"
        );
        let mut results = deliver(&place, &words).succeeded().json();
        results["settings"] = Value::Null;
        for key in ["wall_seconds", "real_time_factor"] {
            results["metrics"][key] = Value::Null;
        }
        results["models"]["latency_ms"] = Value::Null;
        results
    };
    let results = run("run", 1);
    assert_eq!(results, run("again", 2));
    assert_eq!(results["traffic"]["pedestrians"], 6);
    let encounters = &results["metrics"]["encounters"];
    assert!(
        encounters["nearest_person_m"]
            .as_f64()
            .is_some_and(|m| m < 20.0),
        "{encounters}"
    );
    place.openbench("verify run").succeeded();
    let log = std::fs::read(place.path("run/episodes/000.mcap")).unwrap();
    assert!(
        log.windows(20).any(|w| w == b"/ground_truth/people"),
        "who walked where is in the log"
    );
}

#[test]
fn changed_actions_differ_in_the_episode_that_was_changed() {
    let place = a_run();
    tamper(&place, |actions| {
        actions["driven"][0]["velocity"]["linear"] = 0.123.into()
    });
    let ran = place.openbench("verify run");
    assert_eq!((ran.code, ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
    assert!(ran.stderr.contains("episode 1 differs"), "{}", ran.stderr);
}

#[test]
fn a_step_left_out_differs() {
    let place = a_run();
    tamper(&place, |actions| {
        drop(actions["driven"].as_array_mut().unwrap().pop())
    });
    assert_eq!(place.openbench("verify run").code, 1);
}

#[test]
fn a_changed_world_differs() {
    let place = a_run();
    place.file(
        "town.world",
        place
            .read("town.world")
            .replace("<size>3.6 3.6 3</size>", "<size>3.5 3.5 3</size>"),
    );
    let ran = place.openbench("verify run");
    assert_eq!(ran.code, 1, "{}{}", ran.stdout, ran.stderr);
}

#[test]
fn what_is_no_run_is_refused_with_the_file() {
    let place = a_run();
    place
        .file("run/episodes/001.actions.json", "{\"seed\": 1")
        .openbench("verify run")
        .refused_with(&["001.actions.json", "line 1"]);
    place
        .file("run/run.json", "[]")
        .openbench("verify run")
        .refused_with(&["run.json", "no record of a run"]);
}

#[test]
fn a_run_of_another_version_is_refused() {
    let place = a_run();
    let mut record = place.json("run/run.json");
    record["version"] = "0.0.1".into();
    place
        .file("run/run.json", record.to_string())
        .openbench("verify run")
        .refused_with(&["0.0.1", "version"]);
}

#[test]
fn an_agent_that_cannot_repeat_is_not_run_again() {
    let place = a_run();
    let mut record = place.json("run/run.json");
    record["cannot_repeat"] = "a person drove".into();
    place.file("run/run.json", record.to_string());
    place
        .openbench("verify run --agent")
        .refused_with(&["cannot be run again: a person drove"]);
}

#[test]
fn an_agent_repeats_what_it_did_without_its_models() {
    let place = town();
    place.file(
        "one.txt",
        "To unit1, building1.\nA box to unit1, building1.\n",
    );
    let planner = endpoint(|_, _| {
        says(
            r#"{"deliveries": [{"item": "a box", "building": "building1", "unit": "unit1"}],
                "rejected": []}"#,
        )
    });
    // Sees the plate from the fourth picture on: what it answers depends on what it was asked
    // before.
    let reader = endpoint(|number, _| says(if number < 3 { NOTHING } else { UNIT_1 }));
    let words = format!(
        "--deliveries one.txt --targets planner \
         --out run --set planner={planner} --set reader={reader} --set \
        thinking=charged"
    );
    deliver(&place, &words).succeeded();
    let ran = place.openbench("verify run --agent --jobs 2");
    assert_eq!(
        ran.succeeded().stdout,
        "run: 2 episodes: files and actions agree, and the agent repeats them\n"
    );
    let answers = place.read("run/episodes/000.models.jsonl");
    assert!(answers.lines().count() > 4, "{answers}");
    place.file(
        "run/episodes/000.models.jsonl",
        answers.replace("UNIT 1", "UNIT 7"),
    );
    let ran = place.openbench("verify run --agent");
    assert!(
        ran.code == 1 && ran.stderr.contains("record of answers"),
        "{}",
        ran.stderr
    );
}

#[test]
fn an_agent_whose_readers_stand_in_for_each_other_repeats() {
    let place = town();
    place.file("one.txt", "To unit1, building1.\n");
    // Both are asked the same about each picture; the first answers every second one.
    let fickle = endpoint(|number, _| {
        if number % 2 == 0 {
            says(NOTHING)
        } else {
            says("I see no JSON.")
        }
    });
    let sure = reader_that_says(UNIT_1);
    deliver(
        &place,
        &format!("--deliveries one.txt --targets planner --out run --set reader={fickle},{sure}"),
    )
    .succeeded();
    place.openbench("verify run --agent").succeeded();
}

#[test]
fn a_run_whose_answers_are_gone_is_not_asked_again() {
    let place = town();
    place.file("one.txt", "To unit1, building1.\n");
    let reader = reader_that_says(UNIT_1);
    deliver(
        &place,
        &format!("--deliveries one.txt --targets planner --out run --set reader={reader}"),
    )
    .succeeded();
    std::fs::remove_file(place.path("run/episodes/000.models.jsonl")).unwrap();
    let ran = place.openbench("verify run --agent");
    assert!(
        ran.code != 0 && ran.stderr.contains("record of answers"),
        "{}",
        ran.stderr
    );
}

#[test]
fn what_a_run_is_to_read_is_not_replaced_by_it() {
    let place = town();
    let reader = reader_that_says(UNIT_1);
    deliver(
        &place,
        &format!("--deliveries one.txt --targets planner --out run --set reader={reader}"),
    )
    .succeeded();
    let answers = "run/episodes/000.models.jsonl";
    deliver(
        &place,
        &format!("--deliveries one.txt --targets planner --out run --set reader=replay:{answers}"),
    )
    .refused_with(&["is replaced", "--out"]);
    assert!(place.path(answers).exists());
    deliver(
        &place,
        &format!(
            "--deliveries one.txt --targets planner --out again --set reader=replay:{answers}"
        ),
    )
    .succeeded();
    place.openbench("verify again --agent").succeeded();
}

#[test]
fn a_run_with_a_memory_repeats() {
    let place = town();
    let reader = reader_that_says(UNIT_1);
    for _ in 0..2 {
        let words = format!(
            "--deliveries one.txt --targets planner \
             --out run --memory doors.osm --set reader={reader}"
        );
        deliver(&place, &words).succeeded();
    }
    place.openbench("verify run --agent").succeeded();
}
