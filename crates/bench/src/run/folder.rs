//! The folder of a run.
//!
//! | file | content |
//! |---|---|
//! | `run.json` | the [`RunRecord`]: the parameters, sufficient to repeat the run |
//! | `results.json` | the [`Results`](crate::Results) |
//! | `report.html` | the same with maps, for people |
//! | [`MEMORY_BEFORE`] | the doors known before the run, if there were any |
//! | `episodes/000.actions.json` | the [`Recording`](super::recording::Recording) of an episode |
//! | `episodes/000.mcap` | its log |
//! | `episodes/000.osm` | the agent's copy of the map, if it edits one |
//! | `episodes/000.models.jsonl` | the answers of models, if it asked any |
//! | `.lock` | held by the process that runs here |
//!
//! A run in progress has the same files in the folder [`UNFINISHED`] inside. When it is complete,
//! a list of them is written there, and they take the places of the files of the run before. A
//! process that ends in the middle of that leaves the list, so that the next one can go on.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use openbench_osm::{OsmData, OsmError, is_staging_of};

use super::files::{
    EPISODES, REPORT, RESULTS, RUN, actions_path, is_episode_file, read_json, write_file,
    write_json,
};
use super::record::RunRecord;
use super::request::RunRequest;
use crate::BenchError;

/// Name of the file, in a run's folder, with the doors known before the run.
pub const MEMORY_BEFORE: &str = "memory-before.osm";
/// Name of the folder, in a run's folder, with the files of a run that is not complete.
pub const UNFINISHED: &str = "unfinished";

/// Files of a run besides those of its episodes. Results come last: they take their place when
/// all else is there.
const FILES: [&str; 4] = [RUN, REPORT, MEMORY_BEFORE, RESULTS];
/// Name of the list of the files of a complete run that has not taken its place yet.
const COMPLETE: &str = "complete.json";
/// Name of the lock's file.
const LOCK: &str = ".lock";

/// The folder of a run, for one process at a time.
#[derive(Debug)]
pub(super) struct RunFolder {
    out: PathBuf,
    /// Locked as long as it is open.
    _lock: File,
}

impl RunFolder {
    /// Creates the folder, keeps other processes out of it, and completes the exchange of files
    /// that another process did not.
    ///
    /// # Errors
    /// [`BenchError::Busy`] while another process runs there, a folder that cannot be written, or a
    /// damaged list of files.
    pub(super) fn lock(out: &Path) -> Result<Self, BenchError> {
        let folder = Self::hold(out)?;
        if let Some(files) = complete_files(out)? {
            folder.exchange(&files)?;
        }
        Ok(folder)
    }

    /// As [`lock`](Self::lock), but what remains of an incomplete run is removed, even if it is
    /// damaged. A complete run still takes its place.
    ///
    /// # Errors
    /// As [`lock`](Self::lock), except for a damaged list.
    pub(super) fn lock_and_discard(out: &Path) -> Result<Self, BenchError> {
        let folder = Self::hold(out)?;
        match complete_files(out) {
            Ok(Some(files)) => folder.exchange(&files)?,
            Ok(None) | Err(_) => folder.discard()?,
        }
        Ok(folder)
    }

