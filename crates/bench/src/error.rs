//! What can go wrong with a run as a whole. A delivery that fails is a result, not an error.

use std::path::{Path, PathBuf};

use openbench_core::MapPoint;

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
    #[error("there is no agent `{name}`; there are {}", known.join(", "))]
    UnknownAgent {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// An agent cannot be made.
    #[error("the agent `{name}` cannot be made: {problem}")]
    Agent {
        /// Which.
        name: String,
        /// Why.
        problem: String,
    },
    /// The world cannot be made.
    #[error("{0}")]
    World(String),
    /// A file cannot be opened or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file holds something else than expected.
    #[error("{}: {problem}", path.display())]
    BadFile {
        /// Which.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
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
        Self::File { path: path.to_owned(), source }
    }
}
