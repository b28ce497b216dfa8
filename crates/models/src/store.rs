//! The folder where model files lie: `OPENBENCH_MODELS`, else `openbench/models` in the user's cache (`XDG_CACHE_HOME`, else `~/.cache`).
//!
//! A file of the catalogue is trusted only while its SHA-256 is the catalogue's, which is checked each time; what differs is pulled anew. Chat models that the user took in are not checked again. Files appear in the folder
//! whole or not at all, so several processes may share it.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::catalogue::{CATALOGUE, ModelFile};
use crate::digest::sha256_of;
use crate::error::{Cause, ModelError};

/// The bytes with which a GGUF file begins.
pub(crate) const GGUF_MAGIC: &[u8; 4] = b"GGUF";

/// A folder of model files.
#[derive(Debug, Clone)]
pub struct ModelStore {
    folder: PathBuf,
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
        let folder = user_folder(|name| std::env::var_os(name).map(PathBuf::from));
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
        right_size && file_digest(&path).is_ok_and(|found| found == file.sha256)
    }

    /// The chat model that a user calls so: one of the catalogue or one that was taken in, if it is here, or a file somewhere else.
    ///
    /// # Errors
    /// [`ModelError::NotPulled`], [`ModelError::NoSuchFile`].
    pub fn chat_model(&self, name: &str) -> Result<PathBuf, ModelError> {
        if let Some(file) = CATALOGUE.iter().find(|file| file.name == name && is_gguf(file)) {
            if self.has(file) {
                return Ok(self.path(file));
            }
            return Err(ModelError::NotPulled { name: file.name });
        }
        let is_plain = !name.contains(['/', '\\']);
        let taken_in = is_plain.then(|| self.folder.join(format!("{name}.gguf")));
        let mut places = taken_in.into_iter().chain([PathBuf::from(name)]);
        places.find(|path| path.is_file()).ok_or_else(|| ModelError::NoSuchFile { name: name.to_owned() })
    }

    /// Takes in a chat model that the user has: under its name in the catalogue if it is one of those, else under its own. Returns where it lies now.
    ///
    /// # Errors
    /// [`ModelError::NoModel`] if it cannot be read or is no GGUF file, [`ModelError::Taken`] if another has its name, [`ModelError::Storage`].
    pub fn take_in(&self, path: &Path) -> Result<PathBuf, ModelError> {
        let digest =
            gguf_digest(path).map_err(|source| ModelError::NoModel { path: path.to_owned(), source })?;
        let known = CATALOGUE.into_iter().find(|known| known.sha256 == digest);
        let target = match &known {
            Some(known) => self.path(known),
            None => self.folder.join(gguf_name(path)),
        };
        if self.is_of_another(&target, &digest) || known.is_none() && is_another(&target, &digest) {
            return Err(ModelError::Taken { path: target });
        }
        let mut part = self.part(&target)?;
        File::open(path)
            .and_then(|mut whole| io::copy(&mut whole, &mut part))
            .map_err(|source| storage(&target, source))?;
        part.persist(&target).map_err(|error| storage(&target, error.error))?;
        Ok(target)
    }

    /// Whether the catalogue keeps that place for a file with another digest.
    fn is_of_another(&self, target: &Path, digest: &str) -> bool {
        CATALOGUE.iter().any(|file| file.sha256 != digest && self.path(file) == target)
    }

    /// Has the bytes written, checks them, and puts them into the folder under the file's name in one step.
    pub(crate) fn put(
        &self,
        file: &ModelFile,
        write: impl FnOnce(&mut dyn Write) -> Result<(), ModelError>,
    ) -> Result<(), ModelError> {
        let target = self.path(file);
        let mut part = self.part(&target)?;
        write(&mut part)?;
        part.flush().map_err(|source| storage(&target, source))?;
        let found = file_digest(part.path()).map_err(|source| storage(&target, source))?;
        if found != file.sha256 {
            return Err(ModelError::Checksum { name: file.name, expected: file.sha256, found });
        }
        part.persist(&target).map_err(|error| storage(&target, error.error))?;
        Ok(())
    }

    /// Makes the folder if there is none.
    pub(crate) fn create_folder(&self) -> Result<(), ModelError> {
        std::fs::create_dir_all(&self.folder).map_err(|source| storage(&self.folder, source))
    }

    /// A file without a name in the folder, to become `target`.
    fn part(&self, target: &Path) -> Result<NamedTempFile, ModelError> {
        self.create_folder()?;
        NamedTempFile::new_in(&self.folder).map_err(|source| storage(target, source))
    }
}