    fn hold(out: &Path) -> Result<Self, BenchError> {
        std::fs::create_dir_all(out).map_err(|e| BenchError::file(out, e))?;
        let path = out.join(LOCK);
        let failed = |e| BenchError::file(&path, e);
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(BenchError::Busy {
                    folder: out.to_owned(),
                });
            }
            Err(TryLockError::Error(e)) => return Err(failed(e)),
        }
        Ok(Self {
            out: out.to_owned(),
            _lock: file,
        })
    }

    /// Removes what an interrupted run has left.
    ///
    /// # Errors
    /// Files that no run has written: they are somebody's own.
    fn discard(&self) -> Result<(), BenchError> {
        let folder = self.unfinished();
        if let Some(path) = foreign_file(&folder)? {
            let problem = "no run has written it, and it would be removed; move it away, or choose \
                           another folder with --out";
            return Err(BenchError::bad_file(&path, problem));
        }
        match std::fs::remove_dir_all(&folder) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(BenchError::file(&folder, e)),
            _ => Ok(()),
        }
    }

    /// A file that has the name of a run's file, in a folder in which no run has ended.
    fn foreign_results(&self) -> Result<Option<PathBuf>, BenchError> {
        if self.out.join(RUN).exists() {
            return Ok(None);
        }
        let found = run_files(&self.out)?.into_iter().next();
        Ok(found.map(|name| self.out.join(name)))
    }

    /// The folder of the run in progress.
    pub(super) fn unfinished(&self) -> PathBuf {
        self.out.join(UNFINISHED)
    }

    /// Begins a run: nothing of an interrupted one remains.
    pub(super) fn begin(
        &self,
        record: &RunRecord,
        memory: Option<&OsmData>,
    ) -> Result<(), BenchError> {
        if let Some(path) = self.foreign_results()? {
            let problem = "there is no run.json beside it, so no run has written it, and it would \
                           be replaced or removed; choose another folder with --out";
            return Err(BenchError::bad_file(&path, problem));
        }
        self.discard()?;
        let folder = self.unfinished();
        let episodes = folder.join(EPISODES);
        std::fs::create_dir_all(&episodes).map_err(|e| BenchError::file(&episodes, e))?;
        if let Some(memory) = memory {
            write_file(&folder.join(MEMORY_BEFORE), &memory.to_xml())?;
        }
        // Last: a run with its record can be resumed.
        record.write(&folder)
    }

    /// Leaves a run that has failed. Without a finished episode, nothing of it is worth keeping.
    pub(super) fn abandon(&self) {
        let left = interrupted_in(&self.out);
        if left.is_ok_and(|left| left.is_none_or(|left| left.finished == 0)) {
            // The error that ended the run is the one to report.
            let _ = std::fs::remove_dir_all(self.unfinished());
        }
    }

    /// Puts the files of the complete run in the places of those of the run before.
    pub(super) fn publish(&self) -> Result<(), BenchError> {
        let folder = self.unfinished();
        let files = run_files(&folder)?;
        write_json(&folder.join(COMPLETE), &files)?;
        self.exchange(&files)
    }

    /// Moves the files of a complete run. It can be repeated from any point.
    fn exchange(&self, files: &BTreeSet<String>) -> Result<(), BenchError> {
        let folder = self.unfinished();
        let episodes = self.out.join(EPISODES);
        std::fs::create_dir_all(&episodes).map_err(|e| BenchError::file(&episodes, e))?;
        let results = |name: &String| name.as_str() == RESULTS;
        let others = files.iter().filter(|name| !results(name));
        // Results last.
        for name in others.chain(files.iter().filter(|name| results(name))) {
            let (from, to) = (folder.join(name), self.out.join(name));
            match std::fs::rename(&from, &to) {
                // Moved before.
                Err(e) if e.kind() == ErrorKind::NotFound && to.exists() => {}
                Err(e) => return Err(BenchError::file(&to, e)),
                Ok(()) => {}
            }
        }
        for name in run_files(&self.out)?.difference(files) {
            let path = self.out.join(name);
            std::fs::remove_file(&path).map_err(|e| BenchError::file(&path, e))?;
        }
        std::fs::remove_dir_all(&folder).map_err(|e| BenchError::file(&folder, e))
    }
}

/// The files of a complete run that has not taken its place yet.
fn complete_files(out: &Path) -> Result<Option<BTreeSet<String>>, BenchError> {
    let path = out.join(UNFINISHED).join(COMPLETE);
    if !path.exists() {
        return Ok(None);
    }
    let files: BTreeSet<String> = read_json(&path, "list of the files of a run")?;
    // The list is a file like any other: it must not lead out of the folder.
    let strange = files.iter().find(|name| !is_file_of_run(name));
    match strange {
        Some(name) => Err(BenchError::bad_file(
            &path,
            format!("`{name}` is no file of a run; remove the folder {UNFINISHED}"),
        )),
        None => Ok(Some(files)),
    }
}

/// The files of a run in a folder, relative to it.
pub(super) fn run_files(folder: &Path) -> Result<BTreeSet<String>, BenchError> {
    let mut files: BTreeSet<String> = FILES
        .iter()
        .filter(|name| folder.join(name).exists())
        .map(|name| (*name).to_owned())
        .collect();
    let episodes = folder.join(EPISODES);
    let entries = match std::fs::read_dir(&episodes) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(files),
        entries => entries.map_err(|e| BenchError::file(&episodes, e))?,
    };
    for entry in entries {
        let name = entry
            .map_err(|e| BenchError::file(&episodes, e))?
            .file_name();
        // All numbers: the run before may have had more episodes.
        if let Some(name) = name.to_str().filter(|name| is_episode_file(name)) {
            files.insert(format!("{EPISODES}/{name}"));
        }
    }
    Ok(files)
}

