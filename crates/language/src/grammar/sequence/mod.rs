//! Which stops must come before which, where the instruction says so: `first`, `then`, `before`,
//! `after`, `last`.
//!
//! The order in which stops are merely listed binds nothing.

pub(crate) mod orderings;
mod part;

use std::ops::Range;

use self::orderings::Ordering;
use self::part::Part;
use super::door::Door;
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::wish::Precedes;

/// The orders among `doors`.
///
/// What comes first wins where they contradict each other: what is said behind the last correction
/// comes before what is said at all.
pub(crate) fn constraints(
    rules: &[Ordering],
    reading: &Reading<'_>,
    doors: &[Door],
) -> Vec<Precedes> {
    let end = reading.lexemes.len();
    let correction = (0..end)
        .rev()
        .find(|at| matches!(reading.class(*at), Some(Class::Correct | Class::Swap)));
    let swap = (0..end)
        .rev()
        .find(|at| reading.class(*at) == Some(Class::Swap));
    let mut found = Vec::new();
    if let Some(correction) = correction {
        found.extend(within(rules, reading, doors, correction..end));
    }
    // `the other way round` turns what was said before it.
    if let Some(swap) = swap {
        let before = within(rules, reading, doors, 0..swap);
        found.extend(before.into_iter().map(Precedes::turned));
    }
    found.extend(within(rules, reading, doors, 0..end));
    found
}

/// What the words in a part of the instruction say of the doors that are named in it.
fn within(
    rules: &[Ordering],
    reading: &Reading<'_>,
    doors: &[Door],
    lexemes: Range<usize>,
) -> Vec<Precedes> {
    let mut part = Part {
        reading,
        doors,
        is_staged: false,
    };
    let mut found = stages(&part, &lexemes);
    // Before the rules: in `first A, then B and C` the stages already hold what `first` says.
    part.is_staged = !found.is_empty();
    for at in lexemes.clone() {
        for rule in rules {
            found.extend((rule.apply)(&part, at));
        }
    }
    if lexemes
        .clone()
        .any(|at| reading.class(at) == Some(Class::InOrder))
    {
        found.extend(as_named(doors, &lexemes));
    }
    found
}

/// `in this order`: the doors of a part, one after the other.
fn as_named(doors: &[Door], lexemes: &Range<usize>) -> Vec<Precedes> {
    let here: Vec<usize> = (0..doors.len())
        .filter(|i| lexemes.contains(&doors[*i].first))
        .collect();
    here.windows(2)
        .map(|pair| Precedes {
            earlier: pair[0],
            later: pair[1],
        })
        .collect()
}

/// Each `then` between two doors of a part puts all doors before it before all doors behind it.
fn stages(part: &Part<'_>, lexemes: &Range<usize>) -> Vec<Precedes> {
    let doors = part.doors;
    let is_inside = |i: &usize| lexemes.start <= doors[*i].first && doors[*i].last <= lexemes.end;
    let first = (0..doors.len()).find(is_inside).unwrap_or(doors.len());
    let end = (first..doors.len())
        .find(|i| !is_inside(i))
        .unwrap_or(doors.len());
    let mut stage = vec![0; doors.len()];
    for i in first + 1..end {
        // The lexemes of two doors may overlap: units of one building share its words.
        let mut between = doors[i - 1].last.min(doors[i].first)..doors[i].first;
        let is_parted = between.any(|at| is_then(part.reading, at) && !part.is_behind(at));
        stage[i] = stage[i - 1] + usize::from(is_parted);
    }
    let mut found = Vec::new();
    for later in first..end {
        // Doors of one stage stay free among themselves, for the shortest order.
        let before = (first..later).filter(|earlier| stage[*earlier] < stage[later]);
        found.extend(before.map(|earlier| Precedes { earlier, later }));
    }
    found
}

/// `then`, and `之后` where it begins a clause.
fn is_then(reading: &Reading<'_>, at: usize) -> bool {
    let begins = at > 0 && matches!(reading.lex(at - 1), Some(Lex::Comma | Lex::Stop));
    match reading.lex(at) {
        Some(Lex::Word(Class::Then | Class::Finally, _)) => true,
        Some(Lex::Word(Class::After, is_postfix)) => *is_postfix && begins,
        _ => false,
    }
}
