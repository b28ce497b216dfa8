//! Why a world could not be imported: what, where, and what to do.
//!
//! No text repeats its source: `openbench_core::with_causes` prints both.

use std::fmt;
use std::io;
use std::num::{ParseFloatError, ParseIntError};
use std::path::{Path, PathBuf};

use openbench_osm::{OsmError, ProjectionError};

/// A world that cannot be imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: io::Error,
    },
    /// A file violates its format, or ends too early.
    #[error("{}:{line}:{column}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// The violation.
        problem: String,
    },
    /// A file is not well-formed XML.
    #[error(
        "{}:{line}:{column}: this is not well-formed XML; the file may be truncated",
        path.display()
    )]
    Xml {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// What the parser reports.
        source: roxmltree::Error,
    },
    /// A line of a Wavefront OBJ file is broken.
    #[error("{}:{line}:1: this line cannot be used", path.display())]
    Obj {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u32,
        /// What is wrong in it.
        source: ObjError,
    },
    /// A file is not STL.
    #[error("{}: this is not STL", path.display())]
    Stl {
        /// The file.
        path: PathBuf,
        /// What the parser reports.
        source: io::Error,
    },
    /// An image cannot be decoded.
    #[error("{}: cannot read this image", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What the decoder reports.
        source: image::ImageError,
    },
    /// A mesh or an image cannot be used.
    #[error("{}: {problem}", path.display())]
    Asset {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A model or mesh is in no folder of the search path.
    #[error(
        "model `{model}` needs `{uri}`, which is not there; looked in {}; name the folder that \
         holds it with --models",
        SearchList(searched)
    )]
    Missing {
        /// The model that refers to it.
        model: String,
        /// The reference.
        uri: String,
        /// Folders that were searched.
        searched: Vec<PathBuf>,
    },
    /// A file exceeds a limit.
    #[error("{}: more than {limit} {what}; a world of this size is refused", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What exceeds the limit.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// The map cannot be read.
    #[error(transparent)]
    Map(#[from] OsmError),
    /// The map has no usable position on the Earth.
    #[error("{}: the map has no usable position on the Earth", path.display())]
    Georeference {
        /// The map.
        path: PathBuf,
        /// Why not.
        source: ProjectionError,
    },
    /// The map has no building to deliver to.
    #[error(
        "{}: the map has no buildings; give the map of this world's buildings (ways with \
         building=*)",
        path.display()
    )]
    NoBuildings {
        /// The map.
        path: PathBuf,
    },
    /// The world has no door to deliver to.
    #[error(
        "{}: the world has no doors: no model is named text_model1, text_model2, …, which mark the \
         doors of units 1, 2, …",
        path.display()
    )]
    NoDoors {
        /// The world.
        path: PathBuf,
    },
}

/// What is wrong in a line of a Wavefront OBJ file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// A word should be a number.
    #[error("`{word}` is not a number")]
    Number {
        /// The word.
        word: String,
        /// The reason.
        source: ParseFloatError,
    },
    /// The line ends too early.
    #[error("{needed} numbers are needed here")]
    TooFewNumbers {
        /// Number of numbers.
        needed: usize,
    },
    /// A word should be an index.
    #[error("`{word}` is not an index")]
    Index {
        /// The word.
        word: String,
        /// The reason.
        source: ParseIntError,
    },
    /// An index refers to nothing.
    #[error("index {index} is not among {count}")]
    OutOfRange {
        /// The index, from 1, or from the end if negative.
        index: i64,
        /// Number of elements so far.
        count: usize,
    },
    /// The mesh is too large.
    #[error("this mesh has more than {limit} triangles")]
    TooManyTriangles {
        /// The limit.
        limit: usize,
    },
}

struct SearchList<'a>(&'a [PathBuf]);

impl fmt::Display for SearchList<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "no folder at all");
        }
        let folders: Vec<String> = self.0.iter().map(|p| p.display().to_string()).collect();
        write!(f, "{}", folders.join(", "))
    }
}

impl ImportError {
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn asset(path: &Path, problem: impl Into<String>) -> Self {
        Self::Asset {
            path: path.to_owned(),
            problem: problem.into(),
        }
    }

    pub(crate) fn too_large(path: &Path, what: &'static str, limit: usize) -> Self {
        Self::TooLarge {
            path: path.to_owned(),
            what,
            limit: limit as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_model_names_itself_its_file_and_the_folders() {
        let error = ImportError::Missing {
            model: "fountain_3".into(),
            uri: "model://fountain/meshes/fountain.dae".into(),
            searched: vec!["models".into(), "more".into()],
        };
        let text = error.to_string();
        for part in [
            "fountain_3",
            "model://fountain/meshes/fountain.dae",
            "models, more",
            "--models",
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}
