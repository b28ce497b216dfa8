//! Errors of a whole run, and of its results file. A failed delivery is a result, not an error.

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::plural::count;
use openbench_core::{MapPoint, UnknownName};

/// An error that prevents a run or its verification.
///
/// `Display` does not repeat the source; [`with_causes`](openbench_core::with_causes) prints the
/// whole chain.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// Unknown suite name.
    #[error(
"there is no suite `{name}`; there are {}; or give a suite file (.toml) or a world folder",
known.join(", ")
)]
    UnknownSuite {
        /// The requested name.
        name: String,
        /// The names of the built-in suites and tracks.
        known: Vec<String>,
    },
    /// Unknown agent name.
    #[error(transparent)]
    UnknownAgent(#[from] UnknownName),
    /// An agent cannot be created.
    #[error("cannot create the agent `{name}`")]
    Agent {
        /// Name of the agent.
        name: String,
        /// The error of its factory.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The world cannot be built.
    #[error(transparent)]
    World(Box<dyn Error + Send + Sync>),
    /// A file cannot be read or written.
    #[error("cannot access {}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file has the expected format, but its content cannot be used.
    #[error("{} cannot be used", path.display())]
    BadFile {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what to do.
        source: Box<dyn Error + Send + Sync>,
    },
    /// A file is not in the expected format.
    #[error("{} is no {expected}", path.display())]
    WrongFormat {
        /// The file.
        path: PathBuf,
        /// The expected kind of file, for example `suite`.
        expected: &'static str,
        /// The error of the parser, with line and column.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The doors that an instruction requests are not known.
    #[error(
        "episode {episode}: nobody says which doors `{instruction}` requests; give a JSONL file \
         with annotations, the true positions with --truth, or let a planner of OPEN read them \
         with --targets planner"
    )]
    NothingToDeliver {
        /// Episode number, from 0.
        episode: usize,
        /// Its instruction.
        instruction: String,
    },
    /// The suite has no episode of that number.
    #[error("there is no episode {episode}: the suite has {count}, numbered from 0")]
    NoSuchEpisode {
        /// The requested number, from 0.
        episode: usize,
        /// Number of episodes in the suite.
        count: usize,
    },
    /// A true position is not at any door of the world.
    #[error(
"{}:{line}: ({}, {}) is no door of the world; the nearest is {nearest}, {away:.2} m away",
path.display(), at.x, at.y
)]
    NoSuchTruth {
        /// The truth file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// The position, in the `map` frame.
        at: MapPoint,
        /// Address of the nearest door.
        nearest: String,
        /// Distance to that door, metres.
        away: f64,
    },
    /// No model that a planner or reader asked has ever answered.
    #[error(
        "episode {episode}: {detail}; the run ends, since the model of the {part} has never \
         answered. To let another {part} stand in where it does not, name that after the model: \
         --set {part}=MODEL,OTHER"
    )]
    Unreachable {
        /// Episode number, from 0.
        episode: usize,
        /// What the agent reports.
        detail: String,
        /// The setting of the part that asked.
        part: &'static str,
    },
    /// The log of an episode cannot be written.
    #[error(transparent)]
    Log(#[from] openbench_logs::LogError),
    /// Results cannot be written or read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The run was asked to stop before its end.
    #[error("the run was interrupted")]
    Interrupted,
    /// Another process writes to the folder.
    #[error(
        "another run writes to {}; wait for its end, or choose another folder with --out",
        folder.display()
    )]
    Busy {
        /// The folder of the run.
        folder: PathBuf,
    },
    /// The folder contains a run that was interrupted.
    #[error(
        "{folder} contains an interrupted run with {finished} of {} finished; continue it with \
         `openbench run --resume {folder}`, or remove it with --discard",
        count(*episodes, "episode", "episodes"),
        folder = folder.display()
    )]
    Unfinished {
        /// The folder of the run.
        folder: PathBuf,
        /// Number of finished episodes.
        finished: usize,
        /// Number of all episodes.
        episodes: usize,
    },
    /// An interrupted run would continue otherwise than it began.
    #[error("the run in {} cannot be continued: {difference}", folder.display())]
    CannotResume {
        /// The folder of the run.
        folder: PathBuf,
        /// What is otherwise.
        difference: String,
    },
    /// A file of a run does not follow from its recordings.
    #[error("{} is not what the run gives: {detail}", path.display())]
    Altered {
        /// The file.
        path: PathBuf,
        /// The first difference.
        detail: String,
    },
    /// A repeated episode differs from its recording.
    #[error("episode {episode} differs from its recording: {detail}")]
    Differs {
        /// Episode number, from 0.
        episode: usize,
        /// The first difference and its time.
        detail: String,
    },
}

impl BenchError {
    /// An error of the file system for `path`.
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }

    /// A file whose content cannot be used.
    pub fn bad_file(path: &Path, problem: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::BadFile {
            path: path.to_owned(),
            source: problem.into(),
        }
    }

    /// A file that is not in the `expected` format, for example `suite`.
    pub fn wrong_format(
        path: &Path,
        expected: &'static str,
        source: impl Into<Box<dyn Error + Send + Sync>>,
    ) -> Self {
        Self::WrongFormat {
            path: path.to_owned(),
            expected,
            source: source.into(),
        }
    }

    /// A world that cannot be built.
    pub fn world(problem: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::World(problem.into())
    }
}

/// A results file that cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultsError {
    /// The file cannot be read or written.
    #[error("cannot access {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is no results file.
    #[error(
        "{}:{}:{} is no results.json of OpenBench",
        path.display(),
        source.line(),
        source.column()
    )]
    Json {
        /// The file.
        path: PathBuf,
        /// The error of the parser.
        source: serde_json::Error,
    },
}
