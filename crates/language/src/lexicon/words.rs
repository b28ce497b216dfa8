//! The words of all languages, indexed by their first token, and those that a text is read with.
//!
//! English is assumed unless another language in Latin letters has more words in the text.
//! Ideographs are Chinese unless there is kana. Words for levels (`building`, `单元`) are found in
//! every language if a number follows, since instructions quote signs.

use std::collections::HashMap;

use super::class::Class;
use super::edit_distance::edit_distance;
use super::language::{Language, Script};
use super::languages::{LANGUAGES, numeral};
use super::times::FoldedTimes;
use super::tokens::{Kind, Token, condensed, is_kana, tokenize};

/// Shorter words are not corrected to words for levels, in characters.
const SHORTEST_LEVEL: usize = 4;
/// From this length on, in characters, a word for a level may have two typing errors.
const LONG_LEVEL: usize = 7;
/// Shorter words are not corrected to numbers, in characters.
const SHORTEST_NUMBER: usize = 4;

/// What an entry of a lexicon means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    Word(Class),
    Cardinal(u32),
    Ordinal(u32),
}

impl Meaning {
    fn names_a_level(self) -> bool {
        matches!(
            self,
            Self::Word(Class::Building | Class::Unit | Class::Room)
        )
    }
}

/// An entry, by its first token in [`Words::entries`].
struct Entry {
    /// Its other tokens.
    rest: Vec<String>,
    meaning: Meaning,
    /// Index into [`LANGUAGES`].
    language: usize,
}

impl Entry {
    fn fits(&self, tokens: &[Token]) -> bool {
        let rest = &tokens[1..];
        rest.len() >= self.rest.len()
            && self
                .rest
                .iter()
                .zip(rest)
                .all(|(word, token)| *word == token.text)
    }
}

/// A single word for a level, which is found in spite of typing errors.
struct LevelWord {
    text: String,
    class: Class,
    /// Index into [`LANGUAGES`].
    language: usize,
}

impl LevelWord {
    /// Whether `text` was probably meant to be this word: the first letter is always right.
    fn is_near(&self, text: &str) -> bool {
        let edits = if self.text.chars().count() >= LONG_LEVEL {
            2
        } else {
            1
        };
        self.text.chars().next() == text.chars().next()
            && edit_distance(&self.text, text, edits) <= edits
    }
}

/// An entry that stands at the beginning of some tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Match {
    /// How many tokens it takes.
    pub length: usize,
    pub meaning: Meaning,
    /// Index into [`LANGUAGES`].
    pub language: usize,
}

/// Languages, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LanguageSet(u8);

impl LanguageSet {
    /// Those for whose index into [`LANGUAGES`] `is_in` holds.
    fn of(is_in: impl Fn(usize) -> bool) -> Self {
        Self(
            (0..LANGUAGES.len())
                .filter(|i| is_in(*i))
                .fold(0, |mask, i| mask | 1 << i),
        )
    }

    fn contains(self, language: usize) -> bool {
        self.0 & (1 << language) != 0
    }
}

/// The words of all languages.
pub(crate) struct Words {
    /// By the first token, the longest first.
    entries: HashMap<String, Vec<Entry>>,
    levels: Vec<LevelWord>,
    /// Of each language.
    times: Vec<FoldedTimes>,
}

impl Words {
    /// Indexes all languages.
    pub(crate) fn new() -> Self {
        let times = LANGUAGES
            .iter()
            .map(|language| FoldedTimes::new(&language.times))
            .collect();
        let mut words = Self {
            entries: HashMap::new(),
            levels: Vec::new(),
            times,
        };
        for (i, language) in LANGUAGES.iter().enumerate() {
            words.add_language(language, i);
        }
        for list in words.entries.values_mut() {
            // A stable sort: entries of one length stay in the order of the languages.
            list.sort_by_key(|entry| std::cmp::Reverse(entry.rest.len()));
        }
        words
    }

    fn add_language(&mut self, language: &Language, index: usize) {
        for (class, list) in language.words {
            list.iter()
                .for_each(|word| self.add(word, Meaning::Word(*class), index));
        }
        for (word, value) in language.cardinals {
            self.add(word, Meaning::Cardinal(*value), index);
        }
        for (word, value) in language.ordinals {
            self.add(word, Meaning::Ordinal(*value), index);
        }
    }

    fn add(&mut self, word: &str, meaning: Meaning, language: usize) {
        let mut texts = tokenize(word).into_iter().map(|token| token.text);
        let Some(first) = texts.next() else { return };
        let rest: Vec<String> = texts.collect();
        if let Meaning::Word(class) = meaning
            && meaning.names_a_level()
            && rest.is_empty()
            && first.chars().count() >= SHORTEST_LEVEL
        {
            self.levels.push(LevelWord {
                text: first.clone(),
                class,
                language,
            });
        }
        self.entries.entry(first).or_default().push(Entry {
            rest,
            meaning,
            language,
        });
    }

