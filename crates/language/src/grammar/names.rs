//! Finds the map's own names in an instruction, typing errors included.
//!
//! Approximate matching after Sellers (1980), with swaps of neighbours, over text without spaces
//! and marks. A match begins and ends where words do. Digits must be right: `Hall 12` is not a
//! misspelt `Hall 11`. Names shorter than five letters must be exact. Where matches overlap, the
//! one that explains most letters wins.

use std::cmp::Reverse;
use std::ops::Range;

use crate::gazetteer::{Alias, Gazetteer};
use crate::lexicon::marks;
use crate::lexicon::tokens::{Kind, Token};

/// A name that stands in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Found {
    /// The tokens that it takes.
    pub tokens: Range<usize>,
    /// The places that it may be: indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
    /// How many letters are wrong.
    pub edits: usize,
    /// How many letters the name has.
    pub letters: usize,
}

impl Found {
    /// The percentage of its letters that are right.
    pub(crate) fn percent(&self) -> u8 {
        let right = self.letters.saturating_sub(self.edits);
        (100 * right)
            .checked_div(self.letters)
            .map_or(0, |percent| percent.min(100) as u8)
    }

    fn overlaps(&self, other: &Self) -> bool {
        other.tokens.start < self.tokens.end && self.tokens.start < other.tokens.end
    }

    /// How many letters it explains: each wrong letter costs three, so that a letter or two more do
    /// not pay for a typing error.
    fn explained(&self) -> usize {
        self.letters.saturating_sub(3 * self.edits)
    }
}

/// The most places that share a part of their names; more are not needed to ask which is meant.
const MOST_SHARERS: usize = 16;
/// The cost of an edit that is never allowed: more than any limit, and small enough to add up.
const NEVER: usize = 100;

/// The map's names in `tokens`, in the order of the text, none overlapping.
///
/// `known` says which tokens are ordinary words. A match of nothing but those is no name unless the
/// spelling is exact and has more than one word.
pub(crate) fn find(tokens: &[Token], gazetteer: &Gazetteer, known: &[bool]) -> Vec<Found> {
    let letters = Letters::new(tokens);
    let mut matches: Vec<Found> = Vec::new();
    for alias in &gazetteer.aliases {
        for Match {
            tokens: range,
            edits,
        } in letters.matches(alias)
        {
            if !is_name(tokens, known, &range, edits, alias) {
                continue;
            }
            // A name that stands there exactly is meant, however many names contain it.
            let places = if edits == 0 {
                vec![alias.place]
            } else {
                sharers(tokens, &range, alias, gazetteer)
            };
            let letters = alias.letters.len();
            matches.push(Found {
                tokens: range,
                places,
                edits,
                letters,
            });
        }
    }
    // The best first, for `choose`. The last two keys only make the order total, so that equal maps
    // give equal results.
    matches.sort_by_key(|found| {
        let stretch = Stretch::of(&tokens[found.tokens.clone()]);
        let explained = Reverse(found.explained());
        (
            explained,
            found.edits,
            stretch,
            found.tokens.start,
            found.places[0],
        )
    });
    choose(matches)
}

/// Whether a match can be a name and not only ordinary words or a list.
fn is_name(
    tokens: &[Token],
    known: &[bool],
    range: &Range<usize>,
    edits: usize,
    alias: &Alias,
) -> bool {
    let is_ordinary = known[range.clone()].iter().all(|known| *known);
    if edits == 0 {
        return !is_ordinary || range.len() > 1;
    }
    // A comma is no typing error: `Medical Centre, …` is no misspelt `Medical Centre West`.
    let has_divider = Stretch::of(&tokens[range.clone()]).dividers > 0;
    // Nor is another word: `Ärztehaus und` is no misspelt `Ärztehaus Süd`.
    let has_other_word = range
        .clone()
        .any(|at| known[at] && tokens[at].kind == Kind::Letters && !alias.holds(&tokens[at].text));
    !is_ordinary && !has_divider && !has_other_word
}

/// The tokens of each name.
pub(crate) fn ranges(names: &[Found]) -> Vec<Range<usize>> {
    names.iter().map(|name| name.tokens.clone()).collect()
}

