//! From tokens to lexemes: the longest entry of the active languages at each place, numbers put together, the rest unknown.
//!
//! English is assumed unless another language in Latin letters has more words in the text; ideographs are Chinese unless there
//! is kana. Words for levels (`building`, `单元`) count in every language, since instructions quote signs.

use std::collections::HashMap;
use std::ops::Range;

use super::deadlines::FoldedTimes;
use super::lexicon::{Class, LANGUAGES, Script};
use super::numbers;
use super::text::{Kind, Token, is_kana, tokenize};

/// What an entry of a lexicon means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    Word(Class),
    Cardinal(u32),
    Ordinal(u32),
}

struct Entry {
    rest: Vec<String>,
    meaning: Meaning,
    language: usize,
}

/// What stands at a place of the instruction.
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

/// A [`Lex`] and the tokens that it is made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Lexeme {
    pub lex: Lex,
    pub tokens: Range<usize>,
}

impl Lexeme {
    pub(crate) fn is(&self, class: Class) -> bool {
        matches!(self.lex, Lex::Word(c, _) if c == class)
    }
}

/// All lexicons, by the first token of each entry.
pub(crate) struct Words {
    entries: HashMap<String, Vec<Entry>>,
    /// Single words for levels and their languages, to be found in spite of typing errors.
    levels: Vec<(String, Class, usize)>,
    /// How each language says until when.
    pub(super) times: Vec<FoldedTimes>,
}

/// Shorter words are not mended to numbers.
const SHORTEST_MISSPELT: usize = 4;

/// The languages in force, one bit each.
pub(crate) type Languages = u8;

impl Words {
    pub(crate) fn new() -> Self {
        let times = LANGUAGES.iter().map(|lexicon| FoldedTimes::new(&lexicon.times)).collect();
        let mut words = Self { entries: HashMap::new(), levels: Vec::new(), times };
        for (language, lexicon) in LANGUAGES.iter().enumerate() {
            for (class, list) in lexicon.words {
                list.iter().for_each(|word| words.add(word, Meaning::Word(*class), language));
            }
            lexicon.cardinals.iter().for_each(|(word, n)| words.add(word, Meaning::Cardinal(*n), language));
            lexicon.ordinals.iter().for_each(|(word, n)| words.add(word, Meaning::Ordinal(*n), language));
        }
        for list in words.entries.values_mut() {
            list.sort_by_key(|entry| std::cmp::Reverse(entry.rest.len()));
        }
        words
    }

    fn add(&mut self, word: &str, meaning: Meaning, language: usize) {
        let mut texts = tokenize(word).into_iter().map(|token| token.text);
        let Some(first) = texts.next() else { return };
        let rest: Vec<String> = texts.collect();
        if let Meaning::Word(class @ (Class::Building | Class::Unit | Class::Room)) = meaning
            && rest.is_empty()
            && first.chars().count() >= 4
        {
            self.levels.push((first.clone(), class, language));
        }
        self.entries.entry(first).or_default().push(Entry { rest, meaning, language });
    }

    /// The languages of a text.
    pub(crate) fn languages(&self, tokens: &[Token]) -> Languages {
        let kana = tokens.iter().any(|t| t.text.chars().any(is_kana));
        let mut scores = [0_usize; LANGUAGES.len()];
        for at in 0..tokens.len() {
            let found = self.entries.get(&tokens[at].text);
            let mut seen: Languages = 0;
            for entry in found.into_iter().flatten().filter(|entry| entry.fits(&tokens[at..])) {
                if seen & (1 << entry.language) == 0 && tokens[at].kind == Kind::Letters {
                    seen |= 1 << entry.language;
                    scores[entry.language] += 1 + entry.rest.len();
                }
            }
        }
        let latin = |i: &usize| LANGUAGES[*i].script == Script::Latin;
        let best = (0..LANGUAGES.len()).filter(latin).rev().max_by_key(|i| scores[*i]).unwrap_or_default();
        let ideographs = if kana { Script::Kana } else { Script::Han };
        let active = |i: &usize| *i == best || LANGUAGES[*i].script == ideographs;
        (0..LANGUAGES.len()).filter(active).fold(0, |mask, i| mask | 1 << i)
    }

    /// The longest entry at the beginning of `tokens`: how many tokens, what it means, whose it is.
    pub(crate) fn longest(&self, tokens: &[Token], languages: Languages) -> Option<(usize, Meaning, usize)> {
        let entries = self.entries.get(&tokens.first()?.text)?;
        let active = |entry: &Entry| languages & (1 << entry.language) != 0;
        // Signs are quoted in any language, but `Hall` is a French entrance only with its number.
        let is_sign = |entry: &Entry| {
            let next = tokens.get(1 + entry.rest.len());
            entry.meaning.names_a_level() && next.is_some_and(|t| t.kind == Kind::Digits)
        };
        let fitting = entries.iter().filter(|entry| active(entry) || is_sign(entry));
        let fitting = fitting.filter(|entry| entry.fits(tokens));
        // The first of the longest whose language is in force, else the first of the longest.
        let best = fitting.reduce(|best, entry| {
            let longer = entry.rest.len() > best.rest.len();
            let nearer = entry.rest.len() == best.rest.len() && active(entry) && !active(best);
            if longer || nearer { entry } else { best }
        })?;
        Some((1 + best.rest.len(), best.meaning, best.language))
    }