    /// The words that a text is read with.
    pub(crate) fn vocabulary(&self, tokens: &[Token]) -> Vocabulary<'_> {
        Vocabulary {
            words: self,
            languages: self.languages(tokens),
        }
    }

    /// The languages of a text: the one in Latin letters with the most words in it, and the one
    /// that its ideographs are of.
    fn languages(&self, tokens: &[Token]) -> LanguageSet {
        let scores = self.scores(tokens);
        let is_latin = |i: &usize| LANGUAGES[*i].script == Script::Latin;
        // Of equals the first language.
        let best = (0..LANGUAGES.len())
            .filter(is_latin)
            // `max_by_key` returns the last of equals, so the languages are reversed.
            .rev()
            .max_by_key(|i| scores[*i]);
        let best = best.unwrap_or_default();
        // Japanese is hardly ever written without kana, and Chinese never with them.
        let has_kana = tokens.iter().any(|token| token.text.chars().any(is_kana));
        let ideographs = if has_kana { Script::Kana } else { Script::Han };
        LanguageSet::of(|i| i == best || LANGUAGES[i].script == ideographs)
    }

    /// How many tokens of a text each language has words for. At each token the first entry of a
    /// language counts.
    fn scores(&self, tokens: &[Token]) -> [usize; LANGUAGES.len()] {
        let mut scores = [0; LANGUAGES.len()];
        let letters = (0..tokens.len()).filter(|at| tokens[*at].kind == Kind::Letters);
        for at in letters {
            let found = self.entries.get(&tokens[at].text).into_iter().flatten();
            let mut seen = [false; LANGUAGES.len()];
            for entry in found.filter(|entry| entry.fits(&tokens[at..])) {
                // Its longest one, since entries are sorted by length.
                if !std::mem::replace(&mut seen[entry.language], true) {
                    scores[entry.language] += 1 + entry.rest.len();
                }
            }
        }
        scores
    }

    /// Whether a token may be, or begin, a number or a letter that labels.
    pub(crate) fn may_label(&self, token: &Token) -> bool {
        match token.kind {
            Kind::Digits => true,
            Kind::Ideograph => numeral(&token.text).is_some(),
            Kind::Letters => {
                token.text.chars().count() == 1 || self.begins_a_spelt_number(&token.text)
            }
            Kind::Mark => false,
        }
    }

    fn begins_a_spelt_number(&self, text: &str) -> bool {
        let is_number = |entry: &Entry| !matches!(entry.meaning, Meaning::Word(_));
        self.entries
            .get(text)
            .is_some_and(|list| list.iter().any(is_number))
    }
}

/// The words that a text is read with: all words, and the languages in force.
#[derive(Clone, Copy)]
pub(crate) struct Vocabulary<'a> {
    words: &'a Words,
    languages: LanguageSet,
}

impl<'a> Vocabulary<'a> {
    /// The languages in force.
    pub(crate) fn languages(self) -> impl Iterator<Item = &'static Language> {
        (0..LANGUAGES.len())
            .filter(move |i| self.languages.contains(*i))
            .map(|i| LANGUAGES[i])
    }

    /// The words of deadlines of the languages in force.
    pub(crate) fn times(self) -> impl Iterator<Item = &'a FoldedTimes> {
        let all = self.words.times.iter().enumerate();
        all.filter(move |(i, _)| self.languages.contains(*i))
            .map(|(_, times)| times)
    }

    /// The longest entry at the beginning of `tokens`. Of several of one length the first whose
    /// language is in force wins, else the first.
    pub(crate) fn longest(self, tokens: &[Token]) -> Option<Match> {
        let entries = self.words.entries.get(&tokens.first()?.text)?;
        let is_active = |entry: &Entry| self.languages.contains(entry.language);
        let fitting = entries
            .iter()
            .filter(|entry| is_active(entry) || is_sign(entry, tokens))
            .filter(|entry| entry.fits(tokens));
        let best = fitting.reduce(|best, entry| {
            let longer = entry.rest.len() > best.rest.len();
            let nearer =
                entry.rest.len() == best.rest.len() && is_active(entry) && !is_active(best);
            if longer || nearer { entry } else { best }
        })?;
        let length = 1 + best.rest.len();
        Some(Match {
            length,
            meaning: best.meaning,
            language: best.language,
        })
    }

    /// Which tokens are words of a lexicon.
    pub(crate) fn known(self, tokens: &[Token]) -> Vec<bool> {
        let mut known = vec![false; tokens.len()];
        for at in 0..tokens.len() {
            let found = self.longest(&tokens[at..]);
            if let Some(Match {
                length,
                meaning: Meaning::Word(_),
                ..
            }) = found
            {
                known[at..at + length].fill(true);
            }
        }
        known
    }

    /// Whether the longest entry at the beginning of `tokens` is a word of a class.
    pub(crate) fn begins_with(self, tokens: &[Token], class: Class) -> bool {
        self.longest(tokens)
            .is_some_and(|found| found.meaning == Meaning::Word(class))
    }

    /// The word for a level that `text` was probably meant to be.
    pub(crate) fn misspelt_level(self, text: &str) -> Option<Class> {
        if text.chars().count() < SHORTEST_LEVEL {
            return None;
        }
        let mut active = self
            .words
            .levels
            .iter()
            .filter(|level| self.languages.contains(level.language));
        active
            .find(|level| level.is_near(text))
            .map(|level| level.class)
    }

    /// The number that a word was probably meant to be, if only one is one error away: `sevn`.
    pub(crate) fn misspelt_number(self, text: &str) -> Option<u32> {
        if text.chars().count() < SHORTEST_NUMBER {
            return None;
        }
        let is_near = |word: &str| edit_distance(&condensed(word), text, 1) <= 1;
        let cardinals = self.languages().flat_map(|language| language.cardinals);
        let mut found = cardinals
            .filter(|(word, _)| is_near(word))
            .map(|(_, number)| *number);
        let number = found.next()?;
        found.all(|other| other == number).then_some(number)
    }
}

/// Whether an entry is a word for a level with its number behind it. `Hall` is a French entrance
/// only with its number.
fn is_sign(entry: &Entry, tokens: &[Token]) -> bool {
    let next = tokens.get(1 + entry.rest.len());
    entry.meaning.names_a_level() && next.is_some_and(|token| token.kind == Kind::Digits)
}