/// The places that a misspelt name may be: if it is only a part of the name, all those whose names
/// have that part. `Medical Centre` is no misspelt `Medical Centre East` where there is a `Medical
/// Centre West`, though the latter has more letters.
fn sharers(
    tokens: &[Token],
    range: &Range<usize>,
    alias: &Alias,
    gazetteer: &Gazetteer,
) -> Vec<usize> {
    let words = tokens[range.clone()]
        .iter()
        .filter(|token| token.kind != Kind::Mark);
    let said: Vec<char> = words.flat_map(|token| token.text.chars()).collect();
    if !has_part(alias, &said) {
        return vec![alias.place];
    }
    let sharing = gazetteer
        .aliases
        .iter()
        .filter(|other| has_part(other, &said));
    let mut places = vec![alias.place];
    places.extend(sharing.map(|other| other.place).take(MOST_SHARERS));
    places.sort_unstable();
    places.dedup();
    places
}

/// Whether a name begins or ends with these letters.
fn has_part(alias: &Alias, said: &[char]) -> bool {
    alias.letters.starts_with(said) || alias.letters.ends_with(said)
}

/// How little a match looks like a name. In `unit 1, Elm Street 4` both `1, Elm Street` and `Elm
/// Street 4` may be on the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Stretch {
    /// Commas and the like that it runs across.
    dividers: usize,
    begins_with_number: bool,
}

impl Stretch {
    fn of(tokens: &[Token]) -> Self {
        let dividers = tokens
            .iter()
            .filter(|token| token.kind == Kind::Mark && marks::is_divider(&token.text));
        Self {
            dividers: dividers.count(),
            begins_with_number: tokens
                .first()
                .is_some_and(|token| token.kind == Kind::Digits),
        }
    }
}

/// Of overlapping matches the first; equally good ones of the same words become one.
fn choose(matches: Vec<Found>) -> Vec<Found> {
    let mut chosen: Vec<Found> = Vec::new();
    for found in matches {
        // The best come first, so what overlaps a chosen match is worse or as good.
        match chosen.iter_mut().find(|other| other.overlaps(&found)) {
            None => chosen.push(found),
            Some(rival) => {
                let is_equal = rival.explained() == found.explained()
                    && rival.tokens == found.tokens
                    && rival.edits == found.edits;
                if is_equal && !rival.places.contains(&found.places[0]) {
                    rival.places.push(found.places[0]);
                }
            }
        }
    }
    chosen.sort_by_key(|found| found.tokens.start);
    chosen
}

/// Where a name stands.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Match {
    tokens: Range<usize>,
    /// How many letters are wrong.
    edits: usize,
}

/// A cell of the matching: how many letters are wrong so far, and the letter of the text at which
/// the match began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    edits: usize,
    begin: usize,
}

impl Cell {
    /// The match with more edits.
    fn plus(self, edits: usize) -> Self {
        Self {
            edits: self.edits + edits,
            ..self
        }
    }
}

/// The text as one run of letters.
struct Letters {
    chars: Vec<char>,
    /// The token of each letter.
    tokens: Vec<usize>,
    /// Whether a name may begin at each letter.
    begins: Vec<bool>,
    pairs: PairSet,
}

impl Letters {
    fn new(tokens: &[Token]) -> Self {
        let mut letters = Self {
            chars: Vec::new(),
            tokens: Vec::new(),
            begins: Vec::new(),
            pairs: PairSet::default(),
        };
        for (index, token) in tokens
            .iter()
            .enumerate()
            // Names are compared without spaces and marks, so both are left out; `tokens` leads
            // back.
            .filter(|(_, t)| t.kind != Kind::Mark)
        {
            for (i, c) in token.text.chars().enumerate() {
                letters.chars.push(c);
                letters.tokens.push(index);
                letters.begins.push(i == 0 && !splits_a_word(tokens, index));
            }
        }
        letters.pairs = PairSet::new(&letters.chars);
        letters
    }

    /// Where `alias` stands. Of matches that share a beginning only the best.
    fn matches(&self, alias: &Alias) -> Vec<Match> {
        let count = alias.letters.len();
        let limit = allowed_edits(count);
        // Cheap tests first: most names of a map stand nowhere in an instruction.
        let is_too_long = count > self.chars.len() + limit;
        if count == 0 || is_too_long || !self.pairs.may_hold(&alias.letters, limit) {
            return Vec::new();
        }
        let mut ends = self.ends(&alias.letters, limit);
        ends.sort_by_key(|found| (found.tokens.start, found.edits, found.tokens.end));
        ends.dedup_by_key(|found| found.tokens.start);
        ends
    }

