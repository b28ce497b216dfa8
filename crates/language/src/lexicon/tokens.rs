//! The instruction as tokens: runs of letters, runs of digits, single ideographs, marks.
//!
//! Text is folded for comparison ([`folding`](super::folding)). Each token keeps its place in the
//! original, so that items and names are quoted as they were written. Combining accents do not end
//! a run of letters.

use std::ops::Range;

use super::folding::{half_width, is_combining, push_folded};

/// What kind of characters a token is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Letters of an alphabet.
    Letters,
    /// ASCII digits, after folding.
    Digits,
    /// One character of a script without spaces between words.
    Ideograph,
    /// Anything else but white space.
    Mark,
}

/// A piece of the instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Token {
    /// Folded.
    pub text: String,
    /// Bytes of the original.
    pub span: Range<usize>,
    /// What it is made of.
    pub kind: Kind,
    /// Whether it follows the token before without white space.
    pub glued: bool,
    /// Whether it begins with a capital.
    pub capital: bool,
}

/// Takes `text` apart.
pub(crate) fn tokenize(text: &str) -> Vec<Token> {
    let mut tokens: Vec<Token> = Vec::new();
    let mut spaced = true;
    for (at, original) in text.char_indices() {
        // Skipped before white space is noted: a letter behind an accent still joins its word.
        if is_combining(original) {
            continue;
        }
        let folded = half_width(original);
        if folded.is_whitespace() || folded.is_control() {
            spaced = true;
            continue;
        }
        let kind = kind_of(folded);
        let end = at + original.len_utf8();
        // Ideographs and marks are tokens of one character each, since no spaces part their words.
        let joins = !spaced && matches!(kind, Kind::Letters | Kind::Digits);
        match tokens.last_mut().filter(|last| joins && last.kind == kind) {
            Some(last) => {
                push_folded(&mut last.text, folded);
                last.span.end = end;
            }
            None => {
                let mut text = String::new();
                push_folded(&mut text, folded);
                let capital = folded.is_uppercase();
                tokens.push(Token {
                    text,
                    span: at..end,
                    kind,
                    glued: !spaced,
                    capital,
                });
            }
        }
        spaced = false;
    }
    tokens
}

fn kind_of(c: char) -> Kind {
    if c.is_ascii_digit() {
        Kind::Digits
    } else if is_ideograph(c) {
        Kind::Ideograph
    } else if c.is_alphabetic() {
        Kind::Letters
    } else {
        Kind::Mark
    }
}

fn is_ideograph(c: char) -> bool {
    matches!(
        c,
        // In this order: iteration marks and the zero, kana, CJK extension A, CJK, Hangul
        // syllables, compatibility ideographs, supplementary planes.
        '\u{3005}'..='\u{3007}'
            | '\u{3040}'..='\u{30FF}'
            | '\u{3400}'..='\u{4DBF}'
            | '\u{4E00}'..='\u{9FFF}'
            | '\u{AC00}'..='\u{D7A3}'
            | '\u{F900}'..='\u{FAFF}'
            | '\u{20000}'..='\u{2FFFF}'
    )
}

/// Whether `c` is Japanese kana, which Chinese text does not have.
pub(crate) fn is_kana(c: char) -> bool {
    matches!(c, '\u{3040}'..='\u{30FF}')
}

/// `text` folded and without everything but letters, digits and ideographs: what names are compared
/// by.
pub(crate) fn condensed(text: &str) -> String {
    letters(&tokenize(text))
}

/// The words, numbers and ideographs of `text`, folded, each between marks: one text's stand in
/// another's only as whole words, side by side.
pub(crate) fn spelt(text: &str) -> String {
    let tokens = tokenize(text);
    let words = tokens
        .iter()
        .filter(|t| t.kind != Kind::Mark)
        .map(|t| t.text.as_str());
    words.fold(String::from(BETWEEN), |all, word| all + word + BETWEEN)
}

/// What no word holds.
const BETWEEN: &str = "\u{1f}";

/// The letters, digits and ideographs of some tokens.
pub(crate) fn letters(tokens: &[Token]) -> String {
    tokens
        .iter()
        .filter(|t| t.kind != Kind::Mark)
        .map(|t| t.text.as_str())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<String> {
        tokenize(text).into_iter().map(|t| t.text).collect()
    }

    #[test]
    fn letters_and_digits_are_separate_tokens() {
        assert_eq!(
            texts("Unit1, B8-U3!"),
            ["unit", "1", ",", "b", "8", "-", "u", "3", "!"]
        );
        assert_eq!(texts("請送到３號樓"), ["请", "送", "到", "3", "号", "楼"]);
        assert_eq!(
            texts("Gebäude Œuvre Straße"),
            ["gebaude", "oeuvre", "strasse"]
        );
    }

    #[test]
    fn spans_point_into_the_original() {
        let text = "  Bâtiment 4é";
        let spans: Vec<&str> = tokenize(text)
            .iter()
            .map(|t| &text[t.span.clone()])
            .collect();
        assert_eq!(spans, ["Bâtiment", "4", "é"]);
        assert!(tokenize(text)[2].glued && !tokenize(text)[1].glued);
    }

    #[test]
    fn a_combining_accent_is_the_same_as_a_composed_one() {
        assert_eq!(texts("ba\u{302}timent"), texts("bâtiment"));
    }
}