/// A file in the folder of a run in progress that no run writes there.
fn foreign_file(unfinished: &Path) -> Result<Option<PathBuf>, BenchError> {
    let is_ours = |name: &str| {
        let mut names = [COMPLETE].into_iter().chain(FILES);
        // A process that was killed while it wrote leaves a staging file.
        name == EPISODES || names.any(|own| name == own || is_staging_of(own, name))
    };
    let is_of_episode = |name: &str| {
        let own = name.strip_suffix(".partial").unwrap_or(name);
        let staged = name.strip_prefix('.').and_then(|rest| {
            let (own, _) = rest.strip_suffix(".part")?.rsplit_once('.')?;
            is_staging_of(own, name).then_some(own)
        });
        is_episode_file(staged.unwrap_or(own))
    };
    let found = foreign_in(unfinished, is_ours)?;
    Ok(match found {
        None => foreign_in(&unfinished.join(EPISODES), is_of_episode)?,
        found => found,
    })
}

/// The first file in a folder whose name is none of ours; `None` without the folder.
fn foreign_in(
    folder: &Path,
    is_ours: impl Fn(&str) -> bool,
) -> Result<Option<PathBuf>, BenchError> {
    let failed = |e| BenchError::file(folder, e);
    let entries = match std::fs::read_dir(folder) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        entries => entries.map_err(failed)?,
    };
    for entry in entries {
        let name = entry.map_err(failed)?.file_name();
        if !name.to_str().is_some_and(&is_ours) {
            return Ok(Some(folder.join(name)));
        }
    }
    Ok(None)
}

fn is_file_of_run(name: &str) -> bool {
    let episode = name
        .strip_prefix(EPISODES)
        .and_then(|rest| rest.strip_prefix('/'));
    FILES.contains(&name) || episode.is_some_and(is_episode_file)
}

/// The run that was interrupted in a folder.
#[derive(Debug)]
pub struct InterruptedRun {
    /// Its parameters.
    pub record: RunRecord,
    /// The doors that its agents knew.
    pub memory: Option<OsmData>,
    /// Number of episodes that it has finished.
    pub finished: usize,
}

impl InterruptedRun {
    /// Whether a request runs what is missing of it.
    ///
    /// # Errors
    /// A request that has no record.
    pub fn is_continued_by(&self, request: &RunRequest<'_>) -> Result<bool, BenchError> {
        Ok(self.record.difference(&RunRecord::of(request)?).is_none())
    }
}

/// The interrupted run in the folder `out`; `None` if there is none that can be resumed. A complete
/// run whose files were not exchanged to the end takes its place first.
///
/// # Errors
/// [`BenchError::Busy`] while another process runs there, or a file that is damaged.
pub fn interrupted(out: &Path) -> Result<Option<InterruptedRun>, BenchError> {
    if !out.join(UNFINISHED).exists() {
        return Ok(None);
    }
    RunFolder::lock(out)?;
    interrupted_in(out)
}