    /// A match for each end of a word up to which at most `limit` letters are wrong.
    fn ends(&self, name: &[char], limit: usize) -> Vec<Match> {
        let n = name.len();
        // No match has begun: as if all letters were missing, at a cost that is never allowed.
        let mut older: Vec<Cell> = (0..=n)
            .map(|i| Cell {
                edits: NEVER + i,
                begin: 0,
            })
            .collect();
        let mut old = older.clone();
        let mut found = Vec::new();
        for j in 0..self.chars.len() {
            // Sellers lets a match begin at any letter, with a zero in row 0. Here only letters
            // that begin a word have it.
            if self.begins[j] {
                begin(&mut old, name, j);
            }
            let row = self.row(name, j, &older, &old);
            // Only where a word ends.
            let ends_here = self.tokens.get(j + 1) != Some(&self.tokens[j]);
            // The last cell is the whole name. Its `begin` was carried along the cheapest path, so
            // no path is traced back.
            let end = row[n];
            if ends_here && end.edits <= limit {
                let tokens = self.tokens[end.begin]..self.tokens[j] + 1;
                found.push(Match {
                    tokens,
                    edits: end.edits,
                });
            }
            // Three rows suffice: a swap of neighbours looks back by two letters.
            older = std::mem::replace(&mut old, row);
        }
        found
    }

    /// The cells of letter `j` of the text, given those of the two letters before it.
    fn row(&self, name: &[char], j: usize, older: &[Cell], old: &[Cell]) -> Vec<Cell> {
        let mut row = vec![
            Cell {
                edits: NEVER,
                begin: 0
            };
            name.len() + 1
        ];
        for i in 1..=name.len() {
            // Cells compare by edits, then by their beginning, so of equal costs the longest match
            // wins.
            let kept = old[i - 1].plus(exchange(name[i - 1], self.chars[j]));
            let dropped = old[i].plus(gap(self.chars[j]));
            let missed = row[i - 1].plus(gap(name[i - 1]));
            row[i] = kept.min(dropped).min(missed);
            let is_swapped =
                i > 1 && j > 0 && name[i - 1] == self.chars[j - 1] && name[i - 2] == self.chars[j];
            // A gap costs 1 for a letter, so a sum of 2 says that neither is a digit.
            if is_swapped && gap(name[i - 1]) + gap(name[i - 2]) == 2 {
                row[i] = row[i].min(older[i - 2].plus(1));
            }
        }
        row
    }
}

/// Lets a match begin at letter `j` of the text, the first letters of the name missing or not.
fn begin(row: &mut [Cell], name: &[char], j: usize) {
    row[0] = Cell { edits: 0, begin: j };
    // A match that begins here may lack the first letters of the name. Where an earlier beginning
    // is as cheap, it stays.
    for i in 1..=name.len() {
        row[i] = row[i].min(row[i - 1].plus(gap(name[i - 1])));
    }
}

/// Whether a token is the number behind letters that it is glued to: `unit1`.
fn splits_a_word(tokens: &[Token], index: usize) -> bool {
    let is_glued = tokens[index].glued && tokens[index].kind == Kind::Digits;
    is_glued && index > 0 && tokens[index - 1].kind == Kind::Letters
}

/// How many letters of a name may be wrong: at most one in five. A short word becomes another one
/// by a single letter.
fn allowed_edits(letters: usize) -> usize {
    match letters {
        0..=4 => 0,
        5..=9 => 1,
        10..=15 => 2,
        _ => 3,
    }
}

/// The cost of a letter that is missing or too many.
fn gap(c: char) -> usize {
    if c.is_ascii_digit() { NEVER } else { 1 }
}

/// The cost of a letter in place of another one.
fn exchange(a: char, b: char) -> usize {
    let has_digit = a.is_ascii_digit() || b.is_ascii_digit();
    match (a == b, has_digit) {
        (true, _) => 0,
        (false, true) => NEVER,
        (false, false) => 1,
    }
}

/// The pairs of neighbouring letters of a text, hashed: rules most names out at once.
struct PairSet([u64; 64]);

