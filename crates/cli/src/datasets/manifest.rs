//! Manifests of data sets: `# key: value` lines, then `SHA-256 BYTES NAME` for each file.

use std::str::FromStr;

/// The manifests that the binary carries.
const MANIFESTS: [&str; 2] = [
    include_str!("../../data/published.txt"),
    include_str!("../../data/sample-map.txt"),
];

/// A set of files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dataset {
    /// Its name on the command line.
    pub name: String,
    /// What it holds, in one line.
    pub about: String,
    /// Repository and commit.
    pub origin: String,
    /// The files' licence.
    pub licence: String,
    /// Where they are downloaded.
    pub source: Source,
    /// The files.
    pub files: Vec<DataFile>,
}

/// Where a data set is downloaded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// A `tar.gz` that holds the files under any names: they are recognised by their SHA-256.
    Archive(String),
    /// The one file itself.
    File(String),
}

/// A file of a data set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataFile {
    /// SHA-256 in lower-case hexadecimal digits.
    pub sha256: String,
    /// Its size.
    pub bytes: u64,
    /// Its path below the set's folder.
    pub name: String,
}

/// A manifest that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the manifest: {problem}")]
pub struct ManifestError {
    line: usize,
    problem: &'static str,
}

impl FromStr for Dataset {
    type Err = ManifestError;

    fn from_str(text: &str) -> Result<Self, ManifestError> {
        let source = match (header(text, "archive"), header(text, "file")) {
            (Some(url), None) => Source::Archive(url),
            (None, Some(url)) => Source::File(url),
            _ => return Err(missing("exactly one of `archive` and `file` is needed")),
        };
        let numbered = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.starts_with('#'));
        Ok(Self {
            name: header(text, "name").ok_or(missing("`name` is missing"))?,
            about: header(text, "about").ok_or(missing("`about` is missing"))?,
            origin: header(text, "source").ok_or(missing("`source` is missing"))?,
            licence: header(text, "licence").ok_or(missing("`licence` is missing"))?,
            source,
            files: numbered
                .map(|(line, text)| file(line, text))
                .collect::<Result<_, _>>()?,
        })
    }
}

/// The value of the first line `# key: value`.
fn header(text: &str, key: &str) -> Option<String> {
    text.lines()
        .filter_map(|line| line.strip_prefix("# ")?.split_once(": "))
        .find(|(name, _)| *name == key)
        .map(|(_, value)| value.to_owned())
}

/// The error of a header, which has no line of its own.
fn missing(problem: &'static str) -> ManifestError {
    ManifestError { line: 1, problem }
}

fn file(line: usize, text: &str) -> Result<DataFile, ManifestError> {
    let problem = "expected SHA-256 in lower case, bytes, and a name below the folder";
    let words: Vec<&str> = text.split_whitespace().collect();
    let &[sha256, bytes, name] = words.as_slice() else {
        return Err(ManifestError { line, problem });
    };
    let bytes = bytes.parse().map_err(|_| ManifestError { line, problem })?;
    // No file may be stored outside of the folder of its set.
    let is_inside = !name.starts_with('/') && !name.split('/').any(|part| part == "..");
    if !is_sha256(sha256) || !is_inside {
        return Err(ManifestError { line, problem });
    }
    Ok(DataFile {
        sha256: sha256.to_owned(),
        bytes,
        name: name.to_owned(),
    })
}

/// Whether a text is a SHA-256 in the one form that sums are compared in: an upper-case sum would
/// be that of no file.
fn is_sha256(text: &str) -> bool {
    text.len() == 64
        && text
            .bytes()
            .all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// All data sets.
///
/// # Errors
/// [`ManifestError`] if a manifest of this binary is damaged; a test shows that none is.
pub fn datasets() -> Result<Vec<Dataset>, ManifestError> {
    MANIFESTS.iter().map(|text| text.parse()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_carried_manifests_can_be_read() {
        let sets = datasets().unwrap();
        let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names, ["published", "sample-map"]);
        assert!(sets.iter().all(|set| !set.files.is_empty()));
    }

    #[test]
    fn names_that_lead_out_of_the_folder_are_refused() {
        let sum = "0".repeat(64);
        for name in ["../x", "/x", "a/../../x"] {
            assert!(file(1, &format!("{sum} 3 {name}")).is_err(), "{name}");
        }
        assert!(file(1, &format!("{sum} 3 a/x")).is_ok());
        assert!(file(1, "abc 3 x").is_err());
    }

    #[test]
    fn sums_have_lower_case_digits_only() {
        for bad in ["A", "g", " ", "é"] {
            assert!(!is_sha256(&bad.repeat(64)), "{bad}");
        }
        assert!(is_sha256(&"0a".repeat(32)));
        assert!(!is_sha256(&"0a".repeat(31)));
    }
}
