//! Why a world could not be imported: what, where, and what to do.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use openbench_osm::{OsmError, ProjectionError};

/// A world that cannot be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file system refused.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A file is not what it claims to be, or ends too early.
    #[error("{}:{line}:{column}: {problem}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// What is wrong there.
        problem: String,
    },
    /// A mesh or an image cannot be read.
    #[error("{}: {problem}", path.display())]
    Asset {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A model or mesh is in no folder of the search path.
    #[error(
        "model `{model}` needs `{uri}`, which is not there; looked in {}; name the folder that holds it with --models",
        SearchList(searched)
    )]
    Missing {
        /// The model that asks for it.
        model: String,
        /// What it asks for.
        uri: String,
        /// Where it was looked for.
        searched: Vec<PathBuf>,
    },
    /// A file asks for more than an importer should give.
    #[error("{}: more than {limit} {what}; a world of this size is refused", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What there is too much of.
        what: &'static str,
        /// How much there may be.
        limit: u64,
    },
    /// The map cannot be read.
    #[error(transparent)]
    Map(#[from] OsmError),
    /// The map does not say where it lies.
    #[error("{}: {source}", path.display())]
    Georeference {
        /// The map.
        path: PathBuf,
        /// Why not.
        source: ProjectionError,
    },
    /// The map has no building to deliver to.
    #[error("{}: the map has no buildings; give the map of this world's buildings (ways with building=*)", path.display())]
    NoBuildings {
        /// The map.
        path: PathBuf,
    },
    /// The world has no door to deliver to.
    #[error(
        "{}: the world has no doors: no model is named text_model1, text_model2, …, which mark the doors of units 1, 2, …",
        path.display()
    )]
    NoDoors {
        /// The world.
        path: PathBuf,
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
