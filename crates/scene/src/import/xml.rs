//! Reading XML with limits, and numbers in it; errors have a line and a column.
//!
//! Document types are rejected, so entities cannot expand.

use std::path::Path;
use std::str::FromStr;

use openbench_core::input;
use roxmltree::{Document, Node, ParsingOptions, TextPos};

use super::color::color;
use super::error::ImportError;

/// Largest XML or mesh file that is read, bytes.
pub(crate) const MAX_FILE_BYTES: usize = 256 << 20;
const MAX_NODES: u32 = 20_000_000;

/// The bytes of a file of bounded size.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, ImportError> {
    let io = |e| ImportError::io(path, e);
    // Asked before reading, so that a huge file takes no memory.
    let length = std::fs::metadata(path).map_err(io)?.len();
    if length > MAX_FILE_BYTES as u64 {
        return Err(ImportError::too_large(path, "bytes", MAX_FILE_BYTES));
    }
    input::read(path, MAX_FILE_BYTES as u64).map_err(io)
}

/// The text of a file of bounded size. Bytes that are not UTF-8 are replaced: they occur in names
/// only.
pub(crate) fn read_text(path: &Path) -> Result<String, ImportError> {
    let bytes = read_bytes(path)?;
    Ok(String::from_utf8(bytes)
        .unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

/// Parses XML.
pub(crate) fn parse<'t>(path: &Path, text: &'t str) -> Result<Document<'t>, ImportError> {
    let options = ParsingOptions {
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|source| {
        let TextPos {
            row: line,
            col: column,
        } = match source {
            // Reported without a place.
            roxmltree::Error::UnclosedRootNode => end_of(text),
            _ => source.pos(),
        };
        ImportError::Xml {
            path: path.to_owned(),
            line,
            column,
            source,
        }
    })
}

/// Line and column, from 1, just after the last character.
fn end_of(text: &str) -> TextPos {
    let last = text.rsplit('\n').next().unwrap_or("");
    let lines = text.bytes().filter(|b| *b == b'\n').count();
    TextPos::new(lines as u32 + 1, last.chars().count() as u32 + 1)
}

/// An error at `node`.
pub(crate) fn malformed(path: &Path, node: Node, problem: impl Into<String>) -> ImportError {
    let at = node.document().text_pos_at(node.range().start);
    ImportError::Malformed {
        path: path.to_owned(),
        line: at.row,
        column: at.col,
        problem: problem.into(),
    }
}

/// The first child element of that name, whatever its namespace.
pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// Child elements of that name, whatever their namespace.
pub(crate) fn children<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    name: &str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |n| is(*n, name))
}

/// Whether `node` is an element of that name, whatever its namespace.
pub(crate) fn is(node: Node, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// Trimmed text of the first child element of that name, if it has any.
pub(crate) fn child_text<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(node, name)?
        .text()
        .map(str::trim)
        .filter(|t| !t.is_empty())
}

/// All numbers in the text of `node`.
pub(crate) fn list<T: FromStr>(path: &Path, node: Node) -> Result<Vec<T>, ImportError> {
    let word = |w: &str| {
        w.parse()
            .map_err(|_| malformed(path, node, format!("`{}` is not a number", clip(w))))
    };
    node.text()
        .unwrap_or("")
        .split_ascii_whitespace()
        .map(word)
        .collect()
}

/// Exactly the first `N` numbers in the text of `node`, all finite.
pub(crate) fn numbers<const N: usize>(path: &Path, node: Node) -> Result<[f64; N], ImportError> {
    let found: Vec<f64> = list(path, node)?;
    let few = || {
        malformed(
            path,
            node,
            format!("<{}> needs {N} finite numbers", node.tag_name().name()),
        )
    };
    let first: [f64; N] = found
        .get(..N)
        .and_then(|s| s.try_into().ok())
        .ok_or_else(few)?;
    if first.iter().all(|v| v.is_finite() && v.abs() < 1e9) {
        Ok(first)
    } else {
        Err(few())
    }
}

/// The numbers of the first child of that name, if there is one.
pub(crate) fn child_numbers<const N: usize>(
    path: &Path,
    node: Node,
    name: &str,
) -> Result<Option<[f64; N]>, ImportError> {
    child(node, name).map(|n| numbers(path, n)).transpose()
}

/// The colour in the first child of that name: red, green, blue, from 0 to 1. Alpha is not used.
pub(crate) fn child_color(
    path: &Path,
    node: Node,
    name: &str,
) -> Result<Option<[f32; 3]>, ImportError> {
    let Some(node) = child(node, name) else {
        return Ok(None);
    };
    let values: Vec<f32> = list(path, node)?;
    Ok(values.get(..3).and_then(|c| color([c[0], c[1], c[2]])))
}

fn clip(word: &str) -> String {
    // A broken file may hold megabytes without a space, and this ends up in a message.
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_file_is_an_error_with_its_place() {
        let error = parse(Path::new("a.world"), "<sdf>\n <world>\n")
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("a.world:3:"), "{error}");
    }

    #[test]
    fn bad_numbers_are_errors_with_their_place() {
        for text in [
            "<a>\n <p>1 2</p></a>",
            "<a>\n <p>1 2 x</p></a>",
            "<a>\n <p>1 2 inf</p></a>",
        ] {
            let doc = parse(Path::new("f"), text).unwrap();
            let error = child_numbers::<3>(Path::new("f"), doc.root_element(), "p")
                .unwrap_err()
                .to_string();
            assert!(error.starts_with("f:2:2: "), "{error}");
        }
    }

    #[test]
    fn document_types_are_rejected() {
        assert!(parse(Path::new("f"), "<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>").is_err());
    }
}
