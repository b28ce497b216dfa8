//! `openbench run`: what it writes, what it repeats, and how a delivery fails.

mod common;

use common::endpoint::{NOTHING, UNIT_1, babbler, reader_that_says};
use common::town::{DOORS, NOBODY, deliver, prison, town, world};
use common::{Place, Ran};
use serde_json::Value;

/// One delivery in the town with a reader. Without a truth the grammar says which door is meant.
fn one(place: &Place, reader: &str, more: &str) -> Ran {
    let targets = if more.contains("--truth") {
        ""
    } else {
        "--targets planner"
    };
    deliver(
        place,
        &format!("--deliveries one.txt {targets} --set reader={reader} {more}"),
    )
}

/// The only delivery of a run that must end with exit code 0.
fn only_delivery(ran: &Ran) -> Value {
    let results = ran.succeeded().json();
    assert_eq!(
        results["deliveries"].as_array().unwrap().len(),
        1,
        "{results}"
    );
    results["deliveries"][0].clone()
}

/// Results without what depends on the machine.
fn repeatable(mut results: Value) -> Value {
    for key in ["wall_seconds", "real_time_factor"] {
        assert!(results["metrics"][key].take().as_f64().unwrap() > 0.0);
    }
    results["models"]["latency_ms"].take();
    results
}

#[test]
fn a_parcel_is_brought_to_its_door() {
    let place = town();
    let delivery = only_delivery(&one(&place, &reader_that_says(UNIT_1), "--json"));
    assert_eq!(
        (&delivery["success_2m"], &delivery["failure"]),
        (&true.into(), &Value::Null),
        "{delivery}"
    );
    let driven = delivery["path_m"].as_f64().unwrap();
    assert!(driven > 6.0 && driven < 12.0, "{delivery}");
    assert!(
        (delivery["straight_line_m"].as_f64().unwrap() - DOORS[0].0).abs() < 1e-6,
        "{delivery}"
    );
    assert!(delivery["plates_read"].as_u64().unwrap() > 0, "{delivery}");
}

#[test]
fn results_hold_every_key_that_programs_read() {
    let place = town();
    one(&place, &babbler(), "--out run").succeeded();
    let results = place.json("run/results.json");
    let has = |value: &Value, keys: &str| {
        keys.split(' ')
            .for_each(|key| assert!(value.get(key).is_some(), "{key}: {value}"))
    };
    has(
        &results,
        "suite agent seed version metrics deliveries episodes provenance settings targets sensors \
         traffic doors attribution",
    );
    let provenance = &results["provenance"];
    has(provenance, "build processor hashes models uses_truth");
    has(&provenance["build"], "commit program target");
    has(&provenance["hashes"], "world map suite");
    has(
        &results["metrics"],
        "sr_10m spl_straight sr_2m correct_unit spl lsr lspl collisions path_m sim_seconds \
        wall_seconds real_time_factor",
    );
    has(
        &results["deliveries"][0],
        "episode task instruction building unit success_10m success_2m correct_unit \
        distance_to_door_m",
    );
    has(
        &results["deliveries"][0],
        "path_m shortest_path_m straight_line_m sim_seconds collisions failure",
    );
    assert_eq!(
        (&results["suite"], &results["agent"]),
        (&"town".into(), &"open".into())
    );
    assert_eq!(
        (&results["metrics"]["lsr"], &results["metrics"]["lspl"]),
        (&Value::Null, &Value::Null)
    );
}

#[test]
fn json_on_stdout_is_what_the_file_holds() {
    let place = town();
    let printed = one(&place, &babbler(), "--json --seed 7").json();
    assert_eq!(printed, place.json("runs/latest/results.json"));
    assert_eq!(printed["seed"], 7);
}

#[test]
fn a_person_gets_a_table_and_the_way_to_the_report() {
    let ran = one(&town(), &babbler(), "--out run");
    assert!(ran.succeeded().stdout.contains("unit1"), "{}", ran.stdout);
    assert!(ran.stderr.contains("run/report.html"), "{}", ran.stderr);
}

