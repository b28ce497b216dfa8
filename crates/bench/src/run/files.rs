//! The files of a run: names, reading, writing.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use openbench_core::input;
use openbench_osm::write_atomically;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::BenchError;
use crate::score::Results;

/// Bound for recordings, results and maps of a run. That of an hour has a few megabytes.
const MOST_BYTES: u64 = 256 << 20;
/// Name of the file with the parameters.
pub(super) const RUN: &str = "run.json";
/// Name of the file with the results.
pub(super) const RESULTS: &str = Results::FILE;
/// Name of the file with the report.
pub(super) const REPORT: &str = "report.html";
/// Folder, in a run's folder, with the files of the episodes.
pub(super) const EPISODES: &str = "episodes";
/// Endings of an episode's files, after its number.
const EPISODE_FILES: [&str; 4] = ["mcap", "osm", "actions.json", "models.jsonl"];

/// Reads a JSON file; `expected` names its content in errors.
pub(super) fn read_json<T: DeserializeOwned>(
    path: &Path,
    expected: &'static str,
) -> Result<T, BenchError> {
    serde_json::from_slice(&read_file(path)?)
        .map_err(|e| BenchError::wrong_format(path, expected, e))
}

/// Writes a JSON file atomically.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), BenchError> {
    let json = serde_json::to_vec(value).map_err(|e| BenchError::bad_file(path, e))?;
    write_file(path, &json)
}

/// Writes a file atomically.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), BenchError> {
    write_atomically(path, bytes).map_err(|e| BenchError::bad_file(path, e))
}

/// Reads a file.
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, BenchError> {
    input::read(path, MOST_BYTES).map_err(|e| BenchError::file(path, e))
}

/// Whether a file has the name of an episode's file: a number of three digits or more, a dot and a
/// known ending.
pub(super) fn is_episode_file(name: &str) -> bool {
    let (number, kind) = name.split_once('.').unwrap_or_default();
    let is_number = number.len() >= 3 && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number && EPISODE_FILES.contains(&kind)
}

/// Removes what an interrupted run left of an episode.
pub(super) fn remove_files_of(run: &Path, number: usize) -> Result<(), BenchError> {
    for ending in EPISODE_FILES {
        let path = episode_path(run, number, ending);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(BenchError::file(&path, e)),
            _ => {}
        }
    }
    Ok(())
}

/// The file with the models' answers in an episode.
pub(super) fn exchanges_path(run: &Path, number: usize) -> PathBuf {
    episode_path(run, number, "models.jsonl")
}

/// The log of an episode.
pub(super) fn log_path(run: &Path, number: usize) -> PathBuf {
    episode_path(run, number, "mcap")
}

/// The agent's copy of the map in an episode.
pub(super) fn map_path(run: &Path, number: usize) -> PathBuf {
    episode_path(run, number, "osm")
}

fn episode_path(run: &Path, number: usize, ending: &str) -> PathBuf {
    run.join(EPISODES).join(format!("{number:03}.{ending}"))
}

/// The actions of an episode.
pub(super) fn actions_path(run: &Path, number: usize) -> PathBuf {
    episode_path(run, number, "actions.json")
}
