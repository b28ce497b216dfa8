//! Reads OSM data from a file or from bytes, XML or PBF.

use std::path::Path;

use openbench_core::input;

use crate::data::OsmData;
use crate::error::OsmError;
use crate::{pbf, xml};

impl OsmData {
    /// Reads OSM XML or PBF from a file. The first bytes decide the format, not the name.
    ///
    /// # Errors
    /// If the file cannot be read or is malformed; the error names the file and the place in it.
    pub fn read(path: &Path) -> Result<Self, OsmError> {
        let bytes = file_bytes(path)?;
        Self::from_bytes(&bytes).map_err(|error| error.in_file(path))
    }

    /// Reads OSM XML or PBF. The first bytes decide the format.
    ///
    /// # Errors
    /// If the bytes are malformed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OsmError> {
        if pbf::looks_like_pbf(bytes) {
            Self::from_pbf(bytes)
        } else {
            Self::from_xml(bytes)
        }
    }

    /// Reads OSM XML as the API 0.6, Overpass and JOSM write it.
    ///
    /// # Errors
    /// If the bytes are malformed. Document type declarations are refused.
    pub fn from_xml(bytes: &[u8]) -> Result<Self, OsmError> {
        let mut data = xml::read(bytes)?;
        data.count_missing();
        Ok(data)
    }

    /// Reads OSM PBF.
    ///
    /// # Errors
    /// If the bytes are malformed, or the file requires a feature that is not supported.
    pub fn from_pbf(bytes: &[u8]) -> Result<Self, OsmError> {
        let mut data = Self::default();
        pbf::read(bytes, &mut data)?;
        data.count_missing();
        Ok(data)
    }
}

/// Maps are read as a whole. Those of countries have up to a few gigabytes.
const LARGEST_MAP_BYTES: u64 = 8 << 30;

/// All bytes of a file.
pub(crate) fn file_bytes(path: &Path) -> Result<Vec<u8>, OsmError> {
    input::read(path, LARGEST_MAP_BYTES).map_err(|source| OsmError::Io {
        doing: "read",
        path: path.to_owned(),
        source,
    })
}
