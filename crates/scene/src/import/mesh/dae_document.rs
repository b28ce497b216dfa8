//! A COLLADA document: its elements by their ids, and the sources of numbers.

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, Node};

use super::super::error::ImportError;
use super::super::xml::{child, children, list, malformed};

/// A document with an index of its ids.
pub(super) struct Dae<'a, 'i> {
    pub(super) path: &'a Path,
    ids: BTreeMap<&'a str, Node<'a, 'i>>,
}

impl<'a, 'i> Dae<'a, 'i> {
    pub(super) fn new(path: &'a Path, doc: &'a Document<'i>) -> Self {
        let named = doc
            .descendants()
            .filter_map(|n| Some((n.attribute("id")?, n)));
        Self {
            path,
            ids: named.collect(),
        }
    }

    /// The element that `#id` in an attribute refers to.
    pub(super) fn target(&self, node: Node<'a, 'i>, attribute: &str) -> Option<Node<'a, 'i>> {
        self.by_id(node.attribute(attribute)?)
    }

    /// The element with that id, with or without `#`.
    pub(super) fn by_id(&self, id: &str) -> Option<Node<'a, 'i>> {
        self.ids.get(id.strip_prefix('#').unwrap_or(id)).copied()
    }
}

/// The numbers of a `<source>`.
pub(super) struct Source {
    pub(super) numbers: Vec<f64>,
    /// How many of them are one item, at least 1.
    pub(super) stride: usize,
}

impl Source {
    /// The item with this index, as its first `N` numbers.
    pub(super) fn item<const N: usize>(&self, index: usize) -> Option<[f64; N]> {
        // Index and stride come from the file: their product may overflow.
        let numbers = self.numbers.get(index.checked_mul(self.stride)?..)?;
        numbers.first_chunk().copied()
    }
}

/// Reads a `<source>`.
pub(super) fn source(dae: &Dae, node: Node) -> Result<Source, ImportError> {
    let array = child(node, "float_array")
        .ok_or_else(|| malformed(dae.path, node, "<source> has no <float_array>"))?;
    let accessor = child(node, "technique_common").and_then(|t| child(t, "accessor"));
    let stride = accessor
        .and_then(|a| a.attribute("stride"))
        .and_then(|s| s.parse().ok())
        .unwrap_or(1);
    Ok(Source {
        numbers: list(dae.path, array)?,
        stride: usize::max(stride, 1),
    })
}

/// The source that an `<input>` with that semantic refers to.
pub(super) fn input<'a, 'i>(parent: Node<'a, 'i>, semantic: &str) -> Option<Node<'a, 'i>> {
    children(parent, "input").find(|n| n.attribute("semantic") == Some(semantic))
}
