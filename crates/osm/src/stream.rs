//! A map file that is visited without keeping its elements, for users who need little of a large
//! file.

use std::path::Path;

use crate::data::OsmData;
use crate::error::OsmError;
use crate::pbf;
use crate::read::file_bytes;
use crate::visitor::{Elements, Visitor};

/// A map as a file holds it. Elements come in file order from PBF, and by number from XML.
#[derive(Debug)]
pub enum Source {
    /// The bytes of a PBF file, which are decompressed again on each visit.
    Pbf(Vec<u8>),
    /// Data in memory.
    Data(OsmData),
}

impl Source {
    /// Opens OSM XML or PBF. The first bytes decide the format, not the name. XML is read whole.
    ///
    /// # Errors
    /// If the file cannot be read, or is malformed XML. Malformed PBF shows when it is visited.
    pub fn open(path: &Path) -> Result<Self, OsmError> {
        let bytes = file_bytes(path)?;
        Self::from_bytes(bytes).map_err(|error| error.in_file(path))
    }

    /// OSM XML or PBF. The first bytes decide the format.
    ///
    /// # Errors
    /// If the bytes are malformed XML. Malformed PBF shows when it is visited.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, OsmError> {
        if pbf::looks_like_pbf(&bytes) {
            Ok(Self::Pbf(bytes))
        } else {
            OsmData::from_xml(&bytes).map(Self::Data)
        }
    }
}

impl Elements for Source {
    fn visit(&self, visitor: &mut impl Visitor) -> Result<(), OsmError> {
        match self {
            Self::Pbf(bytes) => pbf::read(bytes, visitor),
            Self::Data(data) => data.visit(visitor),
        }
    }
}