/// The folder of the user whose environment this is.
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

fn storage(path: &Path, source: io::Error) -> ModelError {
    ModelError::Storage { path: path.to_owned(), source }
}

fn is_gguf(file: &ModelFile) -> bool {
    file.file_name().ends_with(".gguf")
}

/// The name under which a user's own model lies in the folder.
fn gguf_name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned() + ".gguf"
}

fn file_digest(path: &Path) -> io::Result<String> {
    File::open(path).and_then(sha256_of)
}

/// The digest of a GGUF file.
fn gguf_digest(path: &Path) -> Result<String, Cause> {
    let mut magic = [0_u8; GGUF_MAGIC.len()];
    if File::open(path)?.read_exact(&mut magic).is_err() || &magic != GGUF_MAGIC {
        return Err("it does not begin with GGUF".into());
    }
    Ok(file_digest(path)?)
}

/// Whether there is a file with another digest.
fn is_another(path: &Path, digest: &str) -> bool {
    file_digest(path).is_ok_and(|there| there != digest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_that_the_user_has_are_taken_in_and_found_by_name_or_path() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        std::fs::write(&file, b"GGUF and so on").unwrap();
        assert!(matches!(store.chat_model("mine"), Err(ModelError::NoSuchFile { .. })));
        let there = store.take_in(&file).unwrap();
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        assert_eq!(store.chat_model("mine").unwrap(), there);
        assert_eq!(store.chat_model(&file.to_string_lossy()).unwrap(), file);
    }

    #[test]
    fn a_model_that_is_not_here_says_how_to_pull_it() {
        let folder = tempfile::tempdir().unwrap();
        let error = ModelStore::new(folder.path()).chat_model("smollm2-135m-instruct").unwrap_err();
        assert!(error.to_string().contains("models pull smollm2-135m-instruct"), "{error}");
    }

    #[test]
    fn nothing_is_taken_in_over_another_file() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        std::fs::write(&file, b"GGUF and so on").unwrap();
        let there = store.take_in(&file).unwrap();
        std::fs::write(&file, b"GGUF and something else").unwrap();
        assert!(matches!(store.take_in(&file), Err(ModelError::Taken { .. })));
        assert_eq!(std::fs::read(&there).unwrap(), b"GGUF and so on");
        let of_the_catalogue = folder.path().join("smollm2-135m-instruct.gguf");
        std::fs::write(&of_the_catalogue, b"GGUF of mine").unwrap();
        assert!(matches!(store.take_in(&of_the_catalogue), Err(ModelError::Taken { .. })));
    }

    #[test]
    fn only_gguf_files_are_taken_in() {
        let folder = tempfile::tempdir().unwrap();
        let store = ModelStore::new(folder.path().join("store"));
        let file = folder.path().join("mine.gguf");
        assert!(matches!(store.take_in(&file), Err(ModelError::NoModel { .. })));
        std::fs::write(&file, b"PK").unwrap();
        assert!(matches!(store.take_in(&file), Err(ModelError::NoModel { .. })));
    }

    #[test]
    fn the_folder_follows_the_environment() {
        let home = ("HOME", "/h");
        assert_eq!(folder_with(&[home]).unwrap(), Path::new("/h/.cache/openbench/models"));
        let cache = folder_with(&[home, ("XDG_CACHE_HOME", "/c")]);
        assert_eq!(cache.unwrap(), Path::new("/c/openbench/models"));
        assert_eq!(folder_with(&[home, ("OPENBENCH_MODELS", "/m")]).unwrap(), Path::new("/m"));
        assert_eq!(folder_with(&[("OPENBENCH_MODELS", "")]), None);
    }

    fn folder_with(variables: &[(&str, &str)]) -> Option<PathBuf> {
        user_folder(|name| {
            let (_, value) = variables.iter().find(|(variable, _)| *variable == name)?;
            Some(PathBuf::from(value))
        })
    }
}