impl Default for PairSet {
    fn default() -> Self {
        Self([0; 64])
    }
}

impl PairSet {
    fn new(chars: &[char]) -> Self {
        let mut set = Self::default();
        for pair in chars.windows(2) {
            let bit = hash(pair);
            set.0[bit / 64] |= 1 << (bit % 64);
        }
        set
    }

    fn contains(&self, pair: &[char]) -> bool {
        let bit = hash(pair);
        self.0[bit / 64] & (1 << (bit % 64)) != 0
    }

    /// Whether enough pairs of `name` are there for at most `limit` edits, each of which spoils at
    /// most three pairs.
    fn may_hold(&self, name: &[char], limit: usize) -> bool {
        let there = name.windows(2).filter(|pair| self.contains(pair)).count();
        // A swap of neighbours touches the pair itself and one on each side. A hash that collides
        // only lets a name through to the exact test.
        there + 3 * limit >= name.len().saturating_sub(1)
    }
}

fn hash(pair: &[char]) -> usize {
    // Multiplication by large odd numbers spreads neighbouring letters over the high bits.
    let first = u32::from(pair[0]).wrapping_mul(0x9E37_79B1);
    let second = u32::from(pair[1]).wrapping_mul(0x85EB_CA6B);
    // The 12 highest bits: an index into 64 words of 64 bits.
    ((first ^ second) >> 20) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lexicon::tokens::{condensed, tokenize};

    fn found(text: &str, names: &[&str]) -> Vec<(Vec<usize>, usize)> {
        let alias = |(place, name): (usize, &&str)| Alias {
            letters: condensed(name).chars().collect(),
            place,
        };
        let mut gazetteer = Gazetteer::default();
        gazetteer.aliases = names.iter().enumerate().map(alias).collect();
        let tokens = tokenize(text);
        let known = vec![false; tokens.len()];
        find(&tokens, &gazetteer, &known)
            .into_iter()
            .map(|f| (f.places, f.edits))
            .collect()
    }

    const NAMES: [&str; 5] = [
        "Paldal Hall",
        "Casino de Monte-Carlo",
        "Casino",
        "팔달관",
        "West Hall",
    ];

    #[test]
    fn names_are_found_whatever_their_spelling() {
        assert_eq!(found("to paldal  HALL please", &NAMES), [(vec![0], 0)]);
        assert_eq!(found("to Padlal Hall", &NAMES), [(vec![0], 1)]);
        assert_eq!(found("the Cassino de Monte Carlo", &NAMES), [(vec![1], 1)]);
        assert_eq!(found("팔달관으로", &NAMES), [(vec![3], 0)]);
    }

    #[test]
    fn the_name_that_explains_most_wins() {
        assert_eq!(
            found("Casino de Monte-Carlo, then the Casino", &NAMES),
            [(vec![1], 0), (vec![2], 0)]
        );
        assert_eq!(found("Hall 12", &["Hall 11", "Hall 1"]), []);
        assert_eq!(found("East Hall", &NAMES), []);
    }

    #[test]
    fn a_name_of_two_buildings_gives_both_places() {
        assert_eq!(found("the Gym", &["Gym", "GYM"]), [(vec![0, 1], 0)]);
    }

    #[test]
    fn a_number_before_a_street_belongs_to_it_unless_a_unit_precedes() {
        let street = [
            "Elm Street 4",
            "4 Elm Street",
            "Elm Street 1",
            "1 Elm Street",
        ];
        let place = |text: &str| {
            found(text, &street)
                .iter()
                .map(|(p, _)| p[0])
                .collect::<Vec<_>>()
        };
        for text in [
            "unit1, Elm Street 4",
            "unit 1, Elm Street 4.",
            "unit 1 Elm Street 4",
            "Elm Street 4, unit 1",
        ] {
            assert_eq!(place(text), [0], "{text}");
        }
        assert_eq!(place("to 1 Elm Street, 4 boxes"), [3]);
        assert_eq!(place("4 Elm Street, then 1 Elm Street"), [1, 3]);
        assert_eq!(place("unit1 Elm Street"), Vec::<usize>::new());
    }

    #[test]
    fn names_begin_and_end_where_words_do() {
        assert_eq!(found("the gymnasium", &["Gym"]), []);
        assert_eq!(found("a subgym", &["gym"]), []);
    }
}
