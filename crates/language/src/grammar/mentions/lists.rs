//! Numbers beside a word for a level: lists and ranges of them, before it and behind it.

use super::super::lexicon::Class;
use super::super::reading::Reading;
use super::super::words::Lex;
use super::{Level, Mention, Target};

/// No list or range names more places than this.
const LONGEST_LIST: usize = 50;

/// The numbers after a level and where they end: `building no. 3`, `units 1, 2 and 4`, `units 1 to 3`.
pub(super) fn numbers_after(reading: &Reading<'_>, level: usize) -> Option<(Vec<String>, usize)> {
    let mut at = level + 1;
    // `the unit is number 2`, `la unidad es la 2`
    if reading.class(at) == Some(Class::Verb)
        && matches!(reading.class(at + 1), Some(Class::Sign | Class::Article))
    {
        let is_label = reading.label(at + 2).is_some()
            && matches!(reading.lex(at + 3), None | Some(Lex::Stop | Lex::Comma | Lex::Word(Class::And, _)));
        at += if is_label { 2 } else { 1 };
    }
    let plural = reading.is_plural(level);
    // `unidades de la 2 a la 4`
    let is_passed =
        |class: Class| class == Class::Sign || plural && matches!(class, Class::Link | Class::Article);
    // `入口は3番`
    let is_own =
        |at: usize| reading.label(at).is_some() && reading.class(at + 1).and_then(super::level).is_none();
    if matches!(reading.lex(at), Some(Lex::Word(Class::Toward, true))) && is_own(at + 1) {
        at += 1;
    }
    while reading.class(at).is_some_and(is_passed)
        || reading.lex(at) == Some(&Lex::Dash)
        || is_colon(reading, at)
    {
        at += 1;
    }
    let first = reading.label(at)?.to_owned();
    if reading.is_ordinal(at) {
        return None;
    }
    let (mut numbers, mut end) = (vec![first], at + 1);
    if let Some((last, end)) = range_end(reading, end, plural) {
        return Some((span(&numbers[0], &last)?, end));
    }
    // Commas alone make a list only after a plural; else the list must close with `and`.
    let (mut pending, mut next) = (Vec::new(), end);
    while let Some((number, joined)) = list_separator(reading, next) {
        // `buildings 4 and 2 want milk`: after a plural what follows may be any word.
        let before_a_word = plural
            && reading.lex(number + 1) == Some(&Lex::Unknown)
            && matches!(reading.lex(number), Some(Lex::Number { ordinal: false, .. }));
        // `entrée 1 et 6 pour le bâtiment 11`
        let is_counted = joined && goes_to_a_building(reading, number + 1);
        // `Gebäude 1, 6 und 11 waren geplant`
        let is_or = reading
            .token(number.saturating_sub(1))
            .is_some_and(|token| matches!(token.text.as_str(), "o" | "u" | "ou" | "oder" | "or"));
        let ends_a_list =
            joined && !is_or && !pending.is_empty() && reading.lex(number + 1) == Some(&Lex::Unknown);
        // `unit 2 in building 5 and I will be happy`
        let is_pronoun = reading.token(number).is_some_and(|token| token.text == "i");
        let is_listed = !is_pronoun && (reading.continues_list(number) || before_a_word || ends_a_list);
        if !is_listed || is_counted || numbers.len() + pending.len() >= LONGEST_LIST {
            break;
        }
        pending.extend(reading.label(number).map(str::to_owned));
        next = number + 1;
        if joined || plural {
            numbers.append(&mut pending);
            end = next;
        }
    }
    Some((numbers, end))
}

/// `for building 11`
fn goes_to_a_building(reading: &Reading<'_>, at: usize) -> bool {
    let is_toward = matches!(reading.class(at), Some(Class::Toward | Class::TowardOrAfter));
    let article = usize::from(reading.class(at + 1) == Some(Class::Article));
    is_toward && matches!(reading.lex(at + 1 + article), Some(Lex::Name(_) | Lex::Word(Class::Building, _)))
}