#[test]
fn the_report_stands_alone() {
    let place = town();
    one(&place, &reader_that_says(UNIT_1), "--out run").succeeded();
    let report = place.read("run/report.html");
    for load in [
        "src=\"http",
        "src='http",
        "href=\"http",
        "url(http",
        "@import",
        "<link ",
        "src=\"//",
        "fetch(",
    ] {
        assert!(!report.contains(load), "{load}");
    }
    assert!(report.contains("unit1") && report.contains("building1") && report.contains("<svg"));
}

#[test]
fn logs_are_written_as_far_as_asked_for() {
    let place = town();
    let size = |level: &str| {
        one(
            &place,
            &babbler(),
            &format!("--out {level} --record {level}"),
        )
        .succeeded();
        std::fs::read(place.path(&format!("{level}/episodes/000.mcap"))).ok()
    };
    let (none, thin, full) = (size("none"), size("thin").unwrap(), size("full").unwrap());
    assert_eq!(none, None);
    assert!(thin.starts_with(b"\x89MCAP0\r\n") && thin.ends_with(b"\x89MCAP0\r\n"));
    assert!(full.len() > 3 * thin.len(), "{} {}", full.len(), thin.len());
}

#[test]
fn the_same_seed_gives_the_same_results_and_log() {
    let place = town();
    let reader = reader_that_says(UNIT_1);
    let run = |out: &str| {
        repeatable(one(&place, &reader, &format!("--json --seed 3 --out {out}")).json())
    };
    assert_eq!(run("a"), run("b"));
    for file in ["000.mcap", "000.osm"] {
        let read =
            |out: &str| std::fs::read(place.path(&format!("{out}/episodes/{file}"))).unwrap();
        assert!(read("a") == read("b"), "{file}");
    }
    let actions = |out: &str| {
        let mut actions = place.json(&format!("{out}/episodes/000.actions.json"));
        // The seal includes the command line, and answers have the times of the machine.
        actions["seal"].take();
        actions["files"]["models"].take();
        actions
    };
    assert!(actions("a") == actions("b"));
}

#[test]
fn another_seed_gives_another_drive() {
    let place = town();
    let reader = reader_that_says(UNIT_1);
    let path = |seed: u32| {
        only_delivery(&one(&place, &reader, &format!("--json --seed {seed}")))["path_m"].clone()
    };
    assert_ne!(path(1), path(2));
}

#[test]
fn results_do_not_depend_on_jobs() {
    let place = town();
    place.file(
        "one.txt",
        "To unit1, building1.\nTo unit2, building2.\nA box to unit1, building1.\n",
    );
    let reader = reader_that_says(UNIT_1);
    let run = |jobs: u32| repeatable(one(&place, &reader, &format!("--json --jobs {jobs}")).json());
    assert_eq!(run(1), run(2));
}

#[test]
fn what_was_found_is_remembered_with_a_memory_and_only_then() {
    let place = town();
    one(&place, &reader_that_says(UNIT_1), "--memory doors.osm").succeeded();
    assert!(
        place.read("doors.osm").contains("entrance"),
        "{}",
        place.read("doors.osm")
    );
    let blind = reader_that_says(NOTHING);
    let without = only_delivery(&one(&place, &blind, "--json"));
    assert!(
        ["door_not_found", "timeout"].contains(&without["failure"].as_str().unwrap()),
        "{without}"
    );
    let with = only_delivery(&one(&place, &blind, "--json --memory doors.osm"));
    assert_eq!(with["success_2m"], true, "{with}");
}

#[test]
fn a_sequence_is_one_episode_with_lsr() {
    let place = town();
    place.file(
        "one.txt",
        "Bring a box to unit1, building1, then a bag to unit2, building2.\n",
    );
    let results = one(&place, &babbler(), "--json").succeeded().json();
    let at: Vec<_> = results["deliveries"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| (&d["episode"], &d["task"], &d["building"]))
        .collect();
    assert_eq!(
        at,
        [
            (&0.into(), &0.into(), &"building1".into()),
            (&0.into(), &1.into(), &"building2".into())
        ]
    );
    assert_eq!(results["metrics"]["lsr"], 0.0);
}

