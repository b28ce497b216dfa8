//! Reading files that users name.
//!
//! Such a file may be anything: a pipe that never ends, a device, or a hundred gigabytes of zeros.
//! Only regular files are opened, and no more than a bound is read.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Bound for configurations, lists of instructions and other texts that people write, bytes.
pub const TEXT_BYTES: u64 = 64 << 20;

/// Opens a regular file.
///
/// # Errors
/// As [`File::open`]; folders, pipes and devices are refused without opening them.
pub fn open(path: &Path) -> Result<File> {
    // Before it is opened: opening a pipe waits until somebody writes to it.
    let kind = std::fs::metadata(path)?;
    if kind.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    if !kind.is_file() {
        let problem = "it is no regular file but a pipe or a device; copy its content to a file";
        return Err(Error::new(ErrorKind::InvalidInput, problem));
    }
    File::open(path)
}

/// Reads a regular file of at most `most` bytes.
///
/// ```
/// use openbench_core::input;
///
/// let file = tempfile::NamedTempFile::new()?;
/// std::fs::write(file.path(), "twelve bytes")?;
/// assert_eq!(input::read(file.path(), 12)?.len(), 12);
/// assert!(input::read(file.path(), 11).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// As [`open`], or a file that is longer.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    if length <= most {
        // A file may grow while it is read: one byte more shows that it has become too long.
        file.take(most + 1).read_to_end(&mut bytes)?;
    }
    if length.max(bytes.len() as u64) > most {
        let problem = format!("it has more than {most} bytes, which is the limit for such files");
        return Err(Error::new(ErrorKind::FileTooLarge, problem));
    }
    Ok(bytes)
}

/// Reads a text of at most [`TEXT_BYTES`].
///
/// # Errors
/// As [`read`], or bytes that are no UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path, TEXT_BYTES)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let problem = format!("it is no text in UTF-8: see byte {at}");
        Error::new(ErrorKind::InvalidData, problem)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_devices_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = open(folder.path()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::IsADirectory);
        let absent = open(&folder.path().join("absent")).unwrap_err();
        assert_eq!(absent.kind(), ErrorKind::NotFound);
        if cfg!(unix) {
            let error = read_text(Path::new("/dev/zero")).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput);
        }
    }

    #[test]
    fn what_is_no_text_is_told_with_its_place() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), b"ab\xff").unwrap();
        let error = read_text(file.path()).unwrap_err().to_string();
        assert!(error.contains("byte 2"), "{error}");
    }
}
