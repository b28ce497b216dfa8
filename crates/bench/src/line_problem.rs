//! A line of a text file that cannot be parsed.

/// A line that is not in the expected format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineProblem {
    /// Line number, from 1.
    pub line: usize,
    /// What is wrong, and what is expected.
    pub problem: String,
}
