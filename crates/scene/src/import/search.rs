//! Search for the files of `model://…` on the search path.

use std::path::{Component, Path, PathBuf};

/// Folders that contain models, in the order of the search.
#[derive(Debug, Clone, Default)]
pub(crate) struct SearchPath {
    folders: Vec<PathBuf>,
}

impl SearchPath {
    /// The folders as given.
    pub(crate) fn new(folders: &[PathBuf]) -> Self {
        Self {
            folders: folders.to_vec(),
        }
    }

    /// The folders, for error messages.
    pub(crate) fn folders(&self) -> Vec<PathBuf> {
        self.folders.clone()
    }

    /// The file or folder of `uri`. Relative paths are relative to the folder of the file that has
    /// them.
    pub(crate) fn find(&self, uri: &str, beside: &Path) -> Option<PathBuf> {
        if let Some(rest) = uri.strip_prefix("model://") {
            return self.find_model(rest);
        }
        let plain = uri.strip_prefix("file://").unwrap_or(uri);
        if plain.is_empty() || plain.contains("://") {
            return None;
        }
        let path = beside.join(plain);
        path.exists().then_some(path)
    }

    /// `name/rest` in the first folder that has it. A folder on the path may itself be the model
    /// `name`.
    fn find_model(&self, rest: &str) -> Option<PathBuf> {
        let relative = Path::new(rest.trim_end_matches('/'));
        let inside = relative
            .components()
            // No `..` and no absolute path: a reference cannot leave the folders of the search
            // path.
            .all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if rest.is_empty() || !inside {
            return None;
        }
        let in_folder = |folder: &PathBuf| {
            let path = folder.join(relative);
            if path.exists() {
                return Some(path);
            }
            let own = relative.strip_prefix(folder.file_name()?).ok()?;
            let path = folder.join(own);
            path.exists().then_some(path)
        };
        self.folders.iter().find_map(in_folder)
    }
}

/// The model in a `model://NAME/…` uri.
pub(crate) fn model_of(uri: &str) -> Option<&str> {
    uri.strip_prefix("model://")?
        .split('/')
        .next()
        .filter(|s| !s.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_cannot_leave_the_search_path() {
        let search = SearchPath::new(&[std::env::temp_dir()]);
        for uri in [
            "model://..",
            "model://a/../../etc",
            "model:///etc",
            "model://",
            "https://example.org/x",
        ] {
            assert_eq!(search.find(uri, Path::new("/nowhere")), None, "{uri}");
        }
    }

    #[test]
    fn a_folder_of_the_path_may_be_the_model_itself() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("tree");
        std::fs::create_dir(&model).unwrap();
        std::fs::write(model.join("a.obj"), "").unwrap();
        for root in [folder.path(), model.as_path()] {
            let search = SearchPath::new(&[root.to_owned()]);
            assert_eq!(
                search.find("model://tree/a.obj", Path::new("/")),
                Some(model.join("a.obj"))
            );
        }
    }

    #[test]
    fn the_model_of_a_uri() {
        assert_eq!(
            model_of("model://house_3/meshes/house_3.dae"),
            Some("house_3")
        );
        assert_eq!(model_of("file://house_3"), None);
    }
}
