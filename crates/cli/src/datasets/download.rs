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
    // A complete set needs neither the network nor a valid address of a mirror.
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
    // Plain http for this machine only. After the host there may be a port and nothing else, so
    // that `localhost.example.org` is not accepted.
    let is_local = ["http://127.0.0.1", "http://localhost", "http://[::1]"]
        .iter()
        .any(|host| mirror.strip_prefix(host).is_some_and(is_port));
    if !(mirror.starts_with("https://") || is_local) || mirror.contains(['@', '?', '#', ' ']) {
        return Err(DatasetError::Mirror);
    }
    // The parts of https://HOST/PATH at its slashes: `https:`, nothing, the host, the path.
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
        // Redirects, too, must not lead from https to http.
        .https_only(url.starts_with("https://"))
        .timeout_global(Some(TIMEOUT))
        .timeout_connect(Some(ANSWER_TIMEOUT))
        .timeout_recv_response(Some(ANSWER_TIMEOUT))
        .build()
        .into();
    let response = agent
        .get(url)
        .call()
        .map_err(|error| DatasetError::Download {
            url: url.to_owned(),
            source: Box::new(error),
        })?;
    // A server may send without end.
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

/// Stores the files of a compressed archive that are missing.
fn unpack(
    body: impl Read,
    url: &str,
    folder: &Path,
    missing: &mut Vec<&DataFile>,
) -> Result<(), DatasetError> {
    // A small archive can unpack to more than a disk holds.
    let unpacked = GzDecoder::new(body).take(MOST_UNPACKED_BYTES);
    store_entries(unpacked, url, folder, missing)
}

/// Stores the files of an archive that are missing.
///
/// Names and links in the archive are ignored: they could lead out of the folder. The manifest
/// names the file with that content.
fn store_entries(
    archive: impl Read,
    url: &str,
    folder: &Path,
    missing: &mut Vec<&DataFile>,
) -> Result<(), DatasetError> {
    let mut archive = tar::Archive::new(archive);
    for entry in archive.entries().map_err(|error| broken(url, error))? {
        let entry = entry.map_err(|error| broken(url, error))?;
        let size = entry.size();
        let is_wanted = missing.iter().any(|file| file.bytes == size);
        // Other sizes are not read into memory: an archive may declare any.
        if entry.header().entry_type().is_file() && is_wanted {
            let bytes = read(entry, size, url)?;
            store(&bytes, folder, missing)?;
        }
        // What is left of the archive need not be downloaded.
        if missing.is_empty() {
            break;
        }
    }
    Ok(())
}

/// What arrives, up to one byte more than expected: that one reveals a longer file.
fn read(body: impl Read, most: u64, url: &str) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = Vec::new();
    body.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| broken(url, error))?;
    Ok(bytes)
}