fn is_colon(reading: &Reading<'_>, at: usize) -> bool {
    reading.lex(at) == Some(&Lex::Mark) && reading.token(at).is_some_and(|t| t.text == ":")
}

/// Past a comma, `and`, or both: where the next number should be, and whether there was an `and`.
fn list_separator(reading: &Reading<'_>, mut at: usize) -> Option<(usize, bool)> {
    let start = at;
    if reading.lex(at) == Some(&Lex::Comma) {
        at += 1;
    }
    let joined = reading.class(at) == Some(Class::And);
    at += usize::from(joined);
    // `la unidad 1 y la 4`, but `unité 2, et le 6, unité 4`
    let is_alone = reading.lex(start) != Some(&Lex::Comma);
    at += usize::from(joined && is_alone && reading.class(at) == Some(Class::Article));
    (at > start).then_some((at, joined))
}

/// The end of a range and where it stands: `units 1 to 3`, `Eingang 1 bis 3`.
fn range_end(reading: &Reading<'_>, at: usize, plural: bool) -> Option<(String, usize)> {
    let loose = reading.lex(at) == Some(&Lex::Dash) || reading.class(at) == Some(Class::Toward);
    // `入口1から4まで`
    let is_from_to =
        reading.class(at) == Some(Class::NotBefore) && reading.class(at + 2) == Some(Class::Toward);
    if let Some(label) = reading.label(at + 1).filter(|_| is_from_to) {
        return Some((label.to_owned(), at + 3));
    }
    let tied = reading.class(at) == Some(Class::Range) || plural && loose;
    let last = at + 1 + usize::from(reading.class(at + 1) == Some(Class::Article));
    let label = (tied && reading.continues_list(last)).then(|| reading.label(last)).flatten()?;
    Some((label.to_owned(), last + 1))
}

/// The numbers before a level and where they begin: `the first and second unit`, `No. 3 building`, `1、2单元`, `1到3单元`.
pub(super) fn numbers_before(
    reading: &Reading<'_>,
    level: usize,
    number_first: bool,
    taken: usize,
) -> Option<(Vec<String>, usize)> {
    let mut at = level.checked_sub(1).filter(|at| *at >= taken)?;
    if let Some(label) = reading.ordinal_determiner(at).filter(|_| number_first) {
        return Some((vec![label.to_string()], at));
    }
    if reading.lex(at) == Some(&Lex::Dash) && number_first {
        at = at.checked_sub(1)?;
    }
    let first = reading.label(at)?.to_owned();
    let signed = at > taken && reading.class(at - 1) == Some(Class::Sign);
    if !(number_first || signed || reading.is_ordinal(at)) {
        return None;
    }
    if number_first && let Some((numbers, start)) = range_before(reading, at, taken) {
        return Some((numbers, start));
    }
    let mut numbers = vec![first];
    let mut start = at - usize::from(signed);
    while let Some(number) = listed_before(reading, start, number_first, taken) {
        numbers.extend(reading.label(number).map(str::to_owned));
        start = number;
        if numbers.len() >= LONGEST_LIST {
            break;
        }
    }
    numbers.reverse();
    Some((numbers, start))
}

fn range_before(reading: &Reading<'_>, at: usize, taken: usize) -> Option<(Vec<String>, usize)> {
    let start = at.checked_sub(2).filter(|start| *start >= taken)?;
    let tied = reading.lex(at - 1) == Some(&Lex::Dash)
        || matches!(reading.class(at - 1), Some(Class::Range | Class::Toward));
    tied.then(|| span(reading.label(start)?, reading.label(at)?)).flatten().map(|numbers| (numbers, start))
}

