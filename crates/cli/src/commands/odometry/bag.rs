//! The files of a log: one, or those of a rosbag2 folder.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// The MCAP files of a log, in order of recording. rosbag2 splits bags into NAME_0.mcap,
/// NAME_1.mcap and so on.
pub fn files(log: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if !log.is_dir() {
        return Ok(vec![log.to_owned()]);
    }
    let mut files = Vec::new();
    for entry in std::fs::read_dir(log).with_context(|| log.display().to_string())? {
        let path = entry.with_context(|| log.display().to_string())?.path();
        if path.extension().is_some_and(|end| end == "mcap") {
            files.push(path);
        }
    }
    if files.is_empty() {
        let other = std::fs::read_dir(log)?
            .flatten()
            .any(|e| e.path().extension().is_some_and(|end| end == "db3"));
        let more = if other {
            "; it is a SQLite bag: convert it with `ros2 bag convert`"
        } else {
            ""
        };
        bail!(
            "{}: there is no .mcap file in this folder{more}",
            log.display()
        );
    }
    // By number, so that NAME_10 comes after NAME_9. The path decides between equal numbers.
    files.sort_by_key(|path| (number(path), path.clone()));
    Ok(files)
}

/// The number at the end of a file's name.
fn number(path: &Path) -> Option<u64> {
    path.file_stem()?.to_str()?.rsplit_once('_')?.1.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_come_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        assert!(
            files(folder.path())
                .unwrap_err()
                .to_string()
                .contains("no .mcap file")
        );
        std::fs::write(folder.path().join("bag_0.db3"), "").unwrap();
        assert!(
            files(folder.path())
                .unwrap_err()
                .to_string()
                .contains("ros2 bag convert")
        );
        for name in ["bag_10.mcap", "bag_2.mcap", "bag_0.mcap", "metadata.yaml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let found = files(folder.path()).unwrap();
        let names: Vec<_> = found
            .iter()
            .map(|path| path.file_name().unwrap().to_str().unwrap())
            .collect();
        assert_eq!(names, ["bag_0.mcap", "bag_2.mcap", "bag_10.mcap"]);
    }
}
