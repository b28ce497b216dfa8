//! Why map data could not be read or written, and where in it.
//!
//! No text repeats its source: `openbench_core::with_causes` prints both.

use std::borrow::Cow;
use std::error::Error;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A failure to read or write map data.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OsmError {
    /// The file system refused.
    #[error("cannot {doing} {}", path.display())]
    Io {
        /// `read` or `write`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The bytes are not valid map data.
    #[error("{}{place}: {problem}", in_file(file))]
    Malformed {
        /// The file, if the bytes came from one.
        file: Option<PathBuf>,
        /// The place in the file.
        place: Place,
        /// What is wrong and what to do about it.
        problem: String,
        /// The error of the XML parser or of the decompression, if it was one of these.
        source: Option<Box<dyn Error + Send + Sync>>,
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
    pub(crate) fn malformed(place: Place, problem: impl Into<Problem>) -> Self {
        let Problem { text, source } = problem.into();
        Self::Malformed {
            file: None,
            place,
            problem: text.into_owned(),
            source,
        }
    }

    /// The same failure, attributed to the file at `path`.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Malformed {
                place,
                problem,
                source,
                ..
            } => Self::Malformed {
                file: Some(path.to_owned()),
                place,
                problem,
                source,
            },
            io @ Self::Io { .. } => io,
        }
    }
}

fn in_file(file: &Option<PathBuf>) -> String {
    file.as_ref()
        .map_or_else(String::new, |path| format!("{}: ", path.display()))
}

/// What is wrong with some bytes, while their place in the file is not known yet.
#[derive(Debug)]
pub(crate) struct Problem {
    text: Cow<'static, str>,
    source: Option<Box<dyn Error + Send + Sync>>,
}

impl Problem {
    /// `what` went wrong because of `source`.
    pub(crate) fn caused(
        what: impl Into<Cow<'static, str>>,
        source: impl Error + Send + Sync + 'static,
    ) -> Self {
        Self {
            text: what.into(),
            source: Some(Box::new(source)),
        }
    }
}

impl From<&'static str> for Problem {
    fn from(text: &'static str) -> Self {
        Self {
            text: Cow::Borrowed(text),
            source: None,
        }
    }
}

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Self {
            text: Cow::Owned(text),
            source: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_of_a_malformed_file_is_kept() {
        let problem = Problem::caused(
            "this blob cannot be decompressed",
            io::Error::other("cut off"),
        );
        let error = OsmError::malformed(Place::Byte(7), problem).in_file("map.osm.pbf".as_ref());
        assert_eq!(
            error.to_string(),
            "map.osm.pbf: byte 7: this blob cannot be decompressed"
        );
        assert_eq!(error.source().unwrap().to_string(), "cut off");
    }
}