    /// Whether a token may be, or begin, a number or a letter that labels.
    pub(crate) fn may_label(&self, token: &Token) -> bool {
        let number = |entry: &Entry| !matches!(entry.meaning, Meaning::Word(_));
        match token.kind {
            Kind::Digits => true,
            Kind::Ideograph => numbers::numeral(&token.text).is_some(),
            Kind::Letters => {
                let spelt = || self.entries.get(&token.text).is_some_and(|list| list.iter().any(number));
                token.text.chars().count() == 1 || spelt()
            }
            Kind::Mark => false,
        }
    }

    /// The word for a level that `text` was probably meant to be.
    fn misspelt_level(&self, text: &str, languages: Languages) -> Option<Class> {
        let near = |word: &str| {
            let edits = if word.chars().count() >= 7 { 2 } else { 1 };
            word.chars().next() == text.chars().next() && edit_distance(word, text, edits) <= edits
        };
        let long_enough = text.chars().count() >= 4;
        let is_active = |language: usize| languages & (1 << language) != 0;
        let mut active = self.levels.iter().filter(|(.., language)| long_enough && is_active(*language));
        active.find(|(word, ..)| near(word)).map(|(_, class, _)| *class)
    }

    /// Takes the tokens for lexemes; `names` are the token ranges of names on the map.
    pub(crate) fn lexemes(
        &self,
        tokens: &[Token],
        names: &[Range<usize>],
        languages: Languages,
    ) -> Vec<Lexeme> {
        let mut lexemes = Vec::new();
        let mut at = 0;
        while at < tokens.len() {
            let name = names.iter().position(|range| range.start == at && range.end > at);
            let (length, lex) = match name {
                Some(i) => (names[i].end - at, Lex::Name(i)),
                None => self.lexeme(tokens, at, languages),
            };
            lexemes.push(Lexeme { lex, tokens: at..at + length });
            at += length;
        }
        self.mend_levels(&mut lexemes, tokens, languages);
        count_articles(&mut lexemes, tokens, languages);
        lexemes
    }

    fn lexeme(&self, tokens: &[Token], at: usize, languages: Languages) -> (usize, Lex) {
        if let Some(found) = numbers::number(self, tokens, at, languages) {
            return found;
        }
        if let Some((length, Meaning::Word(class), language)) = self.longest(&tokens[at..], languages) {
            return (length, Lex::Word(class, LANGUAGES[language].number_first));
        }
        let lex = match tokens[at].text.as_str() {
            "," | "，" => Lex::Comma,
            // `1・2号室`
            "・" if at > 0 && tokens[at - 1].kind == Kind::Digits => Lex::Word(Class::And, true),
            // `J. Novak`
            "." if is_initial(tokens, at) => Lex::Mark,
            "." | "。" | "!" | "?" | ";" | "；" | "！" | "？" => Lex::Stop,
            "-" | "/" => Lex::Dash,
            _ if tokens[at].kind == Kind::Mark => Lex::Mark,
            _ => Lex::Unknown,
        };
        (1, lex)
    }

    /// Unknown words beside a number that are a letter or two away from a word for a level, and such behind one that are a letter away from a number.
    fn mend_levels(&self, lexemes: &mut [Lexeme], tokens: &[Token], languages: Languages) {
        for at in 0..lexemes.len() {
            let is_number = |i: usize| matches!(lexemes.get(i).map(|l| &l.lex), Some(Lex::Number { .. }));
            let beside = is_number(at + 1) || (at > 0 && is_number(at - 1));
            let text = |at: usize| lexemes.get(at).map_or("", |l| tokens[l.tokens.start].text.as_str());
            let before_number = || {
                lexemes.get(at + 1).is_some_and(|l| l.lex == Lex::Unknown)
                    && misspelt_number(text(at + 1), languages).is_some()
            };
            // `entre 2 et 4 heures`
            let is_span = is_number(at + 1)
                && lexemes.get(at + 2).is_some_and(|lexeme| lexeme.is(Class::And))
                && matches!(lexemes.get(at + 3).map(|l| &l.lex), Some(Lex::Quantity));
            if lexemes[at].lex == Lex::Unknown && !is_span && (beside || before_number()) {
                let text = &tokens[lexemes[at].tokens.start].text;
                if let Some(class) = self.misspelt_level(text, languages) {
                    lexemes[at].lex = Lex::Word(class, false);
                }
            }
            let is_level = |lexeme: &Lexeme| lexeme.is(Class::Building) || lexeme.is(Class::Unit);
            if at > 0 && lexemes[at].lex == Lex::Unknown && is_level(&lexemes[at - 1]) {
                let text = &tokens[lexemes[at].tokens.start].text;
                if let Some(number) = misspelt_number(text, languages) {
                    lexemes[at].lex = Lex::Number { label: number.to_string(), ordinal: false };
                }
            }
        }
    }
}

