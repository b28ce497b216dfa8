//! The alphabet of the recognition network: one class on each line, the first one for the blank of
//! CTC.
//!
//! Version 4 has it in the metadata of the network, without the blank and without the space at its
//! end. Version 5 has it in a file, with both.

use std::path::Path;

use crate::error::{Cause, ReaderError};

/// Maximum length of a file, bytes.
const MAX_FILE_BYTES: u64 = 4 << 20;

/// The error for an alphabet without characters.
#[derive(Debug, thiserror::Error)]
#[error("an alphabet must have the blank and at least one character")]
pub(super) struct NoAlphabet;

/// Reads an alphabet. A line may be a space, so only line breaks are removed.
pub(super) fn read(file: &Path) -> Result<Vec<String>, ReaderError> {
    try_read(file).map_err(|source| ReaderError::Model {
        file: file.to_owned(),
        source,
    })
}

fn try_read(file: &Path) -> Result<Vec<String>, Cause> {
    let size = std::fs::metadata(file)?.len();
    if size > MAX_FILE_BYTES {
        return Err(format!("{size} bytes are too many for an alphabet").into());
    }
    let text = std::fs::read_to_string(file)?;
    Ok(check(text.lines().map(str::to_owned).collect())?)
}

/// The alphabet in the metadata of a network.
pub(super) fn from_metadata(characters: &str) -> Result<Vec<String>, NoAlphabet> {
    let characters = characters.trim_end_matches('\n').split('\n');
    check(
        // This entry is never printed: class 0 is skipped in decoding. It gives the classes their
        // indices.
        std::iter::once("blank")
            .chain(characters)
            .chain([" "])
            .map(str::to_owned)
            .collect(),
    )
}

fn check(keys: Vec<String>) -> Result<Vec<String>, NoAlphabet> {
    if keys.len() < 2 {
        Err(NoAlphabet)
    } else {
        Ok(keys)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blank_and_space_are_added_to_metadata() {
        assert_eq!(from_metadata("a\nb").unwrap(), ["blank", "a", "b", " "]);
        assert_eq!(from_metadata("a\nb\n").unwrap(), ["blank", "a", "b", " "]);
    }

    #[test]
    fn the_error_for_a_missing_file_names_it() {
        let error = read(Path::new("/nonexistent/keys.txt")).unwrap_err();
        assert!(error.to_string().contains("/nonexistent/keys.txt"));
    }
}
