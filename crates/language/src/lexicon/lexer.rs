//! From tokens to lexemes: the longest entry at each place, numbers put together, the rest unknown.

use std::ops::Range;

use super::class::Class;
use super::languages::{LANGUAGES, is_digit_separator};
use super::lexeme::{Lex, Lexeme};
use super::marks;
use super::numbers::number;
use super::tokens::{Kind, Token};
use super::words::{Match, Meaning, Vocabulary};

/// Reads tokens as lexemes; `names` are the token ranges of names on the map.
pub(crate) fn lexemes(
    tokens: &[Token],
    names: &[Range<usize>],
    vocabulary: Vocabulary<'_>,
) -> Vec<Lexeme> {
    let mut lexemes = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let name = names
            .iter()
            .position(|range| range.start == at && range.end > at);
        let (length, lex) = match name {
            Some(i) => (names[i].end - at, Lex::Name(i)),
            None => lexeme(tokens, at, vocabulary),
        };
        lexemes.push(Lexeme {
            lex,
            tokens: at..at + length,
        });
        at += length;
    }
    // Behind the first pass, since both steps depend on what stands beside a word.
    correct_spelling(&mut lexemes, tokens, vocabulary);
    count_articles(&mut lexemes, tokens, vocabulary);
    lexemes
}

/// The lexeme at a token, and how many tokens it takes.
fn lexeme(tokens: &[Token], at: usize, vocabulary: Vocabulary<'_>) -> (usize, Lex) {
    // Before words: a number may begin with a token that is a word of its own, such as a letter.
    if let Some(found) = number(tokens, at, vocabulary) {
        return (found.length, found.lex);
    }
    if let Some(Match {
        length,
        meaning: Meaning::Word(class),
        language,
    }) = vocabulary.longest(&tokens[at..])
    {
        return (length, Lex::Word(class, LANGUAGES[language].number_first));
    }
    (1, mark(tokens, at))
}

/// A token that is no word: a mark, or unknown.
fn mark(tokens: &[Token], at: usize) -> Lex {
    let text = tokens[at].text.as_str();
    let is_behind_digits = at > 0 && tokens[at - 1].kind == Kind::Digits;
    if marks::is_comma(text) {
        Lex::Comma
    } else if is_digit_separator(text) && is_behind_digits {
        Lex::Word(Class::And, true)
    } else if text == marks::POINT && is_initial(tokens, at) {
        Lex::Mark
    } else if marks::is_stop(text) {
        Lex::Stop
    } else if marks::is_dash(text) {
        Lex::Dash
    } else if tokens[at].kind == Kind::Mark {
        Lex::Mark
    } else {
        Lex::Unknown
    }
}

/// Whether the point at a token makes an initial of the capital before it: `J. Novak`.
fn is_initial(tokens: &[Token], at: usize) -> bool {
    let letter = at.checked_sub(1).map(|before| &tokens[before]);
    let is_letter = letter.is_some_and(|letter| letter.capital && letter.text.chars().count() == 1);
    is_letter && tokens[at].glued && tokens.get(at + 1).is_some_and(|next| next.capital)
}

/// Corrects unknown words beside a number to words for levels, and unknown words behind a word for
/// a level to numbers.
fn correct_spelling(lexemes: &mut [Lexeme], tokens: &[Token], vocabulary: Vocabulary<'_>) {
    for at in 0..lexemes.len() {
        if lexemes[at].lex == Lex::Unknown
            && !begins_a_span(lexemes, at)
            && is_beside_a_number(lexemes, at, tokens, vocabulary)
            && let Some(class) = vocabulary.misspelt_level(text(lexemes, at, tokens))
        {
            // Only words in letters are corrected, and their languages put the level first.
            lexemes[at].lex = Lex::Word(class, false);
        }
        let is_behind_a_level =
            at > 0 && (lexemes[at - 1].is(Class::Building) || lexemes[at - 1].is(Class::Unit));
        if lexemes[at].lex == Lex::Unknown
            && is_behind_a_level
            && let Some(number) = vocabulary.misspelt_number(text(lexemes, at, tokens))
        {
            lexemes[at].lex = Lex::cardinal(number);
        }
    }
}

