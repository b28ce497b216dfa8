//! Whether the files of a run follow from its recorded actions.
//!
//! The actions are driven again in the same world. States, results and report are computed anew and
//! compared with the files. This proves that these actions give these scores. [`verify_agent`]
//! compares what the record says of its agent with the agent. Who made the actions is known only if
//! the agent is run again, see [`repeat`](super::repeat).

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};

use super::episodes::{replay_sealed, report_of};
use super::files::{REPORT, RESULTS, RUN, read_file, read_json};
use super::folder::{MEMORY_BEFORE, UNFINISHED, memory_of, run_files};
use super::output::FinishedRun;
use super::record::{RunRecord, memory_use, models_of};
use super::recorder::Level;
use super::recording::{FileHashes, Recording};
use super::registry::AgentFactory;
use super::threads;
use crate::BenchError;
use crate::score::results::Results;
use crate::trace::EpisodeTrace;
use crate::worlds::hashes::hash_file;
use crate::worlds::{Hashes, Prepared};

/// Where `results.json` has times of the machine.
const MACHINE_TIMES: [&str; 3] = [
    "/metrics/wall_seconds",
    "/metrics/real_time_factor",
    "/models/latency_ms",
];

/// Verifies the run in the folder `run`, which has this record, on several threads. `progress` is
/// called after each episode.
///
/// # Errors
/// [`BenchError::Differs`] or [`BenchError::Altered`] with the first difference, or a file that
/// cannot be read.
pub fn verify(
    run: &Path,
    record: &RunRecord,
    prepared: &Prepared,
    jobs: usize,
    progress: &mut dyn FnMut(),
) -> Result<(), BenchError> {
    check_files(run, record)?;
    check_text(&run.join(RUN), &serde_json::to_vec(record))?;
    check_inputs(run, record, prepared)?;
    let traces = threads::each(
        0..record.episodes,
        jobs,
        |number| replay_sealed(prepared, record, run, number),
        |trace: EpisodeTrace| {
            progress();
            Ok::<_, BenchError>(trace)
        },
    )?;
    let memory = memory_of(run)?;
    check_results(
        run,
        &FinishedRun {
            record,
            prepared,
            memory: memory.as_ref(),
            traces: &traces,
            times: None,
        },
    )
}

/// Compares what the record of the run in the folder `run` says of its agent (settings in force,
/// models, whether it was told the truth, why it cannot repeat) and of its memory with what agent
/// and memory give. The seal does not protect these: a forger can seal an edited record anew.
///
/// # Errors
/// [`BenchError::Altered`] with the first difference, a memory that cannot be read, or
/// [`BenchError::Agent`] if a model file is not here.
pub fn verify_agent(
    run: &Path,
    record: &RunRecord,
    prepared: &Prepared,
    factory: &dyn AgentFactory,
) -> Result<(), BenchError> {
    let settings = &record.settings;
    let memory = memory_of(run)?;
    let claimed = json!({
        "in_force": record.in_force,
        "models": record.models,
        "uses_truth": record.uses_truth,
        "cannot_repeat": record.cannot_repeat,
        "memory": record.memory,
    });
    let found = json!({
        "in_force": factory.in_force(settings),
        "models": models_of(&record.agent, factory, settings)?,
        "uses_truth": factory.uses_truth(settings),
        "cannot_repeat": factory.cannot_repeat(settings),
        "memory": memory.map(|memory| memory_use(prepared, &memory)),
    });
    match difference("", &claimed, &found) {
        Some(detail) => Err(BenchError::Altered {
            path: run.join(RUN),
            detail,
        }),
        None => Ok(()),
    }
}

/// Every file of the run is there, and none of another run.
fn check_files(run: &Path, record: &RunRecord) -> Result<(), BenchError> {
    let altered = |name: &str, detail: &str| {
        Err(BenchError::Altered {
            path: run.join(name),
            detail: detail.to_owned(),
        })
    };
    if run.join(UNFINISHED).exists() {
        return altered(
            UNFINISHED,
            "a run was interrupted here; complete it with `openbench run --resume`",
        );
    }
    let mut expected = BTreeSet::from([RUN, RESULTS, REPORT].map(str::to_owned));
    expected.extend(record.memory.as_ref().map(|_| MEMORY_BEFORE.to_owned()));
    let found = run_files(run)?;
    if let Some(missing) = expected.iter().find(|name| !found.contains(*name)) {
        return altered(missing, "the file is missing");
    }
    // Recordings say which other files their episodes have.
    for number in 0..record.episodes {
        let recording = Recording::read(run, number)?;
        if (record.logs == Level::None) != recording.files.log.is_none() {
            return altered(RUN, "it and the recordings disagree about logs");
        }
        expected.extend(names(number, &recording.files));
    }
    match found.difference(&expected).next() {
        Some(other) => altered(other, "the run has no such file"),
        None => Ok(()),
    }
}

/// The names of an episode's files.
fn names(number: usize, files: &FileHashes) -> Vec<String> {
    let kinds = [
        ("mcap", &files.log),
        ("osm", &files.map),
        ("models.jsonl", &files.models),
    ];
    let there = kinds.into_iter().filter(|(_, hash)| hash.is_some());
    let endings = there.map(|(ending, _)| ending).chain(["actions.json"]);
    endings
        .map(|ending| format!("episodes/{number:03}.{ending}"))
        .collect()
}

