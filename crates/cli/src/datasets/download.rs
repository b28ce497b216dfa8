//! A data set's files from its source into a folder.
//!
//! An archive is read as it arrives and never kept. What it may hold is bounded, and nothing of it
//! is stored but files whose SHA-256 is in the manifest, under the manifest's names.

use std::fmt::Write as _;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::Duration;

use flate2::read::GzDecoder;
use openbench_osm::{OsmError, write_atomically};
use sha2::{Digest, Sha256};

use super::manifest::{DataFile, Dataset, Source};

/// A host that is asked in place of the sources' own: a mirror with the same paths.
const MIRROR: &str = "OPENBENCH_DATA_MIRROR";
/// The longest that a download may take, and the longest until the server answers.
const TIMEOUT: Duration = Duration::from_secs(4 * 3600);
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);
/// The largest archive that is read, compressed and unpacked, bytes.
const MOST_BYTES: u64 = 4 << 30;
const MOST_UNPACKED_BYTES: u64 = 16 << 30;

/// Why a data set could not be stored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The address of the mirror is none.
    #[error("OPENBENCH_DATA_MIRROR must be https://HOST, or http:// on this machine")]
    Mirror,
    /// The server does not answer, or not with the file.
    #[error("cannot download {url}")]
    Download {
        /// The address.
        url: String,
        /// What went wrong.
        source: Box<ureq::Error>,
    },
    /// The connection broke off, or the archive is damaged.
    #[error("cannot read what {url} sends")]
    Read {
        /// The address.
        url: String,
        /// What went wrong.
        source: io::Error,
    },
    /// Files are missing, or others than the pinned ones.
    #[error(
        "{url} does not hold {}; its content has changed, or the download is damaged: try again",
        missing.join(", ")
    )]
    Missing {
        /// The address.
        url: String,
        /// Names of the files.
        missing: Vec<String>,
    },
    /// A folder cannot be made.
    #[error("cannot make the folder {}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Store(#[from] OsmError),
}

/// Downloads a set into a folder. Files that are there already, with the right content, stay;
/// nothing is downloaded if all are. `progress` gets the number of bytes that have arrived.
///
/// # Errors
/// [`DatasetError`]; files that arrived whole before it stay.
pub fn pull(
    set: &Dataset,
    folder: &Path,
    progress: &mut dyn FnMut(u64),
) -> Result<Vec<PathBuf>, DatasetError> {
    let mut missing: Vec<&DataFile> = set.files.iter().filter(|f| !is_here(folder, f)).collect();
    if !missing.is_empty() {
        let (Source::Archive(url) | Source::File(url)) = &set.source;
        let url = mirrored(url, std::env::var(MIRROR).ok().as_deref())?;
        let body = Counted {
            inner: get(&url)?,
            count: 0,
            progress,
        };
        match set.source {
            Source::Archive(_) => unpack(body, &url, folder, &mut missing)?,
            Source::File(_) => take(body, &url, folder, &mut missing)?,
        }
        if !missing.is_empty() {
            let missing = missing.iter().map(|file| file.name.clone()).collect();
            return Err(DatasetError::Missing { url, missing });
        }
    }
    Ok(set
        .files
        .iter()
        .map(|file| folder.join(&file.name))
        .collect())
}

fn is_here(folder: &Path, file: &DataFile) -> bool {
    std::fs::read(folder.join(&file.name)).is_ok_and(|bytes| sha256(&bytes) == file.sha256)
}

/// The address at the mirror, if one is named.
fn mirrored(url: &str, mirror: Option<&str>) -> Result<String, DatasetError> {
    let mirror = mirror
        .map(|text| text.trim().trim_end_matches('/'))
        .filter(|m| !m.is_empty());
    let Some(mirror) = mirror else {
        return Ok(url.to_owned());
    };
    let is_local = ["http://127.0.0.1", "http://localhost", "http://[::1]"]
        .iter()
        .any(|host| mirror.strip_prefix(host).is_some_and(is_port));
    if !(mirror.starts_with("https://") || is_local) || mirror.contains(['@', '?', '#', ' ']) {
        return Err(DatasetError::Mirror);
    }
    let path = url.splitn(4, '/').nth(3).unwrap_or_default();
    Ok(format!("{mirror}/{path}"))
}

fn is_port(text: &str) -> bool {
    text.is_empty()
        || text
            .strip_prefix(':')
            .is_some_and(|port| port.parse::<u16>().is_ok())
}

