//! What is read: the instruction, its tokens and its lexemes, and what stands at a place of it.

use std::ops::Range;

use super::lexicon::{Class, LANGUAGES};
use super::numbers;
use super::text::{Kind, Token};
use super::words::{Lex, Lexeme};

/// What is read: the instruction, its tokens and its lexemes.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    pub text: &'a str,
    pub tokens: &'a [Token],
    pub lexemes: &'a [Lexeme],
}

impl Reading<'_> {
    pub(crate) fn lex(&self, at: usize) -> Option<&Lex> {
        self.lexemes.get(at).map(|l| &l.lex)
    }

    pub(crate) fn class(&self, at: usize) -> Option<Class> {
        match self.lex(at)? {
            Lex::Word(class, _) => Some(*class),
            _ => None,
        }
    }

    /// The words of some lexemes as they were written.
    pub(crate) fn words(&self, at: Range<usize>) -> &str {
        let first = self.lexemes.get(at.start).and_then(|l| self.tokens.get(l.tokens.start));
        let last = self.lexemes.get(at.end.saturating_sub(1)).and_then(|l| self.tokens.get(l.tokens.end - 1));
        first.zip(last).and_then(|(a, b)| self.text.get(a.span.start..b.span.end)).unwrap_or_default()
    }

    pub(crate) fn token(&self, at: usize) -> Option<&Token> {
        self.tokens.get(self.lexemes.get(at)?.tokens.start)
    }

    pub(crate) fn is_plural(&self, at: usize) -> bool {
        let mut endings = LANGUAGES.iter().flat_map(|lexicon| lexicon.plural_endings);
        self.token(at).is_some_and(|t| t.text.len() > 3 && endings.any(|ending| t.text.ends_with(ending)))
    }

    /// The label at a place: a number, or a single capital.
    pub(crate) fn label(&self, at: usize) -> Option<&str> {
        match self.lex(at)? {
            Lex::Number { label, .. } => Some(label),
            Lex::Word(..) | Lex::Unknown => {
                let token = self.token(at)?;
                (token.capital && token.text.chars().count() == 1).then_some(token.text.as_str())
            }
            _ => None,
        }
    }

    /// The number in `第二个`, which is one word where it stands before things.
    pub(crate) fn ordinal_determiner(&self, at: usize) -> Option<u32> {
        let lexeme = self.lexemes.get(at).filter(|lexeme| lexeme.is(Class::Determiner))?;
        let [first, number, ..] = self.tokens.get(lexeme.tokens.clone())? else { return None };
        (first.text == "第").then(|| numbers::numeral(&number.text)).flatten()
    }

    pub(crate) fn is_ordinal(&self, at: usize) -> bool {
        matches!(self.lex(at), Some(Lex::Number { ordinal: true, .. }))
    }

    /// Whether the number at `at` may continue a list: nothing that is counted follows, and no level of its own.
    pub(crate) fn continues_list(&self, at: usize) -> bool {
        let number =
            matches!(self.lex(at), Some(Lex::Number { ordinal: false, .. })) || self.label(at).is_some();
        // `building 4 and one for building 5`
        let spelt = self.token(at).is_some_and(|t| t.kind == Kind::Letters && t.text.chars().count() > 1);
        let is_pronoun = spelt
            && self.label(at) == Some("1")
            && matches!(self.class(at + 1), Some(Class::Toward | Class::TowardOrAfter));
        let number = number && !is_pronoun;
        let alone = match self.lex(at + 1) {
            None | Some(Lex::Stop | Lex::Comma | Lex::Dash | Lex::Mark) => true,
            Some(Lex::Word(class, _)) => !matches!(
                class,
                Class::Building
                    | Class::WeakBuilding
                    | Class::Unit
                    | Class::Room
                    | Class::Floor
                    | Class::Item
                    | Class::Measure
            ),
            _ => false,
        };
        number && alone
    }
}
