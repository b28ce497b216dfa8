//! Why files of a map server cannot be read or written.

use std::io;
use std::path::PathBuf;

use openbench_osm::OsmError;

/// Most pixels in a row or column.
pub(super) const MOST_PIXELS: u32 = 10_000;

/// Files of a map server cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapServerError {
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A path that is no plain file: a folder, a device or a pipe, which could block for ever.
    #[error("{} is not a regular file; give the path of one", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// A file is too long to be what it should be.
    #[error("{} is longer than {most} bytes; it is not read", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// The most that is read, bytes.
        most: u64,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] OsmError),
    /// The description is not YAML, or lacks something.
    #[error("{} is no description of a map", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong, and in which line.
        source: Box<serde_saphyr::Error>,
    },
    /// A description cannot be written as YAML.
    #[error("the description for {} cannot be written as YAML", path.display())]
    Yaml {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<serde_saphyr::SerializeError>,
    },
    /// A value that makes no sense.
    #[error("{}: `{key}` is {value}; {wanted}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The key of the value.
        key: &'static str,
        /// What it is.
        value: String,
        /// What it has to be.
        wanted: &'static str,
    },
    /// The image cannot be decoded or encoded, or is too large.
    #[error("{}: the image cannot be used", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: image::ImageError,
    },
    /// The description would have the name of its image.
    #[error("{} is the name of the image; give a name that ends in `.yaml`", path.display())]
    SameName {
        /// The path that was given.
        path: PathBuf,
    },
    /// The grid has no cells, or not as many as its sides say.
    #[error(
        "a grid of {width} by {height} cells with {cells} values cannot be written; give a value \
         for each cell, and at most {MOST_PIXELS} in a row"
    )]
    Shape {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Values.
        cells: usize,
    },
}