fn get(url: &str) -> Result<impl Read + use<>, DatasetError> {
    let agent: ureq::Agent = ureq::Agent::config_builder()
        .https_only(url.starts_with("https://"))
        .timeout_global(Some(TIMEOUT))
        .timeout_connect(Some(ANSWER_TIMEOUT))
        .timeout_recv_response(Some(ANSWER_TIMEOUT))
        .build()
        .into();
    let failed = |error| DatasetError::Download {
        url: url.to_owned(),
        source: Box::new(error),
    };
    let response = agent.get(url).call().map_err(failed)?;
    Ok(response.into_body().into_reader().take(MOST_BYTES))
}

/// Stores the one file that arrives.
fn take(
    body: impl Read,
    url: &str,
    folder: &Path,
    missing: &mut Vec<&DataFile>,
) -> Result<(), DatasetError> {
    let most = missing
        .iter()
        .map(|file| file.bytes)
        .max()
        .unwrap_or_default();
    let bytes = read(body, most, url)?;
    store(&bytes, folder, missing)
}

/// Stores the files of an archive that are missing.
fn unpack(
    body: impl Read,
    url: &str,
    folder: &Path,
    missing: &mut Vec<&DataFile>,
) -> Result<(), DatasetError> {
    let broken = |source| DatasetError::Read {
        url: url.to_owned(),
        source,
    };
    let mut archive = tar::Archive::new(GzDecoder::new(body).take(MOST_UNPACKED_BYTES));
    for entry in archive.entries().map_err(broken)? {
        let entry = entry.map_err(broken)?;
        let size = entry.size();
        if entry.header().entry_type().is_file() && missing.iter().any(|file| file.bytes == size) {
            let bytes = read(entry, size, url)?;
            store(&bytes, folder, missing)?;
        }
        if missing.is_empty() {
            break;
        }
    }
    Ok(())
}

/// What arrives, up to one byte more than expected.
fn read(body: impl Read, most: u64, url: &str) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = Vec::new();
    let outcome = body.take(most + 1).read_to_end(&mut bytes);
    outcome.map_err(|source| DatasetError::Read {
        url: url.to_owned(),
        source,
    })?;
    Ok(bytes)
}

/// Stores content under every name that it has in the manifest.
fn store(bytes: &[u8], folder: &Path, missing: &mut Vec<&DataFile>) -> Result<(), DatasetError> {
    let sum = sha256(bytes);
    for file in missing.iter().filter(|file| file.sha256 == sum) {
        let path = folder.join(&file.name);
        make_folder_of(&path)?;
        write_atomically(&path, bytes)?;
    }
    missing.retain(|file| file.sha256 != sum);
    Ok(())
}

fn make_folder_of(path: &Path) -> Result<(), DatasetError> {
    let Some(folder) = path.parent() else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|source| DatasetError::Folder {
        path: folder.to_owned(),
        source,
    })
}

fn sha256(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(64);
    for byte in Sha256::digest(bytes) {
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// Tells how many bytes were read.
struct Counted<'p, R> {
    inner: R,
    count: u64,
    progress: &'p mut dyn FnMut(u64),
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.count += count as u64;
        (self.progress)(self.count);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_is_another_host_with_the_same_path() {
        let url = "https://codeload.github.com/a/b/tar.gz/c";
        assert_eq!(mirrored(url, None).unwrap(), url);
        assert_eq!(mirrored(url, Some(" ")).unwrap(), url);
        let there = mirrored(url, Some("http://127.0.0.1:8000/")).unwrap();
        assert_eq!(there, "http://127.0.0.1:8000/a/b/tar.gz/c");
        let bad = [
            "http://mirror.example",
            "mirror",
            "https://user@host",
            "http://127.0.0.1.evil",
        ];
        for mirror in bad {
            assert!(
                matches!(mirrored(url, Some(mirror)), Err(DatasetError::Mirror)),
                "{mirror}"
            );
        }
    }

    #[test]
    fn content_with_another_sum_is_not_stored() {
        let folder = tempfile::tempdir().unwrap();
        let right = DataFile {
            sha256: sha256(b"right"),
            bytes: 5,
            name: "a/file".into(),
        };
        let mut missing = vec![&right];
        store(b"wrong", folder.path(), &mut missing).unwrap();
        assert_eq!(missing.len(), 1);
        store(b"right", folder.path(), &mut missing).unwrap();
        assert!(missing.is_empty());
        assert_eq!(
            std::fs::read(folder.path().join("a/file")).unwrap(),
            b"right"
        );
    }
}
