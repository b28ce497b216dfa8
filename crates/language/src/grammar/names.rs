//! Finds the map's own names in an instruction, typing errors included.
//!
//! Approximate matching after Sellers (1980), with swaps of neighbours, over text without spaces and marks; a match begins and
//! ends where words do. Digits must be right: `Hall 12` is not a misspelt `Hall 11`. Names shorter than five letters must be
//! exact. Where matches overlap, the one that explains most letters wins.

use std::ops::Range;

use super::text::{Kind, Token};
use crate::gazetteer::{Alias, Gazetteer};

/// A name that stands in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Found {
    /// Which tokens it takes.
    pub tokens: Range<usize>,
    /// The places that it may be: indices into [`Gazetteer::places`].
    pub places: Vec<usize>,
    /// How many letters are wrong.
    pub edits: usize,
    /// How many the name has.
    pub letters: usize,
}

impl Found {
    /// How many of a hundred letters are right.
    pub(crate) fn percent(&self) -> u8 {
        let right = self.letters.saturating_sub(self.edits);
        (100 * right).checked_div(self.letters).map_or(0, |percent| percent.min(100) as u8)
    }
}

/// So many places that share a part of their names are enough to ask which is meant.
const MOST_SHARERS: usize = 16;
/// An edit that is never allowed.
const NEVER: usize = 100;

/// The text as one run of letters.
struct Letters {
    chars: Vec<char>,
    /// The token of each letter.
    tokens: Vec<usize>,
    /// Whether a name may begin at each letter.
    begins: Vec<bool>,
    pairs: PairSet,
}

/// The map's names in `tokens`, in the order of the text, none overlapping. `known` says which tokens are ordinary words: a match
/// of nothing but those is no name unless the spelling is exact and has more than one word.
pub(crate) fn find(tokens: &[Token], gazetteer: &Gazetteer, known: &[bool]) -> Vec<Found> {
    let letters = Letters::new(tokens);
    let mut matches: Vec<(usize, Found)> = Vec::new();
    for alias in &gazetteer.aliases {
        for (range, edits) in letters.matches(alias) {
            let ordinary = known[range.clone()].iter().all(|k| *k);
            // No slip of the pen is a comma: `Medical Centre, …` is no misspelt `Medical Centre West`.
            // Nor is it another word: `Ärztehaus und` is no misspelt `Ärztehaus Süd`.
            let is_other_word =
                |at: usize| known[at] && tokens[at].kind == Kind::Letters && !alias.holds(&tokens[at].text);
            let is_broken =
                edits > 0 && (stretched(&tokens[range.clone()]).0 > 0 || range.clone().any(is_other_word));
            if is_broken || ordinary && (edits > 0 || range.len() == 1) {
                continue;
            }
            let explained = alias.letters.len().saturating_sub(3 * edits);
            let places =
                if edits == 0 { vec![alias.place] } else { sharers(tokens, &range, alias, gazetteer) };
            let letters = alias.letters.len();
            matches.push((explained, Found { tokens: range, places, edits, letters }));
        }
    }
    matches.sort_by_key(|(explained, found)| {
        let stretched = stretched(&tokens[found.tokens.clone()]);
        (std::cmp::Reverse(*explained), found.edits, stretched, found.tokens.start, found.places[0])
    });
    choose(matches)
}

/// The places that a misspelt name may be: where it is but a part of the name, all those whose names have that part. `Medical Centre` is no
/// misspelt `Medical Centre East` where there is a `Medical Centre West`, though the latter has more letters.
fn sharers(tokens: &[Token], range: &Range<usize>, alias: &Alias, gazetteer: &Gazetteer) -> Vec<usize> {
    let said: Vec<char> =
        tokens[range.clone()].iter().filter(|t| t.kind != Kind::Mark).flat_map(|t| t.text.chars()).collect();
    let has_part = |name: &[char]| name.starts_with(&said) || name.ends_with(&said);
    if !has_part(&alias.letters) {
        return vec![alias.place];
    }
    let sharing = gazetteer.aliases.iter().filter(|other| has_part(&other.letters)).map(|other| other.place);
    let mut places = vec![alias.place];
    places.extend(sharing.take(MOST_SHARERS));
    places.sort_unstable();
    places.dedup();
    places
}

