//! The runs of one system.

use std::path::{Path, PathBuf};

use crate::error::ResultsError;
use crate::score::Results;

/// Folders below a folder of runs that are searched for results.
const DEPTH: usize = 3;

/// A system: an agent with settings, in one run or in several.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// What people call it.
    pub name: String,
    /// The results of its runs.
    pub runs: Vec<Results>,
}

impl System {
    /// Reads a system: a file of results, the folder of a run, or a folder with such folders, such
    /// as `run --seeds` and `bench towns` write. What is left of unfinished runs is ignored.
    ///
    /// # Errors
    /// A file that is no file of results. A folder without results gives a system without runs.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let mut files = Vec::new();
        if path.is_file() {
            files.push(path.to_owned());
        } else {
            find(path, DEPTH, &mut files);
        }
        Ok(Self {
            name: path.display().to_string(),
            runs: files
                .iter()
                .map(|file| Results::read(file))
                .collect::<Result<_, _>>()?,
        })
    }
}

/// Finds the files of results in a folder: its own, or those of the folders in it.
fn find(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) {
    let own = folder.join(Results::FILE);
    if own.is_file() {
        found.push(own);
        return;
    }
    // A folder that cannot be read has no results, which is reported as such.
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut folders: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.is_dir() && !path.ends_with("unfinished"))
        .collect();
    folders.sort();
    if depth > 0 {
        for inner in folders {
            find(&inner, depth - 1, found);
        }
    }
}
