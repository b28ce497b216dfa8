//! What an import skipped, each kind counted once.

use std::collections::BTreeMap;

/// Counts what was skipped.
#[derive(Debug, Default)]
pub(crate) struct Warnings(BTreeMap<String, usize>);

impl Warnings {
    /// Counts one more of `what`.
    pub(crate) fn add(&mut self, what: impl Into<String>) {
        *self.0.entry(what.into()).or_default() += 1;
    }

    /// One line for each kind.
    pub(crate) fn into_lines(self) -> Vec<String> {
        self.0
            .into_iter()
            .map(|(what, n)| {
                if n == 1 {
                    what
                } else {
                    format!("{what} ({n} times)")
                }
            })
            .collect()
    }
}
