//! What a text holds that can support an address or its denial, whatever the text means.

use super::mentions::mention::Target;
use super::mentions::mentions;
use super::names;
use super::reading::Reading;
use crate::gazetteer::Gazetteer;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::{Lex, Lexeme};
use crate::lexicon::lexer::lexemes;
use crate::lexicon::tokens::{condensed, tokenize};
use crate::lexicon::words::Words;

/// What an instruction holds that can support an address.
pub(crate) struct Evidence {
    /// Numbers and letters, folded.
    pub labels: Vec<String>,
    /// Places whose names stand in the text: indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
    /// All its letters and digits, folded.
    pub letters: String,
    /// Whether it speaks of all units of a building.
    pub all_units: bool,
}

impl Evidence {
    /// The numbers and names that a text mentions at all, meant or not.
    pub(crate) fn of(text: &str, words: &Words, gazetteer: &Gazetteer) -> Self {
        let tokens = tokenize(text);
        let vocabulary = words.vocabulary(&tokens);
        let names = names::find(&tokens, gazetteer, &vocabulary.known(&tokens));
        // Numbers inside of names count as well. `with_names` hides them.
        let without_names = lexemes(&tokens, &[], vocabulary);
        let with_names = lexemes(&tokens, &names::ranges(&names), vocabulary);
        let mentions = mentions(&Reading {
            text,
            tokens: &tokens,
            lexemes: &with_names,
        });
        let targets = || mentions.iter().flat_map(|mention| &mention.targets);
        let mut labels: Vec<String> = without_names.into_iter().filter_map(number).collect();
        labels.extend(targets().filter_map(label));
        Self {
            labels,
            places: names.into_iter().flat_map(|name| name.places).collect(),
            letters: condensed(text),
            all_units: targets().any(|target| matches!(target, Target::All { .. })),
        }
    }
}

/// The label of a number.
fn number(lexeme: Lexeme) -> Option<String> {
    match lexeme.lex {
        Lex::Number { label, .. } => Some(label),
        _ => None,
    }
}

fn label(target: &Target) -> Option<String> {
    match target {
        Target::Label { label, .. } => Some(label.clone()),
        _ => None,
    }
}

/// Whether a text may deny a place, known or not: whether it says more than an address and where
/// to.
pub(crate) fn may_deny(text: &str, words: &Words) -> bool {
    let tokens = tokenize(text);
    lexemes(&tokens, &[], words.vocabulary(&tokens))
        .iter()
        .any(|lexeme| match lexeme.lex {
            Lex::Unknown => true,
            Lex::Word(class, _) => denies(class),
            _ => false,
        })
}

fn denies(class: Class) -> bool {
    matches!(
        class,
        Class::Not
            | Class::Except
            | Class::NotBefore
            | Class::Dropped
            | Class::Absent
            | Class::Correct
            | Class::Instead
            | Class::Elsewhere
            | Class::Sender
            | Class::Sends
    )
}

/// The label of a unit that stands alone: `unit1`, `1`, `Entrance B`.
pub(crate) fn unit_label(text: &str, words: &Words) -> Option<String> {
    let tokens = tokenize(text);
    let lexemes = lexemes(&tokens, &[], words.vocabulary(&tokens));
    let mentions = mentions(&Reading {
        text,
        tokens: &tokens,
        lexemes: &lexemes,
    });
    let target = mentions.first().and_then(|mention| mention.targets.first());
    if let Some(label) = target.and_then(label) {
        return Some(label);
    }
    match lexemes.as_slice() {
        [
            Lexeme {
                lex: Lex::Number { label, .. },
                ..
            },
        ] => Some(label.clone()),
        // A single letter, whatever its case: models write labels in either.
        [_] if tokens[0].text.chars().count() == 1 => Some(tokens[0].text.clone()),
        _ => None,
    }
}