/// How little a name looks like one: the commas and the like that it runs across, and whether it begins with its number. In
/// `unit 1, Elm Street 4` both `1, Elm Street` and `Elm Street 4` may be on the map.
fn stretched(tokens: &[Token]) -> (usize, bool) {
    let divides =
        |t: &&Token| t.kind == Kind::Mark && matches!(&*t.text, "," | ";" | ":" | "." | "、" | "。");
    (tokens.iter().filter(divides).count(), tokens.first().is_some_and(|t| t.kind == Kind::Digits))
}

fn choose(matches: Vec<(usize, Found)>) -> Vec<Found> {
    let mut chosen: Vec<(usize, Found)> = Vec::new();
    for (explained, found) in matches {
        let overlaps = |c: &Found| c.tokens.start < found.tokens.end && found.tokens.start < c.tokens.end;
        match chosen.iter_mut().find(|(_, c)| overlaps(c)) {
            None => chosen.push((explained, found)),
            Some((best, rival)) => {
                let equal = *best == explained && rival.tokens == found.tokens && rival.edits == found.edits;
                if equal && !rival.places.contains(&found.places[0]) {
                    rival.places.push(found.places[0]);
                }
            }
        }
    }
    let mut found: Vec<Found> = chosen.into_iter().map(|(_, found)| found).collect();
    found.sort_by_key(|f| f.tokens.start);
    found
}

impl Letters {
    fn new(tokens: &[Token]) -> Self {
        let mut letters =
            Self { chars: Vec::new(), tokens: Vec::new(), begins: Vec::new(), pairs: PairSet::default() };
        for (index, token) in tokens.iter().enumerate().filter(|(_, t)| t.kind != Kind::Mark) {
            for (i, c) in token.text.chars().enumerate() {
                letters.chars.push(c);
                letters.tokens.push(index);
                letters.begins.push(i == 0 && !splits_a_word(tokens, index));
            }
        }
        letters.pairs = PairSet::new(&letters.chars);
        letters
    }

    /// Where `alias` stands: ranges of tokens and how many letters are wrong.
    fn matches(&self, alias: &Alias) -> Vec<(Range<usize>, usize)> {
        let limit = allowed_edits(alias.letters.len());
        let n = alias.letters.len();
        if n == 0 || n > self.chars.len() + limit || !self.pairs.may_hold(&alias.letters, limit) {
            return Vec::new();
        }
        let mut ends = self.ends(&alias.letters, limit);
        // Of matches that share a beginning the best.
        ends.sort_by_key(|(range, edits)| (range.start, *edits, range.end));
        ends.dedup_by_key(|(range, _)| range.start);
        ends
    }

    fn ends(&self, name: &[char], limit: usize) -> Vec<(Range<usize>, usize)> {
        let (n, mut found) = (name.len(), Vec::new());
        // Each cell: wrong letters so far, and where the match began.
        let first: Vec<(usize, usize)> =
            (0..=n).map(|i| (if i == 0 { NEVER } else { NEVER + i }, 0)).collect();
        let (mut older, mut old) = (first.clone(), first);
        for j in 0..self.chars.len() {
            if self.begins[j] {
                old[0] = (0, j);
                for i in 1..=n {
                    old[i] = old[i].min((old[i - 1].0 + gap(name[i - 1]), old[i - 1].1));
                }
            }
            let mut row = vec![(NEVER, 0); n + 1];
            for i in 1..=n {
                let kept = (old[i - 1].0 + exchange(name[i - 1], self.chars[j]), old[i - 1].1);
                let dropped = (old[i].0 + gap(self.chars[j]), old[i].1);
                let missed = (row[i - 1].0 + gap(name[i - 1]), row[i - 1].1);
                row[i] = kept.min(dropped).min(missed);
                let swapped =
                    i > 1 && j > 0 && name[i - 1] == self.chars[j - 1] && name[i - 2] == self.chars[j];
                if swapped && gap(name[i - 1]) + gap(name[i - 2]) == 2 {
                    row[i] = row[i].min((older[i - 2].0 + 1, older[i - 2].1));
                }
            }
            let ends_here = self.tokens.get(j + 1) != Some(&self.tokens[j]);
            if ends_here && row[n].0 <= limit {
                found.push((self.tokens[row[n].1]..self.tokens[j] + 1, row[n].0));
            }
            older = std::mem::replace(&mut old, row);
        }
        found
    }
}

