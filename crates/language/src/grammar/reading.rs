//! What the stages of the grammar read: the instruction, its tokens and its lexemes.

use std::ops::Range;

use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::languages::{has_feature, has_plural_ending, numeral, words_with};
use crate::lexicon::lexeme::{Lex, Lexeme};
use crate::lexicon::tokens::{Kind, Token};

/// Words with a plural ending are longer than this, in bytes.
const LONGEST_WITHOUT_PLURAL: usize = 3;

/// An instruction, its tokens and its lexemes. Places are indices of lexemes.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    pub text: &'a str,
    pub tokens: &'a [Token],
    pub lexemes: &'a [Lexeme],
}

impl Reading<'_> {
    /// The lexeme at a place.
    pub(crate) fn lex(&self, at: usize) -> Option<&Lex> {
        self.lexemes.get(at).map(|lexeme| &lexeme.lex)
    }

    /// The class of the word at a place.
    pub(crate) fn class(&self, at: usize) -> Option<Class> {
        match self.lex(at)? {
            Lex::Word(class, _) => Some(*class),
            _ => None,
        }
    }

    /// Whether a sentence ends at a place.
    pub(crate) fn is_stop(&self, at: usize) -> bool {
        self.lex(at) == Some(&Lex::Stop)
    }

    /// Whether the number at a place counts, and does not order.
    pub(crate) fn is_cardinal(&self, at: usize) -> bool {
        matches!(self.lex(at), Some(Lex::Number { ordinal: false, .. }))
    }

    /// Whether the number at a place orders: `2nd`, `second`.
    pub(crate) fn is_ordinal(&self, at: usize) -> bool {
        matches!(self.lex(at), Some(Lex::Number { ordinal: true, .. }))
    }

    /// The words of some lexemes as they were written.
    pub(crate) fn words(&self, at: Range<usize>) -> &str {
        let first = self
            .lexemes
            .get(at.start)
            .and_then(|l| self.tokens.get(l.tokens.start));
        let last = self.lexemes.get(at.end.saturating_sub(1));
        let last = last.and_then(|l| self.tokens.get(l.tokens.end - 1));
        let span = first
            .zip(last)
            .map(|(first, last)| first.span.start..last.span.end);
        span.and_then(|span| self.text.get(span))
            .unwrap_or_default()
    }

    /// The first token of a lexeme.
    pub(crate) fn token(&self, at: usize) -> Option<&Token> {
        self.tokens.get(self.lexemes.get(at)?.tokens.start)
    }

    /// Whether the first token of a lexeme is this text, folded.
    pub(crate) fn begins_with(&self, at: usize, text: &str) -> bool {
        self.token(at).is_some_and(|token| token.text == text)
    }

    /// Whether no white space stands before a lexeme.
    pub(crate) fn is_glued(&self, at: usize) -> bool {
        self.token(at).is_some_and(|token| token.glued)
    }

    /// Whether the first token of a lexeme has a feature.
    pub(crate) fn has(&self, at: usize, feature: Feature) -> bool {
        self.token(at)
            .is_some_and(|token| has_feature(&token.text, feature))
    }

    /// Whether the lexemes from a place on spell a word with a feature, an ideograph each.
    pub(crate) fn spells(&self, at: usize, feature: Feature) -> bool {
        words_with(feature).any(|word| {
            word.chars()
                .enumerate()
                .all(|(i, c)| self.begins_with(at + i, c.encode_utf8(&mut [0; 4])))
        })
    }

    /// Whether the word at a place ends as a plural.
    pub(crate) fn is_plural(&self, at: usize) -> bool {
        self.token(at).is_some_and(|token| {
            token.text.len() > LONGEST_WITHOUT_PLURAL && has_plural_ending(&token.text)
        })
    }

    /// The label at a place: a number, or a single capital.
    pub(crate) fn label(&self, at: usize) -> Option<&str> {
        match self.lex(at)? {
            Lex::Number { label, .. } => Some(label),
            Lex::Word(..) | Lex::Unknown => {
                let token = self.token(at)?;
                let is_capital = token.capital && token.text.chars().count() == 1;
                is_capital.then_some(token.text.as_str())
            }
            _ => None,
        }
    }

    /// The number in `第二个`, which is one word where it stands before things.
    pub(crate) fn ordinal_determiner(&self, at: usize) -> Option<u32> {
        let lexeme = self
            .lexemes
            .get(at)
            .filter(|lexeme| lexeme.is(Class::Determiner))?;
        let [prefix, number, ..] = self.tokens.get(lexeme.tokens.clone())? else {
            return None;
        };
        has_feature(&prefix.text, Feature::OrdinalPrefix)
            .then(|| numeral(&number.text))
            .flatten()
    }

    /// Whether the label at a place may continue a list: nothing that it counts follows, and no
    /// level of its own.
    pub(crate) fn continues_list(&self, at: usize) -> bool {
        let is_label = self.is_cardinal(at) || self.label(at).is_some();
        is_label && !self.is_pronoun(at) && self.counts_nothing(at + 1)
    }

    /// `building 4 and one for building 5`
    fn is_pronoun(&self, at: usize) -> bool {
        let is_spelt = self
            .token(at)
            .is_some_and(|token| token.kind == Kind::Letters && token.text.chars().count() > 1);
        is_spelt
            && self.label(at) == Some("1")
            && matches!(
                self.class(at + 1),
                Some(Class::Toward | Class::TowardOrAfter)
            )
    }

    /// Whether what stands behind a number is nothing that it counts.
    fn counts_nothing(&self, behind: usize) -> bool {
        match self.lex(behind) {
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
        }
    }
}
