//! Why map data could not be read, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A failure to read or write map data.
#[derive(Debug, thiserror::Error)]
pub enum OsmError {
    /// The file system refused.
    #[error("cannot {doing} {}: {source}", path.display())]
    Io {
        /// `read` or `write`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The bytes are not the map data that they claim to be.
    #[error("{}{place}: {problem}", in_file(file))]
    Malformed {
        /// The file, if the bytes came from one.
        file: Option<PathBuf>,
        /// Where in it.
        place: Place,
        /// What is wrong and what to do, in words.
        problem: String,
    },
}

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(usize),
    /// An offset in bytes, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

impl OsmError {
    pub(crate) fn malformed(place: Place, problem: impl Into<String>) -> Self {
        Self::Malformed {
            file: None,
            place,
            problem: problem.into(),
        }
    }

    /// The same failure, said of the file at `path`.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Malformed { place, problem, .. } => Self::Malformed {
                file: Some(path.to_owned()),
                place,
                problem,
            },
            io => io,
        }
    }
}

fn in_file(file: &Option<PathBuf>) -> String {
    file.as_ref()
        .map_or_else(String::new, |path| format!("{}: ", path.display()))
}