/// Whether a token is the number behind letters that it is glued to: `unit1`.
fn splits_a_word(tokens: &[Token], index: usize) -> bool {
    let glued = tokens[index].glued && tokens[index].kind == Kind::Digits;
    glued && index > 0 && tokens[index - 1].kind == Kind::Letters
}

fn allowed_edits(letters: usize) -> usize {
    match letters {
        0..=4 => 0,
        5..=9 => 1,
        10..=15 => 2,
        _ => 3,
    }
}

fn gap(c: char) -> usize {
    if c.is_ascii_digit() { NEVER } else { 1 }
}

fn exchange(a: char, b: char) -> usize {
    match (a == b, a.is_ascii_digit() || b.is_ascii_digit()) {
        (true, _) => 0,
        (false, true) => NEVER,
        (false, false) => 1,
    }
}

/// Which pairs of neighbours a text has, hashed: rules most names out at once.
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

    /// Whether enough pairs of `name` are there for at most `limit` edits, each of which spoils at most three pairs.
    fn may_hold(&self, name: &[char], limit: usize) -> bool {
        let there = |pair: &&[char]| {
            let bit = hash(pair);
            self.0[bit / 64] & (1 << (bit % 64)) != 0
        };
        name.windows(2).filter(there).count() + 3 * limit >= name.len().saturating_sub(1)
    }
}

fn hash(pair: &[char]) -> usize {
    let mixed = u32::from(pair[0]).wrapping_mul(0x9E37_79B1) ^ u32::from(pair[1]).wrapping_mul(0x85EB_CA6B);
    (mixed >> 20) as usize
}

#[cfg(test)]
mod tests {
    use super::super::text::{condensed, tokenize};
    use super::*;

    fn found(text: &str, names: &[&str]) -> Vec<(Vec<usize>, usize)> {
        let alias =
            |(place, name): (usize, &&str)| Alias { letters: condensed(name).chars().collect(), place };
        let mut gazetteer = Gazetteer::default();
        gazetteer.aliases = names.iter().enumerate().map(alias).collect();
        let tokens = tokenize(text);
        let known = vec![false; tokens.len()];
        find(&tokens, &gazetteer, &known).into_iter().map(|f| (f.places, f.edits)).collect()
    }

    const NAMES: [&str; 5] = ["Paldal Hall", "Casino de Monte-Carlo", "Casino", "팔달관", "West Hall"];

    #[test]
    fn names_are_found_whatever_their_spelling() {
        assert_eq!(found("to paldal  HALL please", &NAMES), [(vec![0], 0)]);
        assert_eq!(found("to Padlal Hall", &NAMES), [(vec![0], 1)]);
        assert_eq!(found("the Cassino de Monte Carlo", &NAMES), [(vec![1], 1)]);
        assert_eq!(found("팔달관으로", &NAMES), [(vec![3], 0)]);
    }

    #[test]
    fn the_name_that_explains_most_wins() {
        assert_eq!(found("Casino de Monte-Carlo, then the Casino", &NAMES), [(vec![1], 0), (vec![2], 0)]);
        assert_eq!(found("Hall 12", &["Hall 11", "Hall 1"]), []);
        assert_eq!(found("East Hall", &NAMES), []);
    }

    #[test]
    fn a_name_that_two_buildings_bear_is_both() {
        assert_eq!(found("the Gym", &["Gym", "GYM"]), [(vec![0, 1], 0)]);
    }

    #[test]
    fn a_number_before_a_street_is_its_own_only_if_nothing_else_claims_it() {
        let street = ["Elm Street 4", "4 Elm Street", "Elm Street 1", "1 Elm Street"];
        let place = |text: &str| found(text, &street).iter().map(|(p, _)| p[0]).collect::<Vec<_>>();
        for text in
            ["unit1, Elm Street 4", "unit 1, Elm Street 4.", "unit 1 Elm Street 4", "Elm Street 4, unit 1"]
        {
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
