//! `openbench evaluate`: the reference recorder's CSV and truth files as they are.

mod common;

use common::{Place, Ran};
use serde_json::json;

/// Two tasks: the first ends at its truth after 10 m, the second 20 m from it.
const LOG: &str = "timestamp,status,address,robot_x,robot_y,robot_z\n\
    1.0,start,\"unit1, building3\",0,0,0.1\n\
    2.0,running,\"unit1, building3\",3,4,0.1\n\
    3.0,end,\"unit1, building3\",6,8,0.1\n\
    4.0,start,unit2,6,8,0.1\n\
    5.0,end,unit2,6,28,0.1\n";

fn evaluate(log: &str, truth: &str, more: &str) -> Ran {
    let place = Place::new();
    place.file("log.csv", log).file("gt.txt", truth);
    place.openbench(&format!("evaluate --log log.csv --truth gt.txt {more}"))
}

#[test]
fn single_deliveries_are_measured_from_the_origin() {
    let answer = evaluate(LOG, "(6.0, 8.0)\n(6.0, 48.0)\n", "")
        .succeeded()
        .json();
    let metrics = &answer["metrics"];
    assert_eq!(
        (
            &metrics["sr_10m"],
            &metrics["spl_straight"],
            &metrics["lsr_10m"]
        ),
        (&json!(0.5), &json!(0.5), &json!(null))
    );
    let first = json!({
        "episode": 0, "task": 0, "address": "unit1, building3", "success_10m": true,
        "distance_to_door_m": 0.0, "path_m": 10.0, "straight_line_m": 10.0
    });
    assert_eq!(answer["deliveries"][0], first);
    assert_eq!(
        (
            &answer["deliveries"][1]["episode"],
            &answer["deliveries"][1]["distance_to_door_m"]
        ),
        (&json!(1), &json!(20.0))
    );
}

#[test]
fn a_sequence_is_measured_from_door_to_door_and_weighted() {
    let answer = evaluate(LOG, "(6.0, 8.0) (6.0, 48.0)\n", "--sequence")
        .succeeded()
        .json();
    assert_eq!(answer["deliveries"][1]["straight_line_m"], 40.0);
    // The first of two counts 1 / (1 + 0.9).
    assert!(
        (answer["metrics"]["lsr_10m"].as_f64().unwrap() - 1.0 / 1.9).abs() < 1e-12,
        "{answer}"
    );
}

#[test]
fn the_papers_tables_come_out_to_two_digits() {
    let log = |good: [bool; 5]| -> String {
        let task = |ok: &bool| {
            format!(
                "1,start,a,0,0,0\n2,end,a,{},0,0\n",
                if *ok { 5 } else { 500 }
            )
        };
        good.iter().map(task).collect()
    };
    for (good, percent) in [
        ([true; 5], 100.0),
        ([false, true, true, true, true], 75.58),
        ([true, true, true, true, false], 83.98),
    ] {
        let answer = evaluate(&log(good), &"(5, 0) ".repeat(5), "--sequence")
            .succeeded()
            .json();
        let lsr = 100.0 * answer["metrics"]["lsr_10m"].as_f64().unwrap();
        assert!((lsr - percent).abs() < 0.005, "{lsr} {percent}");
    }
}

#[test]
fn a_sequence_that_is_not_called_one_is_refused_with_the_option() {
    evaluate(LOG, "(6.0, 8.0) (6.0, 48.0)\n", "").refused_with(&["gt.txt", "--sequence"]);
}

#[test]
fn truths_that_do_not_fit_the_tasks_are_refused_with_both_numbers() {
    evaluate(LOG, "(6.0, 8.0)\n", "").refused_with(&["gt.txt", "1 true position", "2 tasks"]);
    evaluate("", "", "").refused_with(&["gt.txt", "(x, y)"]);
}

#[test]
fn broken_lines_are_refused_with_their_place() {
    evaluate("timestamp\n1,begin,a,0,0,0\n", "(0, 0)", "").refused_with(&[
        "log.csv:2",
        "`begin`",
        "start, running, end",
    ]);
    evaluate("1,start,a,0,0\n", "(0, 0)", "").refused_with(&["log.csv:1", "5 fields"]);
    evaluate("1,running,a,0,0,0\n", "(0, 0)", "").refused_with(&["log.csv:1", "start"]);
    evaluate("1,start,a,0,inf,0\n", "(0, 0)", "").refused_with(&["log.csv:1", "`inf`"]);
    evaluate(LOG, "(6, 8)\n(6; 48)\n", "").refused_with(&["gt.txt:2"]);
}