/// Whether the point at a token makes an initial of the capital before it.
fn is_initial(tokens: &[Token], at: usize) -> bool {
    let letter = at.checked_sub(1).map(|before| &tokens[before]);
    let is_letter = letter.is_some_and(|letter| letter.capital && letter.text.chars().count() == 1);
    is_letter && tokens[at].glued && tokens.get(at + 1).is_some_and(|next| next.capital)
}

/// The number that a word was probably meant to be, if only one is that near: `sevn`.
fn misspelt_number(text: &str, languages: Languages) -> Option<u32> {
    if text.chars().count() < SHORTEST_MISSPELT {
        return None;
    }
    let active = (0..LANGUAGES.len()).filter(|i| languages & (1 << i) != 0);
    let cardinals = active.flat_map(|i| LANGUAGES[i].cardinals);
    let near = |word: &str| edit_distance(&super::text::condensed(word), text, 1) <= 1;
    let mut found = cardinals.filter(|(word, _)| near(word)).map(|(_, number)| *number);
    let number = found.next()?;
    found.all(|other| other == number).then_some(number)
}

/// `bâtiment un`: an article after a word for a level is the number one, unless a thing follows that it belongs to.
fn count_articles(lexemes: &mut [Lexeme], tokens: &[Token], languages: Languages) {
    let active = (0..LANGUAGES.len()).filter(|i| languages & (1 << i) != 0);
    let ones: Vec<&str> = active.flat_map(|i| LANGUAGES[i].ones).copied().collect();
    let is_item = |lexemes: &[Lexeme], at: usize| lexemes.get(at).is_some_and(|l| l.is(Class::Item));
    for at in 1..lexemes.len() {
        let is_one =
            ones.contains(&tokens[lexemes[at].tokens.start].text.as_str()) && lexemes[at].tokens.len() == 1;
        let is_beside = matches!(
            lexemes[at - 1].lex,
            Lex::Word(Class::Building | Class::Unit | Class::Room | Class::Sign, _)
        );
        // `unités trois et un`
        let is_listed = at > 2
            && (lexemes[at - 1].is(Class::And) || lexemes[at - 1].lex == Lex::Comma)
            && matches!(lexemes[at - 2].lex, Lex::Number { .. });
        if is_one && (is_beside || is_listed) && !is_item(lexemes, at + 1) {
            lexemes[at].lex = Lex::Number { label: "1".to_owned(), ordinal: false };
        }
    }
}

impl Entry {
    fn fits(&self, tokens: &[Token]) -> bool {
        let rest = &tokens[1..];
        rest.len() >= self.rest.len() && self.rest.iter().zip(rest).all(|(word, token)| *word == token.text)
    }
}

impl Meaning {
    fn names_a_level(self) -> bool {
        matches!(self, Self::Word(Class::Building | Class::Unit | Class::Room))
    }
}

/// Insertions, deletions, substitutions and swaps of neighbours from `a` to `b`; more than `limit` if it is more.
fn edit_distance(a: &str, b: &str, limit: usize) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > limit {
        return limit + 1;
    }
    let mut costs = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            costs[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let kept = costs[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                let swap = if swapped { costs[i - 2][j - 2] + 1 } else { usize::MAX };
                kept.min(swap).min(costs[i - 1][j] + 1).min(costs[i][j - 1] + 1)
            };
        }
    }
    costs[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lexes(text: &str) -> Vec<Lex> {
        let words = Words::new();
        let tokens = tokenize(text);
        let languages = words.languages(&tokens);
        words.lexemes(&tokens, &[], languages).into_iter().map(|l| l.lex).collect()
    }

    fn number(label: &str) -> Lex {
        Lex::Number { label: label.into(), ordinal: false }
    }

    #[test]
    fn the_longest_word_wins() {
        assert_eq!(lexes("3号楼"), [number("3"), Lex::Word(Class::Building, true)]);
        assert_eq!(lexes("instead of"), [Lex::Word(Class::Not, false)]);
    }

    #[test]
    fn a_word_that_two_languages_have_counts_in_the_language_of_the_text() {
        assert!(lexes("Lleva la caja al edificio once").contains(&number("11")));
        assert!(!lexes("Bring it at once to the building").contains(&number("11")));
    }

    #[test]
    fn words_for_levels_survive_typing_errors() {
        assert_eq!(lexes("buidling 3")[0], Lex::Word(Class::Building, false));
        assert_eq!(lexes("untit 3")[0], Lex::Word(Class::Unit, false));
        assert_eq!(lexes("sunday 3")[0], Lex::Unknown);
    }

    #[test]
    fn edits_are_counted_with_swaps() {
        for (a, b, edits) in
            [("building", "buidling", 1), ("unit", "unti", 1), ("kitten", "sitting", 3), ("", "ab", 2)]
        {
            assert_eq!(edit_distance(a, b, 9), edits, "{a} {b}");
        }
    }
}
