//! All units of a building, every second one, and how many there are.

use std::ops::Range;

use super::super::lexicon::Class;
use super::super::reading::Reading;
use super::super::words::Lex;
use super::{Level, Mention, Target};

/// So many words at most stand between a word for all and that for the level: `each of the four units`.
const MOST_BEFORE_ALL: usize = 4;

/// `all four units`, `each of the entrances`
pub(super) fn all_units(reading: &Reading<'_>, at: usize, level: Level, taken: usize) -> Option<Mention> {
    // `all units of insulin`
    let is_of_a_thing = reading.class(at + 1) == Some(Class::Link)
        && matches!(reading.lex(at + 2), Some(Lex::Unknown | Lex::Word(Class::Item, _)));
    if level == Level::Building || is_of_a_thing {
        return None;
    }
    let is_passed = |at: &usize| {
        matches!(
            reading.lex(*at),
            Some(Lex::Number { ordinal: false, .. } | Lex::Word(Class::Article | Class::Link, _))
        )
    };
    if let Some((parity, range)) = every_second(reading, at, taken) {
        let some = Target::All { but: Vec::new(), count: None, parity: Some(parity) };
        return Some(Mention { level, targets: vec![some], at: range, weak: false });
    }
    // `入口ぜんぶ`
    if matches!(reading.lex(at + 1), Some(Lex::Word(Class::All, true))) {
        return Some(all_of(level, at..at + 2, None));
    }
    let before = (taken..at).rev().take(MOST_BEFORE_ALL).find(|at| !is_passed(at));
    if let Some(before) = before
        && matches!(reading.class(before), Some(Class::All | Class::Each))
    {
        return Some(all_of(level, before..at + 1, None));
    }
    counted_units(reading, at, level, taken)
}

/// `the even units`, `les entrées paires`
fn every_second(reading: &Reading<'_>, at: usize, taken: usize) -> Option<(usize, Range<usize>)> {
    let parity = |at: usize| match reading.class(at)? {
        Class::Even => Some(0),
        Class::Odd => Some(1),
        _ => None,
    };
    // `偶数の号室`
    let is_linked = at > taken + 1 && reading.class(at - 1) == Some(Class::Link);
    let before = at.checked_sub(1 + usize::from(is_linked)).filter(|before| *before >= taken);
    let in_front = before.and_then(|before| Some((parity(before)?, before..at + 1)));
    in_front.or_else(|| Some((parity(at + 1)?, at..at + 2)))
}

/// `the four units`, `四个单元`
fn counted_units(reading: &Reading<'_>, at: usize, level: Level, taken: usize) -> Option<Mention> {
    let number = at.checked_sub(1).filter(|number| *number >= taken)?;
    let Some(Lex::Number { label, ordinal: false }) = reading.lex(number) else { return None };
    let is_definite = || {
        let article = number.checked_sub(1).filter(|article| *article >= taken);
        article.is_some_and(|article| reading.class(article) == Some(Class::Article)) && reading.is_plural(at)
    };
    if !is_counted(reading, at) && !is_definite() {
        return None;
    }
    Some(all_of(level, number..at + 1, Some(label.parse().ok()?)))
}

pub(super) fn all_of(level: Level, at: Range<usize>, count: Option<usize>) -> Mention {
    let all = Target::All { but: Vec::new(), count, parity: None };
    Mention { level, targets: vec![all], at, weak: false }
}

/// `四个单元`, `全四室`: so many units, but `第四个单元` is one.
pub(super) fn is_counted(reading: &Reading<'_>, at: usize) -> bool {
    let is_counter = reading.token(at).is_some_and(|token| token.text == "个");
    let is_number = |at: usize| matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }));
    let before = at.checked_sub(2).and_then(|at| reading.class(at));
    at > 0 && is_number(at - 1) && (before == Some(Class::All) || is_counter && before != Some(Class::Sign))
}

/// `一共有四个单元`, `12棟あります`: how many there are, not which.
pub(super) fn is_described(reading: &Reading<'_>, at: usize) -> bool {
    let text = |at: usize| reading.token(at).map_or("", |token| token.text.as_str());
    let is_number = |at: usize| matches!(reading.lex(at), Some(Lex::Number { ordinal: false, .. }));
    if at == 0 || !is_number(at - 1) {
        return false;
    }
    let is_told_behind = text(at + 1) == "あ" && text(at + 2) == "り";
    let is_counter = text(at) == "个" || matches!(reading.words(at..at + 1), "栋楼" | "幢楼" | "座楼");
    let is_told_before = at > 1 && matches!(text(at - 2), "有" | "共" | "每");
    is_told_behind || is_counter && is_told_before
}
