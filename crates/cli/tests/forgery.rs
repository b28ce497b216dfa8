//! `openbench verify` refuses every run folder that was forged, edited or damaged.

mod common;

use std::path::Path;

use common::Place;
use common::endpoint::{UNIT_1, reader_that_says};
use common::town::{deliver, town};
use openbench_bench::RunRecord;
use openbench_bench::run::recording::Recording;
use serde_json::{Value, json};

/// What is done to the folder of a run, which is called `forged`.
type Forgery = fn(&Place);

/// A town with two runs of two episodes, of which the second one has another seed.
fn runs() -> Place {
    let place = town();
    place.file(
        "two.txt",
        "To unit1, building1.\nA box to unit1, building1.\n",
    );
    let reader = reader_that_says(UNIT_1);
    for (out, seed) in [("run", 0), ("other", 1)] {
        let words = format!(
            "--deliveries two.txt --targets planner --out {out} --seed {seed} \
             --set reader={reader} --memory {out}.osm"
        );
        deliver(&place, &words).succeeded();
        // Now there is a memory.
        deliver(&place, &words).succeeded();
    }
    place
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Edits a JSON file of the forged run.
fn edit(place: &Place, name: &str, change: impl FnOnce(&mut Value)) {
    let name = format!("forged/{name}");
    let mut value = place.json(&name);
    change(&mut value);
    place.file(&name, serde_json::to_vec(&value).unwrap());
}

fn results(place: &Place, change: impl FnOnce(&mut Value)) {
    edit(place, "results.json", change);
}

fn record(place: &Place, change: impl FnOnce(&mut Value)) {
    edit(place, "run.json", change);
}

fn actions(place: &Place, change: impl FnOnce(&mut Value)) {
    edit(place, "episodes/001.actions.json", change);
}

/// Edits the first deed of a kind.
fn deed(place: &Place, kind: &str, change: impl FnOnce(&mut Value)) {
    actions(place, |actions| {
        let deeds = actions["deeds"].as_array_mut().unwrap();
        let deed = deeds.iter_mut().find(|deed| deed["do"].get(kind).is_some());
        change(deed.unwrap_or_else(|| panic!("there is no deed `{kind}`")));
    });
}

/// Seals an edited recording anew, as a forger does who has read the source.
fn reseal(place: &Place) {
    let run = place.path("forged");
    let record = RunRecord::read(&run).unwrap();
    record.write(&run).unwrap();
    for episode in 0..2 {
        let recording = Recording::read(&run, episode).unwrap();
        recording
            .sealed(&record, episode)
            .write(&run, episode)
            .unwrap();
    }
}

/// Edits the record, seals the recordings anew, and makes the same claim in the results.
fn claim(place: &Place, record_of: impl FnOnce(&mut Value), results_of: impl FnOnce(&mut Value)) {
    record(place, record_of);
    results(place, results_of);
    reseal(place);
}

fn remove(place: &Place, name: &str) {
    std::fs::remove_file(place.path("forged").join(name)).unwrap();
}

fn append(place: &Place, name: &str, text: &str) {
    let path = place.path("forged").join(name);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes.extend(text.as_bytes());
    std::fs::write(path, bytes).unwrap();
}

/// Cuts a file in half.
fn halve(place: &Place, name: &str) {
    let path = place.path("forged").join(name);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
}

/// Takes a file of the other run.
fn exchange(place: &Place, name: &str) {
    let from = place.path("other").join(name);
    std::fs::copy(from, place.path("forged").join(name)).unwrap();
}

const RESULTS: [(&str, Forgery); 27] = [
    ("a key twice", |p| {
        let text = p.read("forged/results.json");
        let twice = text.replacen("{", "{ \"agent\": \"mine\",", 1);
        p.file("forged/results.json", twice);
    }),
    ("a better rate", |p| {
        results(p, |r| r["metrics"]["sr_2m"] = json!(0.987))
    }),
    ("a better path ratio", |p| {
        results(p, |r| r["metrics"]["spl"] = json!(0.999))
    }),
    ("a narrower interval", |p| {
        results(p, |r| {
            r["metrics"]["intervals"]["sr_2m"] = json!([0.9, 1.0])
        })
    }),
    ("a time before the start", |p| {
        results(p, |r| r["metrics"]["wall_seconds"] = json!(-5.0))
    }),
    ("a speed without a time", |p| {
        results(p, |r| r["metrics"]["wall_seconds"] = json!(null))
    }),
    ("a delivery that failed", |p| {
        results(p, |r| {
            let success = &mut r["deliveries"][0]["success_2m"];
            *success = json!(!success.as_bool().unwrap());
        })
    }),
    ("a delivery left out", |p| {
        results(p, |r| drop(r["deliveries"].as_array_mut().unwrap().pop()))
    }),
    ("a shorter path", |p| {
        results(p, |r| r["deliveries"][0]["path_m"] = json!(1.0))
    }),
    ("another door", |p| {
        results(p, |r| r["deliveries"][0]["unit"] = json!("unit2"))
    }),
    ("a collision more", |p| {
        results(p, |r| r["metrics"]["collisions"] = json!(7))
    }),
    ("a smaller pose error", |p| {
        results(p, |r| r["metrics"]["localization"]["rmse_m"] = json!(1e-9))
    }),
    ("another health", |p| {
        results(p, |r| r["episodes"][0]["health"] = json!([]))
    }),
    ("doors that nobody wrote", |p| {
        results(p, |r| r["doors"]["found"] = json!(100))
    }),
    ("another agent", |p| {
        results(p, |r| r["agent"] = json!("mine"))
    }),
    ("another seed in the results", |p| {
        results(p, |r| r["seed"] = json!(9))
    }),
    ("another setting in the results", |p| {
        results(p, |r| r["settings"]["localizer"]["value"] = json!("truth"))
    }),
    ("a departure marked as default", |p| {
        results(p, |r| r["settings"]["reader"]["default"] = json!(true))
    }),
    ("another commit in the results", |p| {
        results(p, |r| r["provenance"]["build"]["commit"] = json!("0"))
    }),
    ("a memory denied", |p| {
        results(p, |r| drop(r.as_object_mut().unwrap().remove("memory")))
    }),
    ("targets by somebody else", |p| {
        results(p, |r| r["targets"] = json!("annotation"))
    }),
    ("fewer questions to models", |p| {
        results(p, |r| r["models"]["calls"] = json!(0))
    }),
    ("a key that does not belong there", |p| {
        results(p, |r| r["metrics"]["rank"] = json!(1))
    }),
    ("results of another run", |p| exchange(p, "results.json")),
    ("no results", |p| remove(p, "results.json")),
    ("garbage for results", |p| {
        p.file("forged/results.json", "{]");
    }),
    ("half of the results", |p| halve(p, "results.json")),
];

const RECORD: [(&str, Forgery); 16] = [
    ("another seed", |p| record(p, |r| r["seed"] = json!(1))),
    ("a setting denied", |p| {
        record(p, |r| r["settings"] = json!({}))
    }),
    ("a setting in force denied", |p| {
        record(p, |r| r["in_force"]["reader"]["default"] = json!(true))
    }),
    ("another name of the agent", |p| {
        record(p, |r| r["agent"] = json!("mine"))
    }),
    ("another instruction", |p| {
        record(p, |r| {
            r["suite"]["episodes"][0]["instruction"] = json!("To unit2, building2.")
        })
    }),
    ("another door in the suite", |p| {
        record(p, |r| {
            r["suite"]["episodes"][1]["deliveries"][0]["unit"] = json!("unit2")
        })
    }),
    ("people who were not there", |p| {
        record(p, |r| r["suite"]["traffic"] = json!({"pedestrians": 3}))
    }),
    ("another name of the suite", |p| {
        record(p, |r| r["suite"]["name"] = json!("large"))
    }),
    ("an episode left out", |p| {
        record(p, |r| r["episodes"] = json!(1))
    }),
    ("another world", |p| {
        record(p, |r| r["hashes"]["world"] = json!("00"))
    }),
    ("another commit", |p| {
        record(p, |r| r["build"]["commit"] = json!("0"))
    }),
    ("another memory", |p| {
        record(p, |r| r["memory"]["hash"] = json!("00"))
    }),
    ("logs denied", |p| record(p, |r| r["logs"] = json!("none"))),
    ("another command line", |p| {
        record(p, |r| r["command"] = json!("openbench run"))
    }),
    ("the record of another run", |p| exchange(p, "run.json")),
    ("no record", |p| remove(p, "run.json")),
];

/// Claims about the agent in results and record, with which the recordings are sealed. The names
/// are what `verify` says of them.
const CLAIMS: [(&str, Forgery); 6] = [
    // A departure denied.
    ("in_force.reader.default", |p| {
        let default = json!({"value": "ppocr-v4", "default": true});
        claim(
            p,
            |r| r["in_force"]["reader"] = default.clone(),
            |r| r["settings"]["reader"] = default.clone(),
        )
    }),
    // A setting denied in all places.
    ("models", |p| {
        let default = json!({"value": "ppocr-v4", "default": true});
        claim(
            p,
            |r| {
                r["in_force"]["reader"] = default.clone();
                r["settings"] = json!({});
            },
            |r| r["settings"]["reader"] = default.clone(),
        )
    }),
    // A truth that it was not told.
    ("uses_truth", |p| {
        claim(
            p,
            |r| r["uses_truth"] = json!(true),
            |r| r["provenance"]["uses_truth"] = json!(true),
        )
    }),
    // An agent that cannot repeat.
    ("cannot_repeat", |p| {
        let reason = json!("a person drove");
        claim(
            p,
            |r| r["cannot_repeat"] = reason.clone(),
            |r| r["provenance"]["cannot_repeat"] = reason.clone(),
        )
    }),
    // Other models.
    ("models", |p| {
        let models = json!([{"name": "m", "sha256": "00"}]);
        claim(
            p,
            |r| r["models"] = models.clone(),
            |r| r["provenance"]["models"] = models.clone(),
        )
    }),
    // A smaller memory.
    ("memory.doors", |p| {
        claim(
            p,
            |r| r["memory"]["doors"] = json!(0),
            |r| r["memory"]["doors"] = json!(0),
        )
    }),
];

const ACTIONS: [(&str, Forgery); 22] = [
    ("another velocity", |p| {
        actions(p, |a| a["driven"][0]["velocity"]["linear"] = json!(0.123))
    }),
    ("a stretch left out", |p| {
        actions(p, |a| drop(a["driven"].as_array_mut().unwrap().pop()))
    }),
    ("a stretch of a year", |p| {
        actions(p, |a| a["driven"][0]["steps"] = json!(4_000_000_000_u32))
    }),
    ("another chain of states", |p| {
        actions(p, |a| a["chain"] = json!("00"))
    }),
    ("another seal", |p| actions(p, |a| a["seal"] = json!("00"))),
    ("another seed of the episode", |p| {
        actions(p, |a| a["seed"] = json!(0))
    }),
    ("another seed, sealed again", |p| {
        actions(p, |a| a["seed"] = json!(0));
        reseal(p);
    }),
    ("an earlier declaration", |p| {
        deed(p, "delivered", |d| d["step"] = json!(3))
    }),
    ("an earlier declaration, sealed again", |p| {
        deed(p, "delivered", |d| d["step"] = json!(3));
        reseal(p);
    }),
    ("a declaration of another address, sealed again", |p| {
        deed(p, "delivered", |d| {
            d["do"]["delivered"]["unit"] = json!("unit2")
        });
        reseal(p);
    }),
    ("a declaration after the end, sealed again", |p| {
        deed(p, "delivered", |d| d["step"] = json!(1_000_000));
        reseal(p);
    }),
    ("a better estimate", |p| {
        deed(p, "estimated", |d| {
            d["do"]["estimated"][0] = json!([0.25, 0.0, 0.0])
        })
    }),
    ("a better estimate, sealed again", |p| {
        deed(p, "estimated", |d| {
            d["do"]["estimated"][0] = json!([0.5, 0.0, 0.0])
        });
        reseal(p);
    }),
    ("another plan, sealed again", |p| {
        deed(p, "planned", |d| {
            d["do"]["planned"]["deliveries"] = json!([])
        });
        reseal(p);
    }),
    ("a plate that nobody read, sealed again", |p| {
        actions(p, |a| {
            let read = json!({"text": "UNIT 9", "confidence": 1.0,
                "corners": [[0, 0], [1, 0], [1, 1], [0, 1]]});
            let deeds = a["deeds"].as_array_mut().unwrap();
            deeds.insert(0, json!({"step": 0, "do": {"read": read}}));
        });
        reseal(p);
    }),
    ("another picture", |p| {
        actions(p, |a| a["frames"][0]["jpeg"] = json!("AAAA"))
    }),
    ("another picture, sealed again", |p| {
        actions(p, |a| a["frames"][0]["jpeg"] = json!("AAAA"));
        reseal(p);
    }),
    ("the actions of the episode before", |p| {
        let episodes = p.path("forged/episodes");
        let from = episodes.join("000.actions.json");
        std::fs::copy(from, episodes.join("001.actions.json")).unwrap();
    }),
    ("the actions of another run", |p| {
        exchange(p, "episodes/001.actions.json")
    }),
    ("half of the actions", |p| {
        halve(p, "episodes/001.actions.json")
    }),
    ("no actions", |p| remove(p, "episodes/001.actions.json")),
    ("a key that is no action", |p| {
        actions(p, |a| a["score"] = json!(1))
    }),
];

const FILES: [(&str, Forgery); 19] = [
    ("an edited report", |p| {
        let report = p.read("forged/report.html");
        p.file("forged/report.html", report.replace("SR", "sr"));
    }),
    ("the report of another run", |p| exchange(p, "report.html")),
    ("no report", |p| remove(p, "report.html")),
    ("an edited map", |p| {
        append(p, "episodes/000.osm", "<!-- more -->")
    }),
    ("no map", |p| remove(p, "episodes/000.osm")),
    ("a damaged log", |p| halve(p, "episodes/000.mcap")),
    ("an edited log", |p| append(p, "episodes/001.mcap", "more")),
    ("the log of another run", |p| {
        exchange(p, "episodes/000.mcap")
    }),
    ("no log", |p| remove(p, "episodes/000.mcap")),
    ("other answers of a model", |p| {
        let name = "forged/episodes/000.models.jsonl";
        p.file(name, p.read(name).replace("UNIT 1", "UNIT 7"));
    }),
    ("no answers of a model", |p| {
        remove(p, "episodes/000.models.jsonl")
    }),
    ("a log of an episode that is not there", |p| {
        p.file("forged/episodes/002.mcap", "x");
    }),
    ("actions of an episode that is not there", |p| {
        exchange_as(p, "episodes/001.actions.json", "episodes/002.actions.json")
    }),
    ("no memory", |p| remove(p, "memory-before.osm")),
    ("an edited memory", |p| {
        append(p, "memory-before.osm", "<!-- more -->")
    }),
    ("another memory's file", |p| {
        exchange(p, "memory-before.osm")
    }),
    ("an interrupted run inside", |p| {
        let inside = p.path("forged/unfinished/episodes");
        std::fs::create_dir_all(inside).unwrap();
    }),
    ("no episodes", |p| {
        std::fs::remove_dir_all(p.path("forged/episodes")).unwrap()
    }),
    ("empty files", |p| {
        for name in ["results.json", "run.json", "report.html"] {
            p.file(&format!("forged/{name}"), "");
        }
    }),
];

fn exchange_as(place: &Place, from: &str, to: &str) {
    let from = place.path("other").join(from);
    std::fs::copy(from, place.path("forged").join(to)).unwrap();
}

#[test]
fn every_forged_edited_or_damaged_run_is_refused() {
    let place = runs();
    let forged = place.path("forged");
    let verify = || {
        let ran = place.openbench("verify forged");
        (ran.code, ran.stderr)
    };
    copy(&place.path("run"), &forged);
    assert_eq!(verify(), (0, String::new()), "the run itself");
    let lists: [&[(&str, Forgery)]; 4] = [&RESULTS, &RECORD, &ACTIONS, &FILES];
    for (name, forge) in lists.into_iter().flatten() {
        std::fs::remove_dir_all(&forged).unwrap();
        copy(&place.path("run"), &forged);
        forge(&place);
        let (code, said) = verify();
        assert!(code == 1 || code == 2, "{name}: {code} {said}");
        let place = said.contains("forged") || said.contains("episode");
        assert!(place, "{name}: neither file nor episode is named: {said}");
    }
}

#[test]
fn what_a_sealed_record_claims_of_its_agent_is_compared_with_the_agent() {
    let place = runs();
    let forged = place.path("forged");
    for (named, forge) in CLAIMS {
        copy(&place.path("run"), &forged);
        forge(&place);
        let said = place.openbench("verify forged");
        assert_eq!(said.code, 1, "{named}: {}", said.stderr);
        let claim = format!("run.json is not what the run gives: {named}");
        assert!(said.stderr.contains(&claim), "{named}: {}", said.stderr);
        // Nor does it help that the agent repeats its actions.
        assert_ne!(place.openbench("verify forged --agent").code, 0, "{named}");
        std::fs::remove_dir_all(&forged).unwrap();
    }
}

#[test]
fn another_world_map_or_suite_is_refused() {
    let edits: [(&str, &str, &str, &str); 2] = [
        (
            "town.world",
            "<size>3.6 3.6 3</size>",
            "<size>3.5 3.5 3</size>",
            "world",
        ),
        ("town.osm", "Long Lane", "Short Lane", "map"),
    ];
    let place = runs();
    for (file, from, to, what) in edits {
        let before = place.read(file);
        assert!(before.contains(from), "{file}");
        place.file(file, before.replace(from, to));
        let ran = place.openbench("verify run");
        assert_eq!(ran.code, 1, "{}{}", ran.stdout, ran.stderr);
        assert!(
            ran.stderr.contains(&format!("the {what} is")),
            "{}",
            ran.stderr
        );
        place.file(file, before);
    }
    place.openbench("verify run").succeeded();
}