/// The first token of a lexeme.
fn text<'a>(lexemes: &[Lexeme], at: usize, tokens: &'a [Token]) -> &'a str {
    lexemes
        .get(at)
        .map_or("", |lexeme| tokens[lexeme.tokens.start].text.as_str())
}

fn is_number(lexemes: &[Lexeme], at: usize) -> bool {
    matches!(
        lexemes.get(at).map(|lexeme| &lexeme.lex),
        Some(Lex::Number { .. })
    )
}

fn is_beside_a_number(
    lexemes: &[Lexeme],
    at: usize,
    tokens: &[Token],
    vocabulary: Vocabulary<'_>,
) -> bool {
    let is_unknown = |at: usize| {
        lexemes
            .get(at)
            .is_some_and(|lexeme| lexeme.lex == Lex::Unknown)
    };
    is_number(lexemes, at + 1)
        || at > 0 && is_number(lexemes, at - 1)
        || is_unknown(at + 1)
            && vocabulary
                .misspelt_number(text(lexemes, at + 1, tokens))
                .is_some()
}

/// `entre 2 et 4 heures`: the number behind a place begins a span of time.
fn begins_a_span(lexemes: &[Lexeme], at: usize) -> bool {
    is_number(lexemes, at + 1)
        && lexemes
            .get(at + 2)
            .is_some_and(|lexeme| lexeme.is(Class::And))
        && matches!(
            lexemes.get(at + 3).map(|lexeme| &lexeme.lex),
            Some(Lex::Quantity)
        )
}

/// `bâtiment un`: an article behind a word for a level is the number one, unless a thing follows
/// that it belongs to.
fn count_articles(lexemes: &mut [Lexeme], tokens: &[Token], vocabulary: Vocabulary<'_>) {
    let ones: Vec<&str> = vocabulary
        .languages()
        .flat_map(|language| language.ones)
        .copied()
        .collect();
    for at in 1..lexemes.len() {
        let is_one = ones.contains(&text(lexemes, at, tokens)) && lexemes[at].tokens.len() == 1;
        let is_behind_a_level = matches!(
            lexemes[at - 1].lex,
            Lex::Word(Class::Building | Class::Unit | Class::Room | Class::Sign, _)
        );
        // `unités trois et un`
        let is_listed = at > 2
            && (lexemes[at - 1].is(Class::And) || lexemes[at - 1].lex == Lex::Comma)
            && is_number(lexemes, at - 2);
        let is_of_a_thing = lexemes.get(at + 1).is_some_and(|next| next.is(Class::Item));
        if is_one && (is_behind_a_level || is_listed) && !is_of_a_thing {
            lexemes[at].lex = Lex::cardinal(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexicon::tokens::tokenize;
    use crate::lexicon::words::Words;

    fn lexes(text: &str) -> Vec<Lex> {
        let words = Words::new();
        let tokens = tokenize(text);
        lexemes(&tokens, &[], words.vocabulary(&tokens))
            .into_iter()
            .map(|l| l.lex)
            .collect()
    }

    #[test]
    fn the_longest_word_wins() {
        assert_eq!(
            lexes("3号楼"),
            [Lex::cardinal(3), Lex::Word(Class::Building, true)]
        );
        assert_eq!(lexes("instead of"), [Lex::Word(Class::Not, false)]);
    }

    #[test]
    fn a_word_that_two_languages_have_counts_in_the_language_of_the_text() {
        assert!(lexes("Lleva la caja al edificio once").contains(&Lex::cardinal(11)));
        assert!(!lexes("Bring it at once to the building").contains(&Lex::cardinal(11)));
    }

    #[test]
    fn words_for_levels_survive_typing_errors() {
        assert_eq!(lexes("buidling 3")[0], Lex::Word(Class::Building, false));
        assert_eq!(lexes("untit 3")[0], Lex::Word(Class::Unit, false));
        assert_eq!(lexes("sunday 3")[0], Lex::Unknown);
    }
}
