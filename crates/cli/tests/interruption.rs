//! A run survives: what is finished stays, the rest is resumed, and the result is the same.
#![cfg(unix)]

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::Place;
use common::endpoint::{UNIT_1, reader_that_says};
use common::town::{HERE, deliver, town};
use serde_json::Value;

/// Instants at which runs are killed. `OPENBENCH_KILLS` asks for more of them.
const KILLS: usize = 5;

/// A town with instructions for three episodes, and all answers that its reader will need.
fn prepared() -> Place {
    let place = town();
    place.file(
        "three.txt",
        "To unit1, building1.\nA box to unit1, building1.\nThe bag to unit1, building1.\n",
    );
    let reader = reader_that_says(UNIT_1);
    let words = format!("{WORDS} --out asked --set reader={reader}");
    deliver(&place, &words).succeeded();
    let answers = (0..3).map(|i| place.read(&format!("asked/episodes/{i:03}.models.jsonl")));
    let answers: String = answers.collect();
    place.file("answers.jsonl", answers);
    place
}

const WORDS: &str = "--deliveries three.txt --targets planner";
/// The run that is interrupted: without waiting for a model, so that all its bytes repeat.
const RUN: &str = "--deliveries three.txt --targets planner --out run \
                   --set reader=replay:answers.jsonl --memory doors.osm";

/// A run with any seed, for which no answers of a model are recorded.
const AT_RANDOM: &str = "--deliveries three.txt --targets planner --out run --agent random";

