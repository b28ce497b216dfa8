//! Files of deliveries: one instruction per line, each an episode.

use std::path::Path;

use openbench_core::Address;
use serde::Deserialize;

use crate::BenchError;
use crate::line_problem::LineProblem;
use crate::suite::Episode;

/// An annotated instruction. The keys are those of the data set of instructions; the ones that
/// are of no use here are accepted, so that its files can be used as they are.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct AnnotatedLine {
    instruction: String,
    deliveries: Vec<Address>,
    #[serde(default)]
    before: Vec<(usize, usize)>,
    #[serde(default)]
    ambiguous: bool,
    #[serde(default, rename = "id")]
    _id: Option<String>,
    #[serde(default, rename = "lang")]
    _lang: Option<String>,
    #[serde(default, rename = "difficulty")]
    _difficulty: Option<String>,
    #[serde(default, rename = "map")]
    _map: Option<String>,
}

impl AnnotatedLine {
    /// The episode.
    ///
    /// # Errors
    /// What is wrong with the annotation.
    fn episode(self) -> Result<Episode, String> {
        if self.ambiguous {
            return Err("an ambiguous instruction has no door to deliver to; remove it".into());
        }
        if self.deliveries.is_empty() {
            return Err("there is no door in `deliveries`".into());
        }
        let episode = Episode {
            instruction: self.instruction,
            deliveries: self.deliveries,
            before: self.before,
        };
        episode.check()?;
        Ok(episode)
    }
}

/// Whether a file of deliveries has annotations: its name ends in `.jsonl`.
pub fn is_annotated(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("jsonl"))
}

/// Reads a file of deliveries.
///
/// A file whose name ends in `.jsonl` has a JSON object on each line, with `instruction`,
/// `deliveries` (a list of `building` and `unit`) and optionally `before` (pairs of indices into
/// `deliveries`, the first of which has to be visited before the second). Any other file has an
/// instruction on each line, as published; its episodes have no doors.
///
/// # Errors
/// A file that cannot be read, has no instructions, or has a line that is not as described.
pub fn read(path: &Path) -> Result<Vec<Episode>, BenchError> {
    let text = openbench_core::input::read_text(path).map_err(|e| BenchError::file(path, e))?;
    let lines = (1..)
        .zip(text.lines().map(str::trim))
        .filter(|(_, line)| !line.is_empty());
    let episodes: Result<Vec<Episode>, LineProblem> = if is_annotated(path) {
        lines.map(|(line, text)| annotated(line, text)).collect()
    } else {
        Ok(lines.map(|(_, text)| Episode::unannotated(text)).collect())
    };
    let episodes = episodes.map_err(|LineProblem { line, problem }| {
        BenchError::bad_file(path, format!("line {line}: {problem}"))
    })?;
    if episodes.is_empty() {
        let problem = "there is no delivery in it; write one instruction per line".to_owned();
        return Err(BenchError::bad_file(path, problem));
    }
    Ok(episodes)
}

fn annotated(line: usize, text: &str) -> Result<Episode, LineProblem> {
    let parsed: Result<AnnotatedLine, _> = serde_json::from_str(text);
    parsed
        .map_err(|e| e.to_string())
        .and_then(AnnotatedLine::episode)
        .map_err(|problem| LineProblem { line, problem })
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::with_causes;

    fn read_as(name: &str, text: &str) -> Result<Vec<Episode>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        read(&path).map_err(|e| with_causes(&e))
    }

    #[test]
    fn lines_without_annotation_have_no_doors() {
        let episodes = read_as("deliveries.txt", "\n  To unit1, building3. \n\nx\n").unwrap();
        assert_eq!(episodes.len(), 2);
        assert_eq!(episodes[0].instruction, "To unit1, building3.");
        assert!(episodes[0].deliveries.is_empty());
        assert!(read_as("deliveries.txt", " \n").is_err());
    }

    #[test]
    fn annotations_are_doors_and_their_order() {
        let line = r#"{"id": "a", "lang": "en", "instruction": "First b2, then b1.",
            "deliveries": [{"building": "b1"}, {"building": "b2", "unit": "u1"}],
            "before": [[1, 0]]}"#;
        let episodes = read_as("deliveries.jsonl", &line.replace('\n', " ")).unwrap();
        assert_eq!(episodes[0].deliveries[1], Address::new("b2", "u1"));
        assert_eq!(episodes[0].deliveries[0].unit, None);
        assert_eq!(episodes[0].before, [(1, 0)]);
    }

    #[test]
    fn what_is_wrong_with_an_annotation_is_reported_with_its_line() {
        let door = r#"{"building": "b1"}"#;
        let good = format!(r#"{{"instruction": "x", "deliveries": [{door}]}}"#);
        let problem = |bad: &str| read_as("d.jsonl", &format!("{good}\n{bad}\n")).unwrap_err();
        for (bad, part) in [
            ("To unit1, building3.", "line 2"),
            (r#"{"instruction": "x", "deliveries": []}"#, "no door"),
            (
                &good.replace("deliveries", "delivery"),
                "unknown field `delivery`",
            ),
            (
                &good
                    .replace('}', r#"}, "before": [[0, 1]]"#)
                    .replacen("]]]", "]]", 1),
                "line 2",
            ),
            (
                &format!(r#"{{"instruction": "x", "deliveries": [{door}, {door}]}}"#),
                "twice",
            ),
            (
                r#"{"instruction": "x", "deliveries": [], "ambiguous": true}"#,
                "ambiguous",
            ),
        ] {
            let said = problem(bad);
            assert!(said.contains("line 2") && said.contains(part), "{said}");
        }
    }
}