/// The interrupted run in a folder that is locked.
pub(super) fn interrupted_in(out: &Path) -> Result<Option<InterruptedRun>, BenchError> {
    let folder = out.join(UNFINISHED);
    if !folder.join(RUN).exists() {
        return Ok(None);
    }
    let record = RunRecord::read(&folder)?;
    let finished = (0..record.episodes)
        .filter(|number| actions_path(&folder, *number).exists())
        .count();
    Ok(Some(InterruptedRun {
        memory: memory_of(&folder)?,
        record,
        finished,
    }))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn put(folder: &Path, names: &[&str], content: &str) {
        std::fs::create_dir_all(folder.join(EPISODES)).unwrap();
        for name in names {
            std::fs::write(folder.join(name), content).unwrap();
        }
    }

    fn holds(folder: &Path, name: &str, content: &str) -> bool {
        std::fs::read_to_string(folder.join(name)).is_ok_and(|found| found == content)
    }

    const OLD: [&str; 4] = [
        RESULTS,
        MEMORY_BEFORE,
        "episodes/000.mcap",
        "episodes/1000.actions.json",
    ];
    const NEW: [&str; 3] = [RESULTS, RUN, "episodes/000.actions.json"];
    const OTHERS: [&str; 4] = [
        "notes.txt",
        "episodes/00.mcap",
        "episodes/000.mcap.bak",
        "episodes/a00.osm",
    ];

    fn check_new_alone(out: &Path) {
        for name in NEW {
            assert!(holds(out, name, "new"), "{name}");
        }
        for name in OTHERS {
            assert!(holds(out, name, "mine"), "{name}");
        }
        for name in &OLD[1..] {
            assert!(!out.join(name).exists(), "{name}");
        }
        assert!(!out.join(UNFINISHED).exists());
    }

    #[test]
    fn a_complete_run_replaces_the_files_of_the_run_before_and_no_others() {
        let place = tempfile::tempdir().unwrap();
        let out = place.path();
        put(out, &OLD, "old");
        put(out, &OTHERS, "mine");
        let folder = RunFolder::lock(out).unwrap();
        put(&folder.unfinished(), &NEW, "new");
        folder.publish().unwrap();
        check_new_alone(out);
    }

    #[test]
    fn an_exchange_that_was_interrupted_is_completed() {
        for moved in 0..=NEW.len() {
            let place = tempfile::tempdir().unwrap();
            let out = place.path();
            put(out, &OLD, "old");
            put(out, &OTHERS, "mine");
            let unfinished = out.join(UNFINISHED);
            put(&unfinished, &NEW, "new");
            write_json(&unfinished.join(COMPLETE), &NEW).unwrap();
            for name in &NEW[..moved] {
                std::fs::rename(unfinished.join(name), out.join(name)).unwrap();
            }
            RunFolder::lock(out).unwrap();
            check_new_alone(out);
        }
    }

    #[test]
    fn nothing_is_removed_or_replaced_that_no_run_has_written() {
        let place = tempfile::tempdir().unwrap();
        let out = place.path();
        let own = out.join(UNFINISHED).join("suite.toml");
        std::fs::create_dir_all(out.join(UNFINISHED)).unwrap();
        std::fs::write(&own, "mine").unwrap();
        let error = RunFolder::lock_and_discard(out).unwrap_err().to_string();
        assert!(error.contains("suite.toml"), "{error}");
        std::fs::remove_file(&own).unwrap();
        let notes = out.join(UNFINISHED).join(EPISODES).join("notes.txt");
        put(&out.join(UNFINISHED), &["episodes/notes.txt"], "mine");
        let error = RunFolder::lock_and_discard(out).unwrap_err().to_string();
        assert!(error.contains("notes.txt"), "{error}");
        std::fs::remove_file(&notes).unwrap();
        // What a run was writing when it was killed is a run's.
        let killed = [
            ".run.json.4711.part",
            "episodes/000.mcap.partial",
            "episodes/.001.actions.json.4711.part",
        ];
        put(&out.join(UNFINISHED), &killed, "new");
        let folder = RunFolder::lock_and_discard(out).unwrap();
        assert!(!out.join(UNFINISHED).exists());
        assert_eq!(folder.foreign_results().unwrap(), None);
        for name in [REPORT, "episodes/007.mcap"] {
            put(out, &[name], "mine");
            assert_eq!(folder.foreign_results().unwrap(), Some(out.join(name)));
            std::fs::remove_file(out.join(name)).unwrap();
        }
        put(out, &[REPORT, RUN], "of a run");
        assert_eq!(folder.foreign_results().unwrap(), None);
    }

    #[test]
    fn a_list_that_leads_out_of_the_folder_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let unfinished = place.path().join(UNFINISHED);
        put(&unfinished, &NEW, "new");
        for name in ["../elsewhere", "episodes/../../000.osm", "/etc/passwd"] {
            write_json(&unfinished.join(COMPLETE), &[name]).unwrap();
            let error = RunFolder::lock(place.path()).unwrap_err();
            assert!(matches!(error, BenchError::BadFile { .. }), "{error}");
        }
    }

    #[test]
    fn a_folder_is_for_one_process_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let first = RunFolder::lock(place.path()).unwrap();
        let second = RunFolder::lock(place.path()).unwrap_err();
        assert!(matches!(second, BenchError::Busy { .. }), "{second}");
        drop(first);
        RunFolder::lock(place.path()).unwrap();
    }
}
