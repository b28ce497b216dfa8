//! The recognition network's alphabet: one class a line, the first being CTC's blank. Version 4 keeps it in the network's metadata, without the
//! blank and the space at its end; version 5 in a file with both.

use std::path::Path;

use crate::error::{Cause, ReaderError};

/// Larger files are no alphabet, bytes.
const MAX_FILE: u64 = 4 << 20;

/// A text that is no alphabet.
#[derive(Debug, thiserror::Error)]
#[error("an alphabet needs the blank and at least one character")]
pub(super) struct NoAlphabet;

/// Reads an alphabet. Lines may be a single space; nothing is trimmed but the line break.
pub(super) fn read(file: &Path) -> Result<Vec<String>, ReaderError> {
    try_read(file).map_err(|source| ReaderError::Model { file: file.to_owned(), source })
}

fn try_read(file: &Path) -> Result<Vec<String>, Cause> {
    let size = std::fs::metadata(file)?.len();
    if size > MAX_FILE {
        return Err(format!("{size} bytes are more than any alphabet has").into());
    }
    let text = std::fs::read_to_string(file)?;
    Ok(check(text.lines().map(str::to_owned).collect())?)
}

/// The alphabet in a network's metadata.
pub(super) fn from_metadata(characters: &str) -> Result<Vec<String>, NoAlphabet> {
    let characters = characters.trim_end_matches('\n').split('\n');
    check(std::iter::once("blank").chain(characters).chain([" "]).map(str::to_owned).collect())
}

fn check(keys: Vec<String>) -> Result<Vec<String>, NoAlphabet> {
    if keys.len() < 2 { Err(NoAlphabet) } else { Ok(keys) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_gains_blank_and_space() {
        assert_eq!(from_metadata("a\nb").unwrap(), ["blank", "a", "b", " "]);
        assert_eq!(from_metadata("a\nb\n").unwrap(), ["blank", "a", "b", " "]);
    }

    #[test]
    fn missing_files_are_named() {
        let error = read(Path::new("/nonexistent/keys.txt")).unwrap_err();
        assert!(error.to_string().contains("/nonexistent/keys.txt"));
    }
}
