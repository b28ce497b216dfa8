//! Agents behind policy servers, through the command.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use common::Place;
use common::endpoint::{Answer, http};
use common::town::town;
use serde_json::{Value, json};

/// Both doors of the town, as points.
const SUITE: &str = r#"
name = "points"
goal = "point"

[world.imported]
world = "town.world"
map = "town.osm"
models = []
georeference = "tangent:3,0"

[[episodes]]
instruction = "Bring this parcel to unit1, building1."
deliveries = [{ building = "building1", unit = "unit1" }]

[[episodes]]
instruction = "Bring this parcel to unit2, building2."
deliveries = [{ building = "building2", unit = "unit2" }]
"#;

fn place() -> Place {
    let place = town();
    place.file("points.toml", SUITE);
    place
}

/// The goal of a request: metres ahead and to the left.
fn goal(body: &str) -> Option<(f64, f64)> {
    let start = body.find(r#"{"goal_x""#)?;
    let goal = &body[start..=start + body[start..].find('}')?];
    let goal: Value = serde_json::from_str(goal).ok()?;
    Some((goal["goal_x"][0].as_f64()?, goal["goal_y"][0].as_f64()?))
}

/// A trajectory straight to a point.
fn straight((x, y): (f64, f64)) -> Answer {
    let points: Vec<_> = (1..=24)
        .map(|step| f64::from(step) / 24.0)
        .map(|share| json!([share * x, share * y, 0.0]))
        .collect();
    Answer::Body(json!({ "trajectory": [points] }).to_string())
}

fn failures(place: &Place, run: &str) -> Vec<Value> {
    let results = place.json(&format!("{run}/results.json"));
    let deliveries = results["deliveries"].as_array().unwrap();
    deliveries.iter().map(|d| d["failure"].clone()).collect()
}

#[test]
fn a_server_that_fails_fails_its_delivery_and_the_recording_repeats_both() {
    // Straight to a goal ahead; a goal to the left is too much for it.
    let is_gone = Arc::new(AtomicBool::new(false));
    let gone = Arc::clone(&is_gone);
    let port = http(move |_, body| match goal(body) {
        _ if gone.load(Ordering::SeqCst) => Answer::Status(503),
        None => Answer::Body(json!({ "algo": "navdp" }).to_string()),
        Some((_, left)) if left > 5.0 => Answer::Status(500),
        Some(goal) => straight(goal),
    });
    let place = place();
    let run = format!("run points.toml --agent navdp:http://127.0.0.1:{port} --out runs/points");
    place.openbench(&run).succeeded();
    let failures = failures(&place, "runs/points");
    assert_eq!(failures, [Value::Null, json!("policy_unavailable")]);

    is_gone.store(true, Ordering::SeqCst);
    place.openbench("verify runs/points --agent").succeeded();
    // Another answer leads elsewhere: the recording is what is repeated.
    let answers = "runs/points/episodes/000.models.jsonl";
    let changed = place.read(answers).replacen("\"x\":", "\"x\":-", 40);
    place.file(answers, changed);
    assert_eq!(place.openbench("verify runs/points --agent").code, 1);
}

#[test]
fn a_goal_that_a_server_does_not_take_is_repeated_as_such() {
    let port = http(|_, _| Answer::Body("{}".into()));
    let place = place();
    place.file("words.toml", SUITE.replace("goal = \"point\"\n", ""));
    let run = format!("run words.toml --agent navdp:http://127.0.0.1:{port} --out runs/words");
    place.openbench(&run).succeeded();
    assert_eq!(
        failures(&place, "runs/words"),
        [json!("briefing"), json!("briefing")]
    );
    place.openbench("verify runs/words --agent").succeeded();
    let results = place.json("runs/words/results.json");
    assert!(
        results["settings"]["replan"].is_object(),
        "{}",
        results["settings"]
    );
    assert!(
        results["settings"]["size"].is_null(),
        "{}",
        results["settings"]
    );
}

#[test]
fn without_a_server_nothing_is_run() {
    let place = place();
    let ran = place.openbench("run points.toml --agent openpi:ws://127.0.0.1:9");
    ran.refused_with(&["no policy server can be reached at 127.0.0.1:9"]);
    assert!(!place.path("runs/latest/results.json").exists());
    for (agent, part) in [
        ("openpi:http://127.0.0.1:9", "ws://127.0.0.1:8000"),
        ("navdp:ws://127.0.0.1:9", "http://127.0.0.1:8888"),
        ("vla-eval:", "ws://127.0.0.1:8000"),
        ("openpi:ws://me:secret@127.0.0.1:9", "password"),
    ] {
        let ran = place.openbench(&format!("run points.toml --agent {agent}"));
        ran.refused_with(&[part]);
        assert!(!ran.stderr.contains("secret"), "{}", ran.stderr);
    }
}

#[test]
fn charged_answers_come_late() {
    let port = http(|_, body| match goal(body) {
        None => Answer::Body(json!({ "algo": "navdp" }).to_string()),
        Some(goal) => {
            std::thread::sleep(std::time::Duration::from_millis(300));
            straight(goal)
        }
    });
    let place = place();
    let agent = format!("navdp:http://127.0.0.1:{port}");
    let seconds = |more: &str, out: &str| {
        let run = format!("run points.toml --agent {agent} --jobs 2 --out runs/{out} {more}");
        place.openbench(&run).succeeded();
        let results = place.json(&format!("runs/{out}/results.json"));
        results["deliveries"][0]["sim_seconds"].as_f64().unwrap()
    };
    let late = seconds("--realtime", "late") - seconds("", "free");
    // The first answer alone is three tenths of a second late.
    assert!(late > 0.2, "{late} s later");
    place.openbench("verify runs/late --agent").succeeded();
}