/// The number that `…, ` or `… and ` puts before the one at `at` in a list.
fn listed_before(reading: &Reading<'_>, at: usize, number_first: bool, taken: usize) -> Option<usize> {
    let mut i = at.checked_sub(1)?;
    if reading.class(i) == Some(Class::Article) {
        i = i.checked_sub(1)?;
    }
    // `一番と四番の入口`
    let joined = reading.class(i) == Some(Class::And);
    if joined && number_first && i > 0 && reading.class(i - 1) == Some(Class::Sign) {
        i -= 1;
    }
    if !joined && (number_first || reading.lex(i) != Some(&Lex::Comma)) {
        return None;
    }
    i = i.checked_sub(1)?;
    // `3号、5号楼`
    let floor = if number_first && reading.class(i) == Some(Class::WeakBuilding) {
        i = i.checked_sub(1)?;
        0
    } else {
        taken
    };
    let number =
        matches!(reading.lex(i), Some(Lex::Number { .. })) && (number_first || reading.is_ordinal(i));
    (number && i >= floor).then_some(i)
}

fn span(first: &str, last: &str) -> Option<Vec<String>> {
    let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
    let short = first < last && last - first < LONGEST_LIST;
    short.then(|| (first..=last).map(|n| n.to_string()).collect())
}

/// `2号室から4号室まで`, `von Gebäude 4 bis Gebäude 7`, where something is for each of them: else it is a way from one to the other.
pub(super) fn join_ranges(reading: &Reading<'_>, found: &mut Vec<Mention>) {
    let is_each = |at: usize| {
        matches!(reading.class(at), Some(Class::Each | Class::Respectively | Class::All | Class::AllUnits))
    };
    let is_for_each = (0..reading.lexemes.len()).any(is_each);
    let mut i = 1;
    while i < found.len() {
        // `2号棟から4号棟までのユニット1`
        let is_linked = reading.class(found[i].at.end + 1) == Some(Class::Link)
            && reading.class(found[i - 1].at.end) == Some(Class::NotBefore);
        let is_behind_building = found[i].level != Level::Building
            && reading.class(found[i - 1].at.end) == Some(Class::NotBefore)
            && found[i].at.start == found[i - 1].at.end + 1;
        let range = || range_between(reading, &found[i - 1], &found[i]);
        if let Some(targets) = (is_for_each || is_linked || is_behind_building).then(range).flatten() {
            let second = found.remove(i);
            let is_behind = reading.class(second.at.end) == Some(Class::Toward);
            let is_headed = found[i - 1].at.start > 0
                && reading.class(found[i - 1].at.end) != Some(Class::NotBefore)
                && is_from(reading, found[i - 1].at.start - 1);
            found[i - 1].targets = targets;
            found[i - 1].at.start -= usize::from(is_headed);
            found[i - 1].at.end = second.at.end + usize::from(is_behind);
        } else {
            i += 1;
        }
    }
}

fn range_between(reading: &Reading<'_>, a: &Mention, b: &Mention) -> Option<Vec<Target>> {
    let from = reading.class(a.at.end) == Some(Class::NotBefore) && a.at.end + 1 == b.at.start;
    let to = reading.class(b.at.end) == Some(Class::Toward);
    let is_between = |at: usize| {
        let class = reading.class(at);
        matches!(class, Some(Class::Range | Class::Toward | Class::Article | Class::Link | Class::Filler))
    };
    let is_to = |at: usize| matches!(reading.class(at), Some(Class::Range | Class::Toward));
    let mut gap = a.at.end..b.at.start;
    let is_tied = gap.clone().any(is_to) && gap.all(is_between);
    // `3号楼到6号楼`
    let is_headed = b.at.start == a.at.end + 1 || a.at.start > 0 && is_from(reading, a.at.start - 1);
    let ([Target::Label { label: first, .. }], [Target::Label { label: last, said }]) =
        (&a.targets[..], &b.targets[..])
    else {
        return None;
    };
    let is_range = a.level == b.level && (from && to || is_headed && is_tied);
    let numbers = is_range.then(|| span(first, last)).flatten()?;
    Some(numbers.into_iter().map(|label| Target::Label { label, said: said.clone() }).collect())
}

/// `from`, `von`
fn is_from(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Elsewhere | Class::Link))
}
