//! What is wrong with a line of a text file.

/// A line that does not fit its format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineProblem {
    /// Its number, from 1.
    pub line: usize,
    /// What is wrong with it and what is expected.
    pub problem: String,
}
