//! What can go wrong with a run as a whole. A delivery that fails is a result, not an error.

use std::error::Error;
use std::path::{Path, PathBuf};

use openbench_core::{MapPoint, UnknownName};

/// Why a run cannot be made or checked.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// No suite of that name.
    #[error("there is no suite `{name}`; built in are {}; or name a suite file (.toml)", known.join(", "))]
    UnknownSuite {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// No agent of that name.
    #[error(transparent)]
    UnknownAgent(#[from] UnknownName),
    /// An agent cannot be made.
    #[error("the agent `{name}` cannot be made")]
    Agent {
        /// Which.
        name: String,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The world cannot be made.
    #[error(transparent)]
    World(Box<dyn Error + Send + Sync>),
    /// A file cannot be opened or written.
    #[error("cannot access {}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file holds something else than expected.
    #[error("{} cannot be used", path.display())]
    BadFile {
        /// Which.
        path: PathBuf,
        /// What is wrong, and where.
        source: Box<dyn Error + Send + Sync>,
    },
    /// A file that is not in the expected format.
    #[error("{} is no {expected}", path.display())]
    WrongFormat {
        /// Which.
        path: PathBuf,
        /// What it ought to be.
        expected: &'static str,
        /// What is wrong, and where.
        source: Box<dyn Error + Send + Sync>,
    },
    /// An instruction in which nothing to deliver was found.
    #[error(
        "episode {episode}: no delivery was found in `{instruction}`; give the true positions with --truth, or name building and unit"
    )]
    NothingToDeliver {
        /// Which episode, from 0.
        episode: usize,
        /// What it says.
        instruction: String,
    },
    /// No episode of that number.
    #[error("there is no episode {episode}: the suite has {count}, numbered from 0")]
    NoSuchEpisode {
        /// What was asked for, from 0.
        episode: usize,
        /// How many there are.
        count: usize,
    },
    /// A truth is no door of the world.
    #[error("{}:{line}: ({}, {}) is no door of the world; the nearest is {nearest}, {away:.2} m away", path.display(), at.x, at.y)]
    NoSuchTruth {
        /// The truth file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// What it says.
        at: MapPoint,
        /// The door nearest to it.
        nearest: String,
        /// How far that is, metres.
        away: f64,
    },
    /// The log of an episode cannot be written.
    #[error(transparent)]
    Log(#[from] openbench_logs::LogError),
    /// Results cannot be written or read.
    #[error(transparent)]
    Results(#[from] crate::score::results::ResultsError),
    /// A run does not repeat.
    #[error("episode {episode} differs from its recording: {detail}")]
    Differs {
        /// Which episode, from 0.
        episode: usize,
        /// What differs, and when.
        detail: String,
    },
}

impl BenchError {
    /// An error of the file system.
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            source,
        }
    }

    /// A file that holds something else than expected.
    pub fn bad_file(path: &Path, problem: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::BadFile {
            path: path.to_owned(),
            source: problem.into(),
        }
    }

    /// A file that is not in the expected format, such as a `suite`.
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

    /// A world that cannot be made.
    pub fn world(problem: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::World(problem.into())
    }
}
