//! All units of a building, every second one, and how many there are.

use std::ops::Range;

use super::mention::{Level, Mention, Target};
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::languages::words_with;
use crate::lexicon::lexeme::Lex;

/// The most words between a word for all and that for the level: `each of the four units`.
const MOST_BEFORE_ALL: usize = 4;

/// `all four units`, `each of the entrances`
pub(super) fn all_units(
    reading: &Reading<'_>,
    at: usize,
    level: Level,
    taken: usize,
) -> Option<Mention> {
    // All buildings of a map are no destination.
    if level == Level::Building || is_of_a_thing(reading, at) {
        return None;
    }
    if let Some(half) = every_second(reading, at, taken) {
        let target = Target::All {
            but: Vec::new(),
            count: None,
            parity: Some(half.parity),
        };
        return Some(Mention::one(level, target, half.at));
    }
    // `入口ぜんぶ`
    if matches!(reading.lex(at + 1), Some(Lex::Word(Class::All, true))) {
        return Some(Mention::all(level, at..at + 2, None));
    }
    if let Some(all) = word_for_all(reading, at, taken) {
        return Some(Mention::all(level, all..at + 1, None));
    }
    counted_units(reading, at, level, taken)
}

/// `all units of insulin`
fn is_of_a_thing(reading: &Reading<'_>, at: usize) -> bool {
    reading.class(at + 1) == Some(Class::Link)
        && matches!(
            reading.lex(at + 2),
            Some(Lex::Unknown | Lex::Word(Class::Item, _))
        )
}

/// The word for all before a level, numbers and light words between them.
fn word_for_all(reading: &Reading<'_>, at: usize, taken: usize) -> Option<usize> {
    let is_passed = |at: &usize| {
        reading.is_cardinal(*at) || matches!(reading.class(*at), Some(Class::Article | Class::Link))
    };
    let before = (taken..at)
        .rev()
        .take(MOST_BEFORE_ALL)
        .find(|at| !is_passed(at))?;
    let is_all = matches!(reading.class(before), Some(Class::All | Class::Each));
    is_all.then_some(before)
}

/// Every second unit.
struct Half {
    /// The labels' remainder divided by two.
    parity: usize,
    at: Range<usize>,
}

/// `the even units`, `les entrées paires`
fn every_second(reading: &Reading<'_>, at: usize, taken: usize) -> Option<Half> {
    // `偶数の号室`
    let is_linked = at > taken + 1 && reading.class(at - 1) == Some(Class::Link);
    let before = at
        .checked_sub(1 + usize::from(is_linked))
        .filter(|before| *before >= taken);
    let half = |word: usize, at: Range<usize>| {
        Some(Half {
            parity: parity(reading, word)?,
            at,
        })
    };
    before
        .and_then(|before| half(before, before..at + 1))
        .or_else(|| half(at + 1, at..at + 2))
}

/// The remainder that the word at a place asks for.
fn parity(reading: &Reading<'_>, at: usize) -> Option<usize> {
    match reading.class(at)? {
        Class::Even => Some(0),
        Class::Odd => Some(1),
        _ => None,
    }
}

/// `the four units`, `四个单元`
fn counted_units(reading: &Reading<'_>, at: usize, level: Level, taken: usize) -> Option<Mention> {
    let number = at.checked_sub(1).filter(|number| *number >= taken)?;
    let Some(Lex::Number {
        label,
        ordinal: false,
    }) = reading.lex(number)
    else {
        return None;
    };
    let article = number.checked_sub(1).filter(|article| *article >= taken);
    let has_article = article.is_some_and(|article| reading.class(article) == Some(Class::Article));
    let is_definite = has_article && reading.is_plural(at);
    if !is_counted(reading, at) && !is_definite {
        return None;
    }
    Some(Mention::all(
        level,
        number..at + 1,
        Some(label.parse().ok()?),
    ))
}

/// `四个单元`, `全四室`: so many units, but `第四个单元` is one.
pub(super) fn is_counted(reading: &Reading<'_>, at: usize) -> bool {
    let before = at.checked_sub(2).and_then(|at| reading.class(at));
    let is_counter = reading.has(at, Feature::Counter) && before != Some(Class::Sign);
    at > 0 && reading.is_cardinal(at - 1) && (before == Some(Class::All) || is_counter)
}

/// `一共有四个单元`, `12棟あります`: how many there are, not which.
pub(super) fn is_described(reading: &Reading<'_>, at: usize) -> bool {
    if at == 0 || !reading.is_cardinal(at - 1) {
        return false;
    }
    let is_counter =
        reading.has(at, Feature::Counter) || is_written_as(reading, at, Feature::BuildingCounter);
    let is_said_before = at > 1 && reading.has(at - 2, Feature::ExistenceBefore);
    reading.spells(at + 1, Feature::ExistenceBehind) || is_counter && is_said_before
}

/// Whether a whole lexeme, as it was written, is a word with a feature.
fn is_written_as(reading: &Reading<'_>, at: usize, feature: Feature) -> bool {
    words_with(feature).any(|word| reading.words(at..at + 1) == word)
}
