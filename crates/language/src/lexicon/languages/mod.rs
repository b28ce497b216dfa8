//! The words of each language as data: one file a language, one table each.
//!
//! Entries are written naturally (accents, several words, apostrophes); the index folds them as it
//! folds instructions. A new language is a new file and a line in [`LANGUAGES`].

mod de;
mod en;
mod es;
mod fr;
mod ja;
mod zh;

use super::class::Class;
use super::feature::Feature;
use super::language::Language;

/// All languages; the first is the one assumed in doubt.
pub(crate) const LANGUAGES: [&Language; 6] = [
    &en::LANGUAGE,
    &zh::LANGUAGE,
    &es::LANGUAGE,
    &de::LANGUAGE,
    &fr::LANGUAGE,
    &ja::LANGUAGE,
];

/// Words with a feature in any language.
pub(crate) fn words_with(feature: Feature) -> impl Iterator<Item = &'static str> {
    let lists = LANGUAGES.iter().flat_map(|language| language.features);
    lists
        .filter(move |(own, _)| *own == feature)
        .flat_map(|(_, words)| *words)
        .copied()
}

/// Whether a word, folded, has a feature in any language.
pub(crate) fn has_feature(word: &str, feature: Feature) -> bool {
    words_with(feature).any(|own| own == word)
}

/// Entries of a class in any language.
pub(crate) fn words_of(class: Class) -> impl Iterator<Item = &'static str> {
    let lists = LANGUAGES.iter().flat_map(|language| language.words);
    lists
        .filter(move |(own, _)| *own == class)
        .flat_map(|(_, words)| *words)
        .copied()
}

/// The number that an ideograph is in any language.
pub(crate) fn numeral(ideograph: &str) -> Option<u32> {
    let mut all = LANGUAGES.iter().flat_map(|language| language.numerals);
    all.find(|(text, _)| *text == ideograph)
        .map(|(_, value)| *value)
}

/// Whether a mark lists numbers in any language, right behind digits.
pub(crate) fn is_digit_separator(mark: &str) -> bool {
    LANGUAGES
        .iter()
        .any(|language| language.digit_separators.contains(&mark))
}

/// Whether a word, folded, ends as plurals of words for levels do in any language.
pub(crate) fn has_plural_ending(word: &str) -> bool {
    LANGUAGES
        .iter()
        .flat_map(|language| language.plural_endings)
        .any(|ending| word.ends_with(ending))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::lexicon::tokens::tokenize;

    #[test]
    fn no_language_lists_a_word_twice() {
        for language in LANGUAGES {
            let mut seen = BTreeSet::new();
            let words = language.words.iter().flat_map(|(_, words)| words.iter());
            for word in words.chain(language.cardinals.iter().map(|(w, _)| w)) {
                assert!(seen.insert(*word), "`{word}` stands twice");
            }
        }
    }

    #[test]
    fn every_language_can_say_an_address() {
        for language in LANGUAGES {
            let denies = |class: Class| matches!(class, Class::Not | Class::NotBefore);
            assert!(
                language
                    .words
                    .iter()
                    .any(|(class, words)| denies(*class) && !words.is_empty())
            );
            for class in [
                Class::Building,
                Class::Unit,
                Class::And,
                Class::Then,
                Class::All,
                Class::Item,
            ] {
                assert!(
                    language
                        .words
                        .iter()
                        .any(|(c, words)| *c == class && !words.is_empty()),
                    "{class:?}"
                );
            }
        }
    }

    /// The grammar compares these with folded tokens as they are.
    #[test]
    fn features_and_numerals_are_folded() {
        for language in LANGUAGES {
            let features = language
                .features
                .iter()
                .flat_map(|(_, words)| *words)
                .copied();
            let numerals = language.numerals.iter().map(|(text, _)| *text);
            let endings = language.plural_endings.iter().copied();
            for word in features.chain(numerals).chain(endings) {
                let folded: String = tokenize(word).into_iter().map(|token| token.text).collect();
                assert_eq!(folded, word);
            }
        }
    }
}