/// World, map, suite and memory are those of the record.
fn check_inputs(run: &Path, record: &RunRecord, prepared: &Prepared) -> Result<(), BenchError> {
    if record.suite.clone().with_seed(record.seed) != record.suite {
        return Err(BenchError::Altered {
            path: run.join(RUN),
            detail: "map and robot are drawn from another seed than the run's".to_owned(),
        });
    }
    let now = Hashes::of(prepared)?;
    let then = &record.hashes;
    let pairs = [
        ("world", &then.world, &now.world),
        ("map", &then.map, &now.map),
        ("suite", &then.suite, &now.suite),
    ];
    let other = pairs.into_iter().find(|(_, then, now)| then != now);
    let other = other.map(|(what, _, _)| what);
    let other = other.or((then.truth != now.truth).then_some("file of true positions"));
    if let Some(what) = other {
        return Err(BenchError::Altered {
            path: run.join(RUN),
            detail: format!("the {what} is another one than that of the run"),
        });
    }
    if record.episodes != prepared.episodes.len() {
        return Err(BenchError::Altered {
            path: run.join(RUN),
            detail: "its number of episodes is not that of its suite".to_owned(),
        });
    }
    let path = run.join(MEMORY_BEFORE);
    match &record.memory {
        Some(memory) if hash_file(&path)? != memory.hash => Err(BenchError::Altered {
            path,
            detail: "it is another map than that of the run".to_owned(),
        }),
        _ => Ok(()),
    }
}

/// Results and report are those of the replayed episodes.
fn check_results(run: &Path, finished: &FinishedRun<'_>) -> Result<(), BenchError> {
    let path = run.join(RESULTS);
    let mut recorded: Value = read_json(&path, "results file")?;
    let computed = finished.results();
    let mut expected =
        serde_json::to_value(&computed).map_err(|e| BenchError::bad_file(&path, e))?;
    for results in [&mut recorded, &mut expected] {
        for place in MACHINE_TIMES {
            if let Some(time) = results.pointer_mut(place) {
                *time = Value::Null;
            }
        }
    }
    if let Some(detail) = difference("", &recorded, &expected) {
        return Err(BenchError::Altered { path, detail });
    }
    // With the times of the file, which the report shows.
    let results = Results::read(&path)?;
    if !results.has_possible_times() {
        let detail = "wall_seconds or real_time_factor is not possible".to_owned();
        return Err(BenchError::Altered { path, detail });
    }
    check_text(&path, &computed.with_times_of(&results).to_json())?;
    let report = report_of(finished, &results);
    let path = run.join(REPORT);
    if read_file(&path)? != report.as_bytes() {
        let detail = "it differs from the report that follows from results and actions";
        return Err(BenchError::Altered {
            path,
            detail: detail.to_owned(),
        });
    }
    Ok(())
}

/// The text of a JSON file is the one that we write. Of a key that it has twice, we read the last
/// value, and other programs perhaps the first.
fn check_text(path: &Path, expected: &serde_json::Result<Vec<u8>>) -> Result<(), BenchError> {
    let text = read_file(path)?;
    if expected.as_ref().is_ok_and(|expected| *expected == text) {
        return Ok(());
    }
    let detail = "its values are right, but it is written otherwise, such as with a key twice";
    Err(BenchError::Altered {
        path: path.to_owned(),
        detail: detail.to_owned(),
    })
}

/// The first place at which two values differ, in words; `at` is the place of both.
fn difference(at: &str, recorded: &Value, expected: &Value) -> Option<String> {
    let inner = |key: &str| {
        if at.is_empty() {
            key.to_owned()
        } else {
            format!("{at}.{key}")
        }
    };
    match (recorded, expected) {
        (Value::Object(a), Value::Object(b)) => {
            let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            keys.into_iter().find_map(|key| {
                let none = &Value::Null;
                match (a.get(key), b.get(key)) {
                    (None, Some(_)) => Some(format!("{} is missing", inner(key))),
                    (Some(_), None) => Some(format!("{} does not belong there", inner(key))),
                    (a, b) => difference(&inner(key), a.unwrap_or(none), b.unwrap_or(none)),
                }
            })
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            let mut each = pairs.map(|(i, (a, b))| difference(&inner(&i.to_string()), a, b));
            each.find_map(|found| found)
        }
        (Value::Array(a), Value::Array(b)) => Some(format!(
            "{at} has {} entries, but the run gives {}",
            a.len(),
            b.len()
        )),
        (a, b) => (a != b).then(|| format!("{at} is {}, but the run gives {}", short(a), short(b))),
    }
}

/// A value in at most a few words.
fn short(value: &Value) -> String {
    const MOST: usize = 60;
    let text = value.to_string();
    let cut: String = text.chars().take(MOST).collect();
    if cut.len() < text.len() {
        format!("{cut}…")
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_is_named_with_its_place() {
        let value = json!({"metrics": {"sr": 0.5, "lsr": null}, "deliveries": [{"a": 1}]});
        let after = |change: &dyn Fn(&mut Value)| {
            let mut changed = value.clone();
            change(&mut changed);
            difference("", &changed, &value)
        };
        assert_eq!(after(&|_| {}), None);
        let said = |change: &dyn Fn(&mut Value)| after(change).unwrap();
        assert_eq!(
            said(&|v| v["metrics"]["sr"] = json!(1.0)),
            "metrics.sr is 1.0, but the run gives 0.5"
        );
        assert_eq!(
            said(&|v| v["deliveries"][0]["b"] = json!(1)),
            "deliveries.0.b does not belong there"
        );
        let removed = said(&|v| drop(v["metrics"].as_object_mut().unwrap().remove("lsr")));
        assert_eq!(removed, "metrics.lsr is missing");
        let longer = said(&|v| v["deliveries"].as_array_mut().unwrap().push(json!(1)));
        assert_eq!(longer, "deliveries has 2 entries, but the run gives 1");
        let long = said(&|v| v["metrics"]["sr"] = json!("x".repeat(500)));
        assert!(long.len() < 200, "{long}");
    }
}