/// Starts `openbench run` in the background.
fn start(place: &Place, more: &str) -> Child {
    let words = format!("{HERE} {more}");
    Command::new(env!("CARGO_BIN_EXE_openbench"))
        .args(words.split_whitespace())
        .current_dir(place.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits until a file is there.
fn wait_for(path: &Path) {
    let began = Instant::now();
    while !path.exists() {
        assert!(began.elapsed() < Duration::from_secs(60), "{path:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, name: &str) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args([name, &pid]).status().unwrap();
    assert!(sent.success());
}

/// The files of a run by name, without the times of the machine.
fn files(run: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for folder in [run.to_owned(), run.join("episodes")] {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                let name = path.strip_prefix(run).unwrap().display().to_string();
                files.insert(name.clone(), timeless(&name, std::fs::read(path).unwrap()));
            }
        }
    }
    files
}

fn timeless(name: &str, bytes: Vec<u8>) -> Vec<u8> {
    match name {
        "results.json" => {
            let mut results: Value = serde_json::from_slice(&bytes).unwrap();
            for time in ["wall_seconds", "real_time_factor"] {
                results["metrics"][time] = Value::Null;
            }
            results["models"]["latency_ms"] = Value::Null;
            serde_json::to_vec(&results).unwrap()
        }
        "report.html" => {
            let report = String::from_utf8(bytes).unwrap();
            let (before, after) = report.split_once("Real-time factor").unwrap();
            let (_, after) = after.split_once("</dd>").unwrap();
            format!("{before}{after}").into_bytes()
        }
        _ => bytes,
    }
}

/// The names of the files that differ.
fn differences(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let names = a.keys().chain(b.keys());
    let differ = |name: &&String| a.get(*name) != b.get(*name);
    names.filter(differ).cloned().collect()
}

/// The run without an interruption, and how long it takes.
fn uninterrupted(place: &Place, more: &str) -> (BTreeMap<String, Vec<u8>>, Duration) {
    let began = Instant::now();
    deliver(place, &format!("{RUN} {more}")).succeeded();
    let took = began.elapsed();
    let whole = files(&place.path("run"));
    std::fs::remove_dir_all(place.path("run")).unwrap();
    std::fs::remove_file(place.path("doors.osm")).unwrap();
    (whole, took)
}

#[test]
fn a_run_that_is_killed_at_any_instant_and_resumed_equals_an_uninterrupted_one() {
    let place = prepared();
    let kills = std::env::var("OPENBENCH_KILLS").map_or(KILLS, |text| text.parse().unwrap());
    for record in ["--record none", "--record thin --jobs 2"] {
        let (whole, took) = uninterrupted(&place, record);
        for kill in 0..kills.div_ceil(2) {
            // Spread evenly, as multiples of the golden ratio are.
            let share = (kill as f64 + 1.0) * 0.618_033_988_75 % 1.0;
            let mut child = start(&place, &format!("{RUN} {record}"));
            std::thread::sleep(took.mul_f64(share));
            child.kill().unwrap();
            child.wait().unwrap();
            let resumed = place.openbench("run --resume run --jobs 2");
            if resumed.code == 2 {
                // It had not begun.
                assert!(resumed.stderr.contains("no run"), "{}", resumed.stderr);
                deliver(&place, &format!("{RUN} {record}")).succeeded();
            } else {
                resumed.succeeded();
            }
            let found = files(&place.path("run"));
            assert_eq!(
                differences(&whole, &found),
                [""; 0],
                "killed after {share:.3}"
            );
            place.openbench("verify run").succeeded();
            std::fs::remove_dir_all(place.path("run")).unwrap();
            std::fs::remove_file(place.path("doors.osm")).unwrap();
        }
    }
}

#[test]
fn signals_end_a_run_in_order_and_it_can_be_resumed() {
    let place = prepared();
    let (whole, _) = uninterrupted(&place, "");
    for (name, code) in [("-INT", 130), ("-TERM", 143)] {
        let mut child = start(&place, RUN);
        wait_for(&place.path("run/unfinished/episodes/000.actions.json"));
        signal(&child, name);
        assert_eq!(child.wait().unwrap().code(), Some(code));
        assert!(!place.path("run/results.json").exists());
        // Neither a new run nor a verification takes it for nothing.
        deliver(&place, RUN).refused_with(&["run --resume run", "of 3 episodes"]);
        assert_ne!(place.openbench("verify run").code, 0);
        let resumed = place.openbench("run --resume run");
        assert!(
            resumed
                .succeeded()
                .stderr
                .contains("of 3 episodes finished")
        );
        assert_eq!(differences(&whole, &files(&place.path("run"))), [""; 0]);
        // There is nothing left to do, and what is there stays.
        let again = place.openbench("run --resume run");
        assert!(again.succeeded().stderr.contains("is complete"));
        assert_eq!(differences(&whole, &files(&place.path("run"))), [""; 0]);
        std::fs::remove_dir_all(place.path("run")).unwrap();
        std::fs::remove_file(place.path("doors.osm")).unwrap();
    }
}

#[test]
fn old_results_stay_until_new_ones_are_complete() {
    let place = prepared();
    deliver(&place, &format!("{AT_RANDOM} --seed 1")).succeeded();
    let before = files(&place.path("run"));
    let mut child = start(&place, AT_RANDOM);
    wait_for(&place.path("run/unfinished/episodes/000.actions.json"));
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(differences(&before, &files(&place.path("run"))), [""; 0]);
    let discarded = deliver(&place, &format!("{AT_RANDOM} --discard --seed 2"));
    discarded.succeeded();
    assert_eq!(place.json("run/results.json")["seed"], 2);
    assert!(!place.path("run/unfinished").exists());
}

#[test]
fn two_runs_never_write_to_one_folder() {
    let place = prepared();
    let mut first = start(&place, RUN);
    wait_for(&place.path("run/unfinished/run.json"));
    for words in [format!("{HERE} {RUN}"), "run --resume run".to_owned()] {
        place
            .openbench(&words)
            .refused_with(&["another run writes to run"]);
    }
    assert!(first.wait().unwrap().success());
    place.openbench("verify run").succeeded();
}

#[test]
fn a_run_is_resumed_only_in_the_world_in_which_it_began() {
    let place = prepared();
    let mut child = start(&place, RUN);
    wait_for(&place.path("run/unfinished/episodes/000.actions.json"));
    child.kill().unwrap();
    child.wait().unwrap();
    let world = place.read("town.world");
    place.file("town.world", world.replace("3.6 3.6 3<", "3.5 3.5 3<"));
    place
        .openbench("run --resume run")
        .refused_with(&["cannot be continued", "world"]);
    place.file("town.world", world);
    // A finished episode whose file is damaged is driven again.
    place.file("run/unfinished/episodes/000.actions.json", "{");
    place.openbench("run --resume run").succeeded();
    place.openbench("verify run").succeeded();
}

#[test]
fn what_cannot_be_resumed_is_refused() {
    let place = town();
    place
        .openbench("run --resume nowhere")
        .refused_with(&["nowhere", "no run"]);
    assert!(!place.path("nowhere").exists());
    place
        .openbench("run small --resume nowhere")
        .refused_with(&["--resume"]);
}

#[test]
fn several_seeds_are_continued_where_they_were_stopped() {
    let place = prepared();
    let seeds = "--deliveries three.txt --targets planner --out many --seeds 1..2 --agent random";
    deliver(&place, seeds).succeeded();
    let of = |place: &Place, seed: u32| files(&place.path(&format!("many/seed-{seed}")));
    let (first, second) = (of(&place, 1), of(&place, 2));
    let means = place.json("many/means.json");
    std::fs::remove_dir_all(place.path("many")).unwrap();

    let mut child = start(&place, seeds);
    wait_for(&place.path("many/seed-2/unfinished/episodes/000.actions.json"));
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!place.path("many/means.json").exists());
    let written = |path: &str| std::fs::metadata(place.path(path)).unwrap().modified();
    let results = "many/seed-1/results.json";
    let before = written(results).unwrap();
    let again = deliver(&place, seeds);
    assert!(again.succeeded().stderr.contains("seed 1 is done already"));
    assert_eq!(written(results).unwrap(), before, "it was not driven again");
    assert_eq!(differences(&first, &of(&place, 1)), [""; 0]);
    assert_eq!(differences(&second, &of(&place, 2)), [""; 0]);
    assert_eq!(means, place.json("many/means.json"));
}

#[test]
fn seeds_that_replace_others_are_continued_where_they_were_stopped() {
    let place = prepared();
    let seeds = "--deliveries three.txt --targets planner --out many --seeds 1..1";
    deliver(&place, &format!("{seeds} --agent straight-line")).succeeded();
    let replace = format!("{seeds} --agent random --discard");
    let mut child = start(&place, &replace);
    wait_for(&place.path("many/seed-1/unfinished/episodes/000.actions.json"));
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let first = place.path("many/seed-1/unfinished/episodes/000.actions.json");
    let written = || std::fs::metadata(&first).unwrap().modified().unwrap();
    let before = written();
    let mut child = start(&place, &replace);
    wait_for(&place.path("many/seed-1/unfinished/episodes/001.actions.json"));
    assert_eq!(written(), before, "it was not driven again");
    assert!(child.wait().unwrap().success());
    assert_eq!(place.json("many/seed-1/results.json")["agent"], "random");
}

#[test]
fn another_program_continues_no_run() {
    let place = prepared();
    let mut child = start(&place, RUN);
    wait_for(&place.path("run/unfinished/episodes/000.actions.json"));
    child.kill().unwrap();
    child.wait().unwrap();
    let mut record = place.json("run/unfinished/run.json");
    record["build"]["program"] = "another".into();
    place.file("run/unfinished/run.json", record.to_string());
    place
        .openbench("run --resume run")
        .refused_with(&["cannot be continued", "its program is another"]);
}

#[test]
fn damaged_remains_of_a_run_are_discarded_if_asked_for() {
    let place = prepared();
    for damaged in ["run.json", "complete.json"] {
        std::fs::create_dir_all(place.path("run/unfinished/episodes")).unwrap();
        place.file(&format!("run/unfinished/{damaged}"), "{]");
        deliver(&place, AT_RANDOM).refused_with(&[damaged]);
        deliver(&place, &format!("{AT_RANDOM} --discard")).succeeded();
        assert!(!place.path("run/unfinished").exists());
    }
}