#[test]
fn a_building_that_the_map_lacks_fails_its_delivery_alone() {
    let place = town();
    place
        .file(
            "one.txt",
            "Bring this to unit1, building99.\nBring this to unit1, building1.\n",
        )
        .file("gt.txt", "(8.2, 0.0)\n(8.2, 0.0)\n");
    let results = one(&place, &reader_that_says(UNIT_1), "--json --truth gt.txt")
        .succeeded()
        .json();
    let (lost, found) = (&results["deliveries"][0], &results["deliveries"][1]);
    assert_eq!(
        (&lost["failure"], &found["failure"]),
        (&"unknown_address".into(), &Value::Null),
        "{results}"
    );
    assert!(
        lost["failure_detail"]
            .as_str()
            .unwrap()
            .contains("building99"),
        "{lost}"
    );
}

#[test]
fn an_instruction_that_is_no_instruction_fails_as_not_understood() {
    let place = town();
    place
        .file("one.txt", "The weather is fine today.\n")
        .file("gt.txt", "(8.2, 0.0)\n");
    let delivery = only_delivery(&one(&place, &babbler(), "--json --truth gt.txt"));
    assert_eq!(delivery["failure"], "not_understood", "{delivery}");
}

#[test]
fn a_planner_out_of_reach_ends_the_run_with_its_address() {
    let more = format!("--json --set planner={NOBODY}");
    let ran = one(&town(), &reader_that_says(UNIT_1), &more);
    assert_eq!((ran.code, ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
    for part in ["127.0.0.1:9", "planner=MODEL,OTHER"] {
        assert!(ran.stderr.contains(part), "{part}: {}", ran.stderr);
    }
    // The failed episode does not count as finished: it would be continued instead of repeated.
    let place = town();
    let more = format!("--out run --set planner={NOBODY}");
    assert_eq!(one(&place, &reader_that_says(UNIT_1), &more).code, 1);
    one(&place, &reader_that_says(UNIT_1), "--out run").succeeded();
}

#[test]
fn a_listed_fallback_plans_where_the_planner_is_out_of_reach_and_is_named() {
    let place = town();
    place.file("gt.txt", "(8.2, 0.0)\n");
    let more = format!("--truth gt.txt --set planner={NOBODY},grammar");
    let reader = reader_that_says(UNIT_1);
    let results = one(&place, &reader, &format!("{more} --json"));
    assert_eq!(only_delivery(&results)["failure"], Value::Null);
    let results = results.json();
    let metrics = &results["metrics"];
    // The delivery succeeded, but not by the planner that was asked.
    assert_eq!(
        (&metrics["srtp"], &metrics["srtp_with_fallback"]),
        (&0.0.into(), &1.0.into()),
        "{metrics}"
    );
    assert_eq!(results["episodes"][0]["fallbacks"][0]["from"], "grammar");
    assert!(results["deliveries"][0]["model_calls_failed"].as_u64() > Some(0));
    let table = one(&place, &reader, &more).succeeded().stdout.clone();
    assert!(
        table.contains("another planner made a part of the plan in 1 of 1 episode (0)"),
        "{table}"
    );
    // For each delivery, too, and in the report.
    let asked = |line: &str| line.contains("to models,") && !line.contains(", 0 without an answer");
    assert!(table.lines().any(asked), "{table}");
    assert!(table.contains("doors by the planner grammar: "), "{table}");
    let report = place.read("runs/latest/report.html");
    for part in ["doors were chosen", "in vain"] {
        assert!(report.contains(part), "{part}");
    }
}

#[test]
fn a_planner_out_of_reach_fails_what_the_grammar_does_not_understand_with_its_address() {
    let place = town();
    place
        .file("one.txt", "The weather is fine today.\n")
        .file("gt.txt", "(8.2, 0.0)\n");
    let more = format!("--json --truth gt.txt --set planner={NOBODY},grammar");
    let delivery = only_delivery(&one(&place, &babbler(), &more));
    assert_eq!(delivery["failure"], "not_understood", "{delivery}");
    assert!(
        delivery["failure_detail"]
            .as_str()
            .unwrap()
            .contains("127.0.0.1:9"),
        "{delivery}"
    );
}

#[test]
fn the_judge_expects_the_door_at_the_true_position_whatever_a_planner_reads() {
    let place = town();
    // The grammar reads unit 1 of building 1, where the parcel does not belong.
    place.file("gt.txt", "(0.0, 12.2)\n");
    let results = one(&place, &reader_that_says(UNIT_1), "--json --truth gt.txt")
        .succeeded()
        .json();
    let delivery = &results["deliveries"][0];
    assert_eq!(
        (&delivery["building"], &delivery["success_10m"]),
        (&"building2".into(), &false.into()),
        "{delivery}"
    );
    assert_eq!(
        (&results["targets"], &results["metrics"]["srtp"]),
        (&"positions".into(), &0.0.into())
    );
}

#[test]
fn annotations_say_which_doors_are_meant() {
    let place = town();
    place.file(
        "one.jsonl",
        r#"{"instruction": "Bring this parcel to unit1, building1.",
            "deliveries": [{"building": "building1", "unit": "unit1"}]}"#
            .replace('\n', " "),
    );
    let reader = reader_that_says(UNIT_1);
    let words = format!("--deliveries one.jsonl --json --set reader={reader}");
    let results = deliver(&place, &words).succeeded().json();
    assert_eq!(results["targets"], "annotation");
    let written = "written beside the instructions";
    let words = format!("--deliveries one.jsonl --out run --set reader={reader}");
    let table = deliver(&place, &words).succeeded().stdout.clone();
    assert!(table.contains(&format!("targets  {written}")), "{table}");
    let report = place.read("run/report.html");
    let named = report.find(&format!("targets {written}"));
    assert!(
        named.is_some() && named < report.find("<h2"),
        "it stands above all numbers"
    );
    assert_eq!(results["metrics"]["sr_2m"], 1.0, "{results}");
}

#[test]
fn a_reader_out_of_reach_ends_the_run_with_its_address() {
    let place = town();
    let ran = one(&place, NOBODY, "--out run");
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    for part in ["127.0.0.1:9", "--set reader=MODEL,OTHER"] {
        assert!(ran.stderr.contains(part), "{part}: {}", ran.stderr);
    }
    assert!(!place.path("run/results.json").exists());
    // No failed episode is left that a later run would have to continue.
    one(&place, &reader_that_says(UNIT_1), "--out run").succeeded();
}

#[test]
fn a_reader_that_talks_nonsense_fails_the_delivery() {
    let delivery = only_delivery(&one(&town(), &babbler(), "--json"));
    assert_eq!(delivery["failure"], "reader_unavailable", "{delivery}");
}

#[test]
fn a_robot_that_is_walled_in_gives_up_with_a_cause() {
    let place = town();
    place.file("town.world", world(&prison()));
    let delivery = only_delivery(&one(&place, &reader_that_says(NOTHING), "--json"));
    let cause = delivery["failure"].as_str().unwrap();
    assert!(
        ["stuck", "no_route", "door_not_found", "timeout"].contains(&cause),
        "{delivery}"
    );
    assert_eq!(
        (&delivery["success_10m"], &delivery["shortest_path_m"]),
        (&false.into(), &Value::Null),
        "{delivery}"
    );
    assert!(
        delivery["path_m"].as_f64().unwrap() < 20.0,
        "it is still in there: {delivery}"
    );
}

#[test]
fn an_agent_that_cannot_be_made_keeps_the_results_of_the_run_before() {
    let place = town();
    one(&place, &reader_that_says(NOTHING), "--out kept").succeeded();
    let before = place.read("kept/results.json");
    one(&place, "replay:absent.jsonl", "--out kept").refused_with(&["absent.jsonl"]);
    assert_eq!(place.read("kept/results.json"), before);
    assert!(place.path("kept/episodes/000.mcap").exists());
}

#[test]
fn the_truth_as_localizer_is_named_in_the_results() {
    let results = one(
        &town(),
        &reader_that_says(UNIT_1),
        "--json --set localizer=truth",
    )
    .succeeded()
    .json();
    let setting = &results["settings"]["localizer"];
    assert_eq!(
        (&setting["value"], &setting["default"]),
        (&"truth".into(), &false.into())
    );
    assert!(
        results["deliveries"][0]["pose_error_m"].as_f64().unwrap() < 0.05,
        "{results}"
    );
}

#[test]
fn a_suite_file_runs_from_its_own_folder() {
    let place = town();
    std::fs::create_dir(place.path("suites")).unwrap();
    place.file(
        "suites/town.toml",
        "name = \"mine\"\n[world.imported]\nworld = \"../town.world\"\nmap = \
        \"../town.osm\"\nmodels = []\ngeoreference = \"tangent:3,0\"\n\
         [[episodes]]\ninstruction = \"To unit1, building1.\"\ndeliveries = [{ building = \
         \"building1\", unit = \"unit1\" }]\n",
    );
    let results = place
        .openbench(&format!(
            "run suites/town.toml --json --set reader={}",
            babbler()
        ))
        .succeeded()
        .json();
    assert_eq!(
        (&results["suite"], &results["deliveries"][0]["unit"]),
        (&"mine".into(), &"unit1".into())
    );
}

#[test]
fn drawn_deliveries_follow_the_seed() {
    let (place, reader) = (town(), babbler());
    let run = |seed: u32| {
        let words = format!("--draw 2 1 2 --json --seed {seed} --set reader={reader}");
        let ran = deliver(&place, &words);
        repeatable(ran.succeeded().json())
    };
    let first = run(5);
    assert_eq!(first["deliveries"].as_array().unwrap().len(), 4);
    assert_eq!(first, run(5));
}

#[test]
fn the_default_reader_finds_doors_of_a_built_in_world() {
    let place = Place::new();
    if !common::can_read(&place) {
        return;
    }
    let suite = include_str!("../../../examples/extensions/two-parcels.toml");
    place.file("two.toml", suite);
    let results = place.openbench("run two.toml --jobs 2 --json --record none");
    let metrics = &results.succeeded().json()["metrics"];
    for key in ["sr_10m", "sr_2m", "sr_clean", "correct_unit", "srtp"] {
        assert_eq!(metrics[key], 1.0, "{key}: {metrics}");
    }
    assert!(metrics["spl"].as_f64() > Some(0.3), "{metrics}");
}

#[test]
fn the_default_reader_finds_a_door_of_the_town() {
    let place = town();
    if !common::can_read(&place) {
        return;
    }
    let delivery = only_delivery(&deliver(
        &place,
        "--deliveries one.txt --targets planner --json",
    ));
    assert_eq!(
        (&delivery["success_2m"], &delivery["failure"]),
        (&true.into(), &Value::Null),
        "{delivery}"
    );
}

#[test]
fn a_published_world_is_run_with_its_truth() {
    let Some(data) = common::shared_data("openbench/small") else {
        return;
    };
    let Some(models) = common::shared_data("gazebo_models") else {
        return;
    };
    let file = |name: &str| data.join(name).display().to_string();
    let words = format!(
        "run --world {} --map {} --models {} --deliveries {} --truth {} --json --record none \
        --set reader={}",
        file("small_osm.world"),
        file("small.osm"),
        models.display(),
        file("delivery_instructions_small2.txt"),
        file("delivery_instructions_small_gt2.txt"),
        babbler()
    );
    let results = Place::new().openbench(&words).succeeded().json();
    assert_eq!(
        results["deliveries"].as_array().unwrap().len(),
        3,
        "five parcels for three doors"
    );
    assert_eq!(results["metrics"]["srtp"], 1.0);
}