/// The error of a connection or an archive.
fn broken(url: &str, source: io::Error) -> DatasetError {
    DatasetError::Read {
        url: url.to_owned(),
        source,
    }
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
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use tar::EntryType;

    use super::*;

    /// The bytes of an archive's entry under any name, which `tar` itself would refuse to write.
    fn entry(name: &str, kind: EntryType, link: &str, bytes: &[u8]) -> Vec<u8> {
        let mut header = tar::Header::new_old();
        let old = header.as_old_mut();
        old.name[..name.len()].copy_from_slice(name.as_bytes());
        old.linkname[..link.len()].copy_from_slice(link.as_bytes());
        header.set_entry_type(kind);
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        let mut entry = [header.as_bytes().as_slice(), bytes].concat();
        entry.resize(entry.len().next_multiple_of(512), 0);
        entry
    }

    /// A compressed archive of entries.
    fn packed(entries: &[Vec<u8>]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(&entries.concat()).unwrap();
        encoder.write_all(&[0; 1024]).unwrap();
        encoder.finish().unwrap()
    }

    fn wanted(bytes: &[u8], name: &str) -> DataFile {
        DataFile {
            sha256: sha256(bytes),
            bytes: bytes.len() as u64,
            name: name.into(),
        }
    }

    /// Files below a folder, with their folders.
    fn names_below(folder: &Path) -> Vec<String> {
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            names.push(entry.file_name().into_string().unwrap());
            if entry.file_type().unwrap().is_dir() {
                names.extend(names_below(&entry.path()));
            }
        }
        names
    }

    #[test]
    fn files_of_an_archive_get_the_names_of_the_manifest() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("set");
        let files = [wanted(b"first", "a/first"), wanted(b"second", "second")];
        let mut missing: Vec<&DataFile> = files.iter().collect();
        let archive = packed(&[
            entry("../../evil", EntryType::Regular, "", b"first"),
            entry("/evil", EntryType::Regular, "", b"second"),
        ]);
        unpack(&archive[..], "url", &folder, &mut missing).unwrap();
        assert!(missing.is_empty());
        assert_eq!(std::fs::read(folder.join("a/first")).unwrap(), b"first");
        assert_eq!(std::fs::read(folder.join("second")).unwrap(), b"second");
        assert_eq!(names_below(outer.path()).len(), 4, "folders and files");
    }

    #[test]
    fn links_and_folders_of_an_archive_are_ignored() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("set");
        let file = wanted(b"right", "a/file");
        let mut missing = vec![&file];
        let archive = packed(&[
            entry("a", EntryType::Symlink, "/tmp", b""),
            entry("a/file", EntryType::Link, "../secret", b""),
            entry("../up", EntryType::Directory, "", b""),
            entry("dev", EntryType::Char, "", b""),
        ]);
        unpack(&archive[..], "url", &folder, &mut missing).unwrap();
        assert_eq!(missing.len(), 1);
        assert!(names_below(outer.path()).is_empty());
    }

    #[test]
    fn a_link_in_an_archive_does_not_redirect_a_later_file() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("set");
        let file = wanted(b"right", "a/file");
        let mut missing = vec![&file];
        let archive = packed(&[
            entry("a", EntryType::Symlink, "..", b""),
            entry("a/file", EntryType::Regular, "", b"right"),
        ]);
        unpack(&archive[..], "url", &folder, &mut missing).unwrap();
        assert!(missing.is_empty());
        assert!(!folder.join("a").is_symlink());
        assert_eq!(names_below(outer.path()), ["set", "a", "file"]);
    }

    #[test]
    fn archives_beyond_the_limit_and_truncated_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = wanted(b"right", "file");
        let large = entry("large", EntryType::Regular, "", &[0; 4096]);
        let right = entry("file", EntryType::Regular, "", b"right");
        let archive = [large.clone(), right.clone()].concat();
        let mut missing = vec![&file];
        // As if 2048 bytes were the limit for unpacked archives.
        let limited = archive.as_slice().take(2048);
        let read = store_entries(limited, "url", folder.path(), &mut missing);
        assert!(matches!(read, Err(DatasetError::Read { .. })), "{read:?}");
        let whole = packed(&[large, right]);
        let half = &whole[..whole.len() / 2];
        let read = unpack(half, "url", folder.path(), &mut missing);
        assert!(matches!(read, Err(DatasetError::Read { .. })), "{read:?}");
        assert_eq!(missing.len(), 1);
        assert!(names_below(folder.path()).is_empty());
    }

    #[test]
    fn a_file_that_is_longer_than_pinned_is_not_stored() {
        let folder = tempfile::tempdir().unwrap();
        let file = wanted(b"right", "file");
        let mut missing = vec![&file];
        take(&b"right and more"[..], "url", folder.path(), &mut missing).unwrap();
        assert_eq!(missing.len(), 1);
        let longest = read(&[0; 64][..], 5, "url").unwrap();
        assert_eq!(longest.len(), 6);
        assert!(names_below(folder.path()).is_empty());
    }

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
