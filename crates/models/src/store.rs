//! The folder of model files: `OPENBENCH_MODELS`, else `openbench/models` in the user's cache
//! folder, which is `XDG_CACHE_HOME` or `~/.cache`.
//!
//! The SHA-256 of a file of the catalogue is checked each time; a file that differs is downloaded
//! again. Chat models that the user adds are not checked again. A file appears in the folder when
//! it is complete, so several processes may share the folder.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::catalogue::{CATALOGUE, ModelFile};
use crate::digest::sha256_of;
use crate::error::{Cause, StoreError};

/// Magic bytes of GGUF files.
pub(crate) const GGUF_MAGIC: &[u8; 4] = b"GGUF";

/// A folder of model files.
#[derive(Debug, Clone)]
pub struct ModelStore {
    folder: PathBuf,
}

impl ModelStore {
    /// A store in `folder`, which does not need to exist.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// The store of the user whose environment this process has.
    ///
    /// # Errors
    /// [`StoreError::NoFolder`].
    pub fn from_environment() -> Result<Self, StoreError> {
        let folder = user_folder(|name| std::env::var_os(name).map(PathBuf::from));
        folder.map(Self::new).ok_or(StoreError::NoFolder)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The path of `file` in the folder, whether it is there or not.
    pub fn path(&self, file: &ModelFile) -> PathBuf {
        self.folder.join(file.file_name())
    }

    /// Whether the folder contains the file with the checksum of the catalogue.
    pub fn contains(&self, file: &ModelFile) -> bool {
        let path = self.path(file);
        // The length first: most wrong files are found without reading them.
        let right_size = path
            .metadata()
            .is_ok_and(|metadata| metadata.len() == file.bytes);
        right_size && file_digest(&path).is_ok_and(|found| found == file.sha256)
    }

    /// The file of a chat model: one of the catalogue, one that the user added, or a path.
    ///
    /// # Errors
    /// [`StoreError::NotDownloaded`], [`StoreError::NoSuchFile`].
    pub fn chat_model(&self, name: &str) -> Result<PathBuf, StoreError> {
        if let Some(file) = CATALOGUE
            .iter()
            .find(|file| file.name == name && is_gguf(file))
        {
            if self.contains(file) {
                return Ok(self.path(file));
            }
            return Err(StoreError::NotDownloaded { name: file.name });
        }
        // A name with a separator must not lead out of the folder; as a path it is tried below.
        let is_plain = !name.contains(['/', '\\']);
        let added = is_plain.then(|| self.folder.join(format!("{name}.gguf")));
        let mut places = added.into_iter().chain([PathBuf::from(name)]);
        places
            .find(|path| path.is_file())
            .ok_or_else(|| StoreError::NoSuchFile {
                name: name.to_owned(),
            })
    }

    /// SHA-256 of the file of a chat model, hexadecimal.
    ///
    /// # Errors
    /// As [`chat_model`](Self::chat_model), or [`StoreError::Io`].
    pub fn chat_model_digest(&self, name: &str) -> Result<String, StoreError> {
        let path = self.chat_model(name)?;
        file_digest(&path).map_err(|source| io_error(&path, source))
    }

    /// Copies a chat model into the folder and returns its new path. A file of the catalogue gets
    /// its name there, others keep theirs.
    ///
    /// # Errors
    /// [`StoreError::NotGguf`] if the file cannot be read or is not a GGUF file,
    /// [`StoreError::NameConflict`] if another file has its name, [`StoreError::Io`].
    pub fn add(&self, path: &Path) -> Result<PathBuf, StoreError> {
        let digest = gguf_digest(path).map_err(|source| StoreError::NotGguf {
            path: path.to_owned(),
            source,
        })?;
        let known = CATALOGUE.into_iter().find(|known| known.sha256 == digest);
        let target = match &known {
            Some(known) => self.path(known),
            None => self.folder.join(gguf_name(path)),
        };
        if self.is_reserved(&target, &digest)
            // A file of the catalogue may replace a damaged one of its own name.
            || known.is_none() && exists_with_other_digest(&target, &digest)
        {
            return Err(StoreError::NameConflict { path: target });
        }
        let mut part = self.temporary(&target)?;
        File::open(path)
            .and_then(|mut whole| io::copy(&mut whole, &mut part))
            .map_err(|source| io_error(&target, source))?;
        // Renamed within the folder, which is atomic: no other process sees a part of the file.
        part.persist(&target)
            .map_err(|error| io_error(&target, error.error))?;
        Ok(target)
    }

    /// Whether `target` is the path of a file of the catalogue with another digest.
    fn is_reserved(&self, target: &Path, digest: &str) -> bool {
        CATALOGUE
            .iter()
            .any(|file| file.sha256 != digest && self.path(file) == target)
    }

    /// Stores a file that `write` writes, if its checksum is that of the catalogue.
    pub(crate) fn put(
        &self,
        file: &ModelFile,
        write: impl FnOnce(&mut dyn Write) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let target = self.path(file);
        let mut part = self.temporary(&target)?;
        write(&mut part)?;
        part.flush().map_err(|source| io_error(&target, source))?;
        // Read back from the disk, so that errors of writing are found as well.
        let found = file_digest(part.path()).map_err(|source| io_error(&target, source))?;
        if found != file.sha256 {
            return Err(StoreError::Checksum {
                name: file.name,
                expected: file.sha256,
                found,
            });
        }
        part.persist(&target)
            .map_err(|error| io_error(&target, error.error))?;
        Ok(())
    }

    /// Creates the folder if it does not exist.
    pub(crate) fn create_folder(&self) -> Result<(), StoreError> {
        std::fs::create_dir_all(&self.folder).map_err(|source| io_error(&self.folder, source))
    }

    /// A temporary file in the folder, to be renamed to `target`.
    fn temporary(&self, target: &Path) -> Result<NamedTempFile, StoreError> {
        self.create_folder()?;
        NamedTempFile::new_in(&self.folder).map_err(|source| io_error(target, source))
    }
}

/// The folder of the user with this environment.
fn user_folder(variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    let filled = |name| variable(name).filter(|path| !path.as_os_str().is_empty());
    if let Some(folder) = filled("OPENBENCH_MODELS") {
        return Some(folder);
    }
    let cache = match filled("XDG_CACHE_HOME") {
        Some(cache) => cache,
        None => filled("HOME")?.join(".cache"),
    };
    Some(cache.join("openbench").join("models"))
}

fn io_error(path: &Path, source: io::Error) -> StoreError {
    StoreError::Io {
        path: path.to_owned(),
        source,
    }
}

fn is_gguf(file: &ModelFile) -> bool {
    file.file_name().ends_with(".gguf")
}

/// The name that a user's own model gets in the folder.
fn gguf_name(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
        + ".gguf"
}

fn file_digest(path: &Path) -> io::Result<String> {
    File::open(path).and_then(sha256_of)
}

/// SHA-256 of a file, if it is a GGUF file.
fn gguf_digest(path: &Path) -> Result<String, Cause> {
    let mut magic = [0_u8; GGUF_MAGIC.len()];
    if File::open(path)?.read_exact(&mut magic).is_err() || &magic != GGUF_MAGIC {
        return Err("it does not begin with the magic bytes GGUF".into());
    }
    Ok(file_digest(path)?)
}

/// Whether there is a file at `path` with another digest.
fn exists_with_other_digest(path: &Path, digest: &str) -> bool {
    file_digest(path).is_ok_and(|there| there != digest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_models_are_found_by_name_or_path() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        std::fs::write(&file, b"GGUF and so on").unwrap();
        assert!(matches!(
            store.chat_model("mine"),
            Err(StoreError::NoSuchFile { .. })
        ));
        let there = store.add(&file).unwrap();
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        assert_eq!(store.chat_model("mine").unwrap(), there);
        assert_eq!(store.chat_model_digest("mine").unwrap().len(), 64);
        assert_eq!(store.chat_model(&file.to_string_lossy()).unwrap(), file);
    }

    #[test]
    fn the_error_for_a_missing_model_names_the_command() {
        let folder = tempfile::tempdir().unwrap();
        let error = ModelStore::new(folder.path())
            .chat_model("smollm2-135m-instruct")
            .unwrap_err();
        assert!(
            error
                .to_string()
                .contains("models pull smollm2-135m-instruct"),
            "{error}"
        );
    }

    #[test]
    fn no_file_is_replaced_by_another() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        std::fs::write(&file, b"GGUF and so on").unwrap();
        let there = store.add(&file).unwrap();
        std::fs::write(&file, b"GGUF and something else").unwrap();
        assert!(matches!(
            store.add(&file),
            Err(StoreError::NameConflict { .. })
        ));
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        let of_the_catalogue = folder.path().join("smollm2-135m-instruct.gguf");
        std::fs::write(&of_the_catalogue, b"GGUF of mine").unwrap();
        assert!(matches!(
            store.add(&of_the_catalogue),
            Err(StoreError::NameConflict { .. })
        ));
    }

    #[test]
    fn other_files_than_gguf_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        assert!(matches!(store.add(&file), Err(StoreError::NotGguf { .. })));
        std::fs::write(&file, b"PK").unwrap();
        assert!(matches!(store.add(&file), Err(StoreError::NotGguf { .. })));
    }

    #[test]
    fn the_environment_determines_the_folder() {
        let home = ("HOME", "/h");
        assert_eq!(
            folder_with(&[home]).unwrap(),
            Path::new("/h/.cache/openbench/models")
        );
        let cache = folder_with(&[home, ("XDG_CACHE_HOME", "/c")]);
        assert_eq!(cache.unwrap(), Path::new("/c/openbench/models"));
        assert_eq!(
            folder_with(&[home, ("OPENBENCH_MODELS", "/m")]).unwrap(),
            Path::new("/m")
        );
        assert_eq!(folder_with(&[("OPENBENCH_MODELS", "")]), None);
    }

    fn folder_with(variables: &[(&str, &str)]) -> Option<PathBuf> {
        user_folder(|name| {
            let (_, value) = variables.iter().find(|(variable, _)| *variable == name)?;
            Some(PathBuf::from(value))
        })
    }
}
