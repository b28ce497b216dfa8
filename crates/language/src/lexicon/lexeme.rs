//! What stands at a place of an instruction: a word of a class, a number, a name, a mark.

use std::ops::Range;

use super::class::Class;

/// The kind of a lexeme.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Lex {
    /// A word of a lexicon, and whether its language puts numbers before levels.
    Word(Class, bool),
    /// A number that could be a label, as labels are compared: `12`, `12a`.
    Number { label: String, ordinal: bool },
    /// A name on the map: index into the names found in the text.
    Name(usize),
    /// The end of a sentence.
    Stop,
    /// `,`
    Comma,
    /// `-` or `/`
    Dash,
    /// Other marks.
    Mark,
    /// A number with a unit of measure, a time, a telephone number.
    Quantity,
    /// A word of no lexicon.
    Unknown,
}

impl Lex {
    /// The cardinal number `value`.
    pub(super) fn cardinal(value: u32) -> Self {
        Self::Number {
            label: value.to_string(),
            ordinal: false,
        }
    }
}

/// A [`Lex`] and the tokens that it consists of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Lexeme {
    pub lex: Lex,
    pub tokens: Range<usize>,
}

impl Lexeme {
    /// Whether it is a word of a class.
    pub(crate) fn is(&self, class: Class) -> bool {
        matches!(self.lex, Lex::Word(c, _) if c == class)
    }
}
