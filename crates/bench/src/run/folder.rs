//! The files in the folder of a run.
//!
//! | file | content |
//! |---|---|
//! | `run.json` | the [`RunRecord`]: the parameters, sufficient to repeat the run |
//! | `results.json` | the [`Results`] |
//! | `report.html` | the same with maps, for people |
//! | [`MEMORY_BEFORE`] | the doors known before the run, if there were any |
//! | `episodes/000.actions.json` | the [`Recording`](super::recording::Recording) of an episode |
//! | `episodes/000.mcap` | its log |
//! | `episodes/000.osm` | the agent's copy of the map, if it edits one |
//! | `episodes/000.models.jsonl` | the answers of models, if it asked any |

use std::path::{Path, PathBuf};

use openbench_osm::{OsmData, OsmError, write_atomically};

use super::recording::RunRecord;
use super::request::RunRequest;
use crate::BenchError;
use crate::report::{self, report_input};
use crate::score::results::Results;
use crate::trace::EpisodeTrace;

/// Name of the file, in a run's folder, with the doors known before the run.
pub const MEMORY_BEFORE: &str = "memory-before.osm";

/// Files of a run besides those of its episodes.
const FILES: [&str; 4] = ["results.json", "report.html", "run.json", MEMORY_BEFORE];
/// Folder, in a run's folder, with the files of the episodes.
const EPISODES: &str = "episodes";
/// Endings of an episode's files, after its number.
const EPISODE_FILES: [&str; 4] = ["mcap", "osm", "actions.json", "models.jsonl"];

/// Creates the folder of a run, or removes the files of an earlier run from it and nothing else.
/// An interrupted run must not leave a mixture of two runs.
pub(super) fn create_folder(out: &Path) -> Result<(), BenchError> {
    let folder = out.join(EPISODES);
    std::fs::create_dir_all(&folder).map_err(|e| BenchError::file(&folder, e))?;
    for name in FILES {
        remove_if_present(&out.join(name))?;
    }
    // All numbers, not those of this run only: the earlier run may have had more episodes.
    for entry in std::fs::read_dir(&folder).map_err(|e| BenchError::file(&folder, e))? {
        let path = entry.map_err(|e| BenchError::file(&folder, e))?.path();
        let name = path.file_name().and_then(|name| name.to_str());
        if name.is_some_and(is_episode_file) {
            remove_if_present(&path)?;
        }
    }
    Ok(())
}

/// Whether a file has the name of an episode's file: a number of three digits or more, a dot and a
/// known ending.
fn is_episode_file(name: &str) -> bool {
    let (number, kind) = name.split_once('.').unwrap_or_default();
    let is_number = number.len() >= 3 && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number && EPISODE_FILES.contains(&kind)
}

fn remove_if_present(path: &Path) -> Result<(), BenchError> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(BenchError::file(path, e)),
        _ => Ok(()),
    }
}

/// The map of earlier doors with which the agents of a recorded run started; `None` if it had none.
///
/// # Errors
/// [`BenchError::BadFile`] if the map cannot be read.
pub fn memory_of(run: &Path) -> Result<Option<OsmData>, BenchError> {
    let path = run.join(MEMORY_BEFORE);
    let bad = |e: OsmError| BenchError::bad_file(&path, e);
    path.exists()
        .then(|| OsmData::read(&path).map_err(bad))
        .transpose()
}

/// The file with the models' answers in an episode.
pub(super) fn exchanges_path(out: &Path, number: usize) -> PathBuf {
    episode_path(out, number, "models.jsonl")
}

/// The log of an episode.
pub(super) fn log_path(out: &Path, number: usize) -> PathBuf {
    episode_path(out, number, "mcap")
}

fn episode_path(out: &Path, number: usize, ending: &str) -> PathBuf {
    out.join(EPISODES).join(format!("{number:03}.{ending}"))
}

/// Writes the files of a finished run; logs and recordings were written during the episodes.
pub(super) fn write_files(
    request: &RunRequest<'_>,
    out: &Path,
    traces: &[EpisodeTrace],
    results: &Results,
) -> Result<(), BenchError> {
    for (number, trace) in traces.iter().enumerate() {
        if let Some(map) = &trace.map {
            write(&episode_path(out, number, "osm"), map)?;
        }
    }
    if let Some(memory) = request.memory {
        write(&out.join(MEMORY_BEFORE), &memory.to_xml())?;
    }
    run_record(request).write(out)?;
    let input = report_input(request.prepared, results, traces, request.command);
    write(&out.join("report.html"), report::render(&input).as_bytes())?;
    // Last: a folder with results is complete.
    Ok(results.write(&out.join("results.json"))?)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), BenchError> {
    write_atomically(path, bytes).map_err(|e| BenchError::bad_file(path, e))
}

fn run_record(request: &RunRequest<'_>) -> RunRecord {
    RunRecord {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        suite: request.prepared.suite.clone(),
        agent: request.agent.to_owned(),
        settings: request.settings.clone(),
        seed: request.seed,
        episodes: request.prepared.episodes.len(),
        truth: request.prepared.truth.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_an_earlier_run_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        create_folder(folder.path()).unwrap();
        let ours = [
            "results.json",
            "episodes/000.mcap",
            "episodes/1000.actions.json",
        ];
        let others = [
            "notes.txt",
            "episodes/00.mcap",
            "episodes/000.mcap.bak",
            "episodes/a00.osm",
        ];
        for name in ours.iter().chain(&others) {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        create_folder(folder.path()).unwrap();
        for name in ours {
            assert!(!folder.path().join(name).exists(), "{name}");
        }
        for name in others {
            assert!(folder.path().join(name).exists(), "{name}");
        }
    }
}
