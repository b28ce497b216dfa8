//! Numbers beside a word for a level: lists and ranges of them, before it and behind it.

use std::ops::Range;

use super::mention::{Level, Mention, Target};
use crate::grammar::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::feature::Feature;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::marks;

/// No list or range names more places than this.
const LONGEST_LIST: usize = 50;

/// The numbers of a word for a level.
pub(super) struct Numbers {
    pub labels: Vec<String>,
    /// The lexemes that they and the word take.
    pub at: Range<usize>,
}

/// The numbers behind a level: `building no. 3`, `units 1, 2 and 4`, `units 1 to 3`.
pub(super) fn numbers_after(reading: &Reading<'_>, level: usize) -> Option<Numbers> {
    let plural = reading.is_plural(level);
    let first = first_after(reading, level, plural);
    let label = reading.label(first)?.to_owned();
    // `building 3rd floor`: an ordinal belongs to what follows it.
    if reading.is_ordinal(first) {
        return None;
    }
    if let Some(last) = range_end(reading, first + 1, plural) {
        let labels = span(&label, &last.label)?;
        return Some(Numbers {
            labels,
            at: level..last.end,
        });
    }
    let (labels, end) = list_after(reading, label, first + 1, plural);
    Some(Numbers {
        labels,
        at: level..end,
    })
}

/// Where the first number behind a level may stand.
fn first_after(reading: &Reading<'_>, level: usize, plural: bool) -> usize {
    let mut at = level + 1 + verb_between(reading, level + 1);
    // `入口は3番`
    if matches!(reading.lex(at), Some(Lex::Word(Class::Toward, true)))
        && has_no_level(reading, at + 1)
    {
        at += 1;
    }
    while is_between(reading, at, plural) {
        at += 1;
    }
    at
}

/// How many words of a verb stand at a place: `the unit is number 2`, `la unidad es la 2`.
fn verb_between(reading: &Reading<'_>, at: usize) -> usize {
    let is_verb = reading.class(at) == Some(Class::Verb)
        && matches!(reading.class(at + 1), Some(Class::Sign | Class::Article));
    let ends = matches!(
        reading.lex(at + 3),
        None | Some(Lex::Stop | Lex::Comma | Lex::Word(Class::And, _))
    );
    match (is_verb, reading.label(at + 2).is_some() && ends) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => 2,
    }
}

/// Whether a label stands at a place without a word for a level behind it.
fn has_no_level(reading: &Reading<'_>, at: usize) -> bool {
    reading.label(at).is_some() && reading.class(at + 1).and_then(Level::of).is_none()
}

/// Whether a word may stand between a level and its number.
fn is_between(reading: &Reading<'_>, at: usize, plural: bool) -> bool {
    match reading.lex(at) {
        Some(Lex::Word(Class::Sign, _) | Lex::Dash) => true,
        // `unidades de la 2 a la 4`
        Some(Lex::Word(Class::Link | Class::Article, _)) => plural,
        Some(Lex::Mark) => reading.begins_with(at, marks::COLON),
        _ => false,
    }
}

/// A list that begins with `first` and goes on at `end`, and where it ends. Commas alone make a
/// list only behind a plural; else the list must close with `and`.
fn list_after(
    reading: &Reading<'_>,
    first: String,
    mut end: usize,
    plural: bool,
) -> (Vec<String>, usize) {
    let mut labels = vec![first];
    let mut pending = Vec::new();
    let mut next = end;
    while let Some(item) = next_item(reading, next) {
        let is_full = labels.len() + pending.len() >= LONGEST_LIST;
        if is_full || !is_listed(reading, &item, plural, !pending.is_empty()) {
            break;
        }
        pending.extend(reading.label(item.at).map(str::to_owned));
        next = item.at + 1;
        // Numbers behind commas wait in `pending` until an `and` closes the list. Without it they
        // are not part of it, and `end` stays before them.
        if item.has_and || plural {
            labels.append(&mut pending);
            end = next;
        }
    }
    (labels, end)
}

/// Where the next number of a list may stand.
struct Item {
    at: usize,
    /// Whether `and` stands before it.
    has_and: bool,
}

/// Past a comma, `and`, or both.
fn next_item(reading: &Reading<'_>, start: usize) -> Option<Item> {
    let has_comma = reading.lex(start) == Some(&Lex::Comma);
    let mut at = start + usize::from(has_comma);
    let has_and = reading.class(at) == Some(Class::And);
    at += usize::from(has_and);
    // `la unidad 1 y la 4`, but `unité 2, et le 6, unité 4`
    let has_article = reading.class(at) == Some(Class::Article);
    at += usize::from(has_and && !has_comma && has_article);
    (at > start).then_some(Item { at, has_and })
}

/// Whether the number of an item belongs to the list; `is_behind_comma`: whether numbers before it
/// do only if an `and` follows.
fn is_listed(reading: &Reading<'_>, item: &Item, plural: bool, is_behind_comma: bool) -> bool {
    let at = item.at;
    let is_before_a_word = reading.lex(at + 1) == Some(&Lex::Unknown);
    // `buildings 4 and 2 want milk`: behind a plural what follows may be any word.
    let is_of_plural = plural && is_before_a_word && reading.is_cardinal(at);
    // `Gebäude 1, 6 und 11 waren geplant`
    let is_disjunction = reading.has(at.saturating_sub(1), Feature::Disjunction);
    let ends_a_list = item.has_and && !is_disjunction && is_behind_comma && is_before_a_word;
    // `unit 2 in building 5 and I will be happy`
    let is_pronoun = reading.has(at, Feature::FirstPerson);
    // `entrée 1 et 6 pour le bâtiment 11`
    let is_amount = item.has_and && goes_to_a_building(reading, at + 1);
    let continues = reading.continues_list(at) || is_of_plural || ends_a_list;
    !is_pronoun && !is_amount && continues
}

/// `for building 11`
fn goes_to_a_building(reading: &Reading<'_>, at: usize) -> bool {
    let is_toward = matches!(
        reading.class(at),
        Some(Class::Toward | Class::TowardOrAfter)
    );
    let article = usize::from(reading.class(at + 1) == Some(Class::Article));
    let is_building = matches!(
        reading.lex(at + 1 + article),
        Some(Lex::Name(_) | Lex::Word(Class::Building, _))
    );
    is_toward && is_building
}

/// The last number of a range.
struct RangeEnd {
    label: String,
    /// The lexeme behind the range.
    end: usize,
}

/// The end of a range: `units 1 to 3`, `Eingang 1 bis 3`.
fn range_end(reading: &Reading<'_>, at: usize, plural: bool) -> Option<RangeEnd> {
    // `入口1から4まで`
    let is_from_to =
        reading.class(at) == Some(Class::NotBefore) && reading.class(at + 2) == Some(Class::Toward);
    if let Some(label) = reading.label(at + 1).filter(|_| is_from_to) {
        return Some(RangeEnd {
            label: label.to_owned(),
            end: at + 3,
        });
    }
    let is_loose = reading.lex(at) == Some(&Lex::Dash) || reading.class(at) == Some(Class::Toward);
    let is_tied = reading.class(at) == Some(Class::Range) || plural && is_loose;
    let last = at + 1 + usize::from(reading.class(at + 1) == Some(Class::Article));
    if !is_tied || !reading.continues_list(last) {
        return None;
    }
    Some(RangeEnd {
        label: reading.label(last)?.to_owned(),
        end: last + 1,
    })
}

/// The numbers before a level: `the first and second unit`, `No. 3 building`, `1、2单元`, `1到3单元`.
/// Lexemes before `taken` belong to another mention.
pub(super) fn numbers_before(
    reading: &Reading<'_>,
    level: usize,
    number_first: bool,
    taken: usize,
) -> Option<Numbers> {
    let mut at = level.checked_sub(1).filter(|at| *at >= taken)?;
    if let Some(label) = reading.ordinal_determiner(at).filter(|_| number_first) {
        return Some(Numbers {
            labels: vec![label.to_string()],
            at: at..level + 1,
        });
    }
    if reading.lex(at) == Some(&Lex::Dash) && number_first {
        at = at.checked_sub(1)?;
    }
    let label = reading.label(at)?.to_owned();
    let is_signed = at > taken && reading.class(at - 1) == Some(Class::Sign);
    // `3 building` is no building 3 in languages that put the number behind, but `3rd building` is.
    if !(number_first || is_signed || reading.is_ordinal(at)) {
        return None;
    }
    if number_first && let Some((labels, start)) = range_before(reading, at, taken) {
        return Some(Numbers {
            labels,
            at: start..level + 1,
        });
    }
    let start = at - usize::from(is_signed);
    let (labels, start) = list_before(reading, label, start, number_first, taken);
    Some(Numbers {
        labels,
        at: start..level + 1,
    })
}

/// The labels of a range that ends at a number, and where it begins.
fn range_before(reading: &Reading<'_>, at: usize, taken: usize) -> Option<(Vec<String>, usize)> {
    let start = at.checked_sub(2).filter(|start| *start >= taken)?;
    let is_tied = reading.lex(at - 1) == Some(&Lex::Dash)
        || matches!(reading.class(at - 1), Some(Class::Range | Class::Toward));
    if !is_tied {
        return None;
    }
    Some((span(reading.label(start)?, reading.label(at)?)?, start))
}

/// The labels of a list whose last one is `last`, which begins at `start`; and where the list
/// begins.
fn list_before(
    reading: &Reading<'_>,
    last: String,
    mut start: usize,
    number_first: bool,
    taken: usize,
) -> (Vec<String>, usize) {
    let mut labels = vec![last];
    while let Some(number) = listed_before(reading, start, number_first, taken) {
        labels.extend(reading.label(number).map(str::to_owned));
        start = number;
        if labels.len() >= LONGEST_LIST {
            break;
        }
    }
    labels.reverse();
    (labels, start)
}

/// The number that `…, ` or `… and ` puts before the one at `at` in a list.
fn listed_before(
    reading: &Reading<'_>,
    at: usize,
    number_first: bool,
    taken: usize,
) -> Option<usize> {
    let mut i = at.checked_sub(1)?;
    if reading.class(i) == Some(Class::Article) {
        i = i.checked_sub(1)?;
    }
    // `一番と四番の入口`
    let has_and = reading.class(i) == Some(Class::And);
    if has_and && number_first && i > 0 && reading.class(i - 1) == Some(Class::Sign) {
        i -= 1;
    }
    if !has_and && (number_first || reading.lex(i) != Some(&Lex::Comma)) {
        return None;
    }
    i = i.checked_sub(1)?;
    // `3号、5号楼`: the list takes back a number that seemed to be a place of its own.
    let takes_back = number_first && reading.class(i) == Some(Class::WeakBuilding);
    if takes_back {
        i = i.checked_sub(1)?;
    }
    let is_number = matches!(reading.lex(i), Some(Lex::Number { .. }))
        && (number_first || reading.is_ordinal(i));
    (is_number && (takes_back || i >= taken)).then_some(i)
}

/// The labels from one number to another, if they are not too many.
fn span(first: &str, last: &str) -> Option<Vec<String>> {
    let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
    // Bounded before the labels are made: a range may have any numbers.
    let is_short = first < last && last - first < LONGEST_LIST;
    is_short.then(|| (first..=last).map(|n| n.to_string()).collect())
}

/// `2号室から4号室まで`, `von Gebäude 4 bis Gebäude 7`: two mentions become one range where
/// something is for each of them. Else it is the route from one to the other.
pub(super) fn join_ranges(reading: &Reading<'_>, found: &mut Vec<Mention>) {
    let is_each = |at: usize| {
        use Class::{All, AllUnits, Each, Respectively};
        matches!(
            reading.class(at),
            Some(Each | Respectively | All | AllUnits)
        )
    };
    let is_for_each = (0..reading.lexemes.len()).any(is_each);
    let mut i = 1;
    while i < found.len() {
        let (first, last) = (&found[i - 1], &found[i]);
        let is_range = is_for_each || is_told_as_range(reading, first, last);
        match range_between(reading, first, last).filter(|_| is_range) {
            Some(targets) => {
                // The mention behind the range moves to `i`, so `i` stays.
                let last = found.remove(i);
                found[i - 1].at = range_at(reading, &found[i - 1], &last);
                found[i - 1].targets = targets;
            }
            None => i += 1,
        }
    }
}

/// Whether two mentions can be nothing but the ends of a range, whomever it is for.
fn is_told_as_range(reading: &Reading<'_>, first: &Mention, last: &Mention) -> bool {
    let has_from = reading.class(first.at.end) == Some(Class::NotBefore);
    // `2号棟から4号棟までのユニット1`
    let is_linked = reading.class(last.at.end + 1) == Some(Class::Link);
    let is_inside_building = !last.is_building() && last.at.start == first.at.end + 1;
    has_from && (is_linked || is_inside_building)
}

/// The lexemes that a range takes: with the words for `from` and `to` outside it.
fn range_at(reading: &Reading<'_>, first: &Mention, last: &Mention) -> Range<usize> {
    let has_to_behind = reading.class(last.at.end) == Some(Class::Toward);
    let has_from_before = first.at.start > 0
        && reading.class(first.at.end) != Some(Class::NotBefore)
        && is_from(reading, first.at.start - 1);
    first.at.start - usize::from(has_from_before)..last.at.end + usize::from(has_to_behind)
}

/// The targets of the range between two mentions, if words for a range stand between them.
fn range_between(reading: &Reading<'_>, a: &Mention, b: &Mention) -> Option<Vec<Target>> {
    if a.level != b.level || !(is_postfix_range(reading, a, b) || is_prefix_range(reading, a, b)) {
        return None;
    }
    let ([Target::Label { label: first, .. }], [Target::Label { label: last, said }]) =
        (&a.targets[..], &b.targets[..])
    else {
        return None;
    };
    let target = |label: String| Target::Label {
        label,
        said: said.clone(),
    };
    Some(span(first, last)?.into_iter().map(target).collect())
}

/// `2号室から4号室まで`
fn is_postfix_range(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    reading.class(a.at.end) == Some(Class::NotBefore)
        && a.at.end + 1 == b.at.start
        && reading.class(b.at.end) == Some(Class::Toward)
}

/// `von Gebäude 4 bis Gebäude 7`, `3号楼到6号楼`
fn is_prefix_range(reading: &Reading<'_>, a: &Mention, b: &Mention) -> bool {
    let is_to = |at: usize| matches!(reading.class(at), Some(Class::Range | Class::Toward));
    let is_between = |at: usize| {
        use Class::{Article, Filler, Link, Range, Toward};
        matches!(
            reading.class(at),
            Some(Range | Toward | Article | Link | Filler)
        )
    };
    let mut gap = a.at.end..b.at.start;
    let is_tied = gap.clone().any(is_to) && gap.all(is_between);
    let is_direct = b.at.start == a.at.end + 1;
    is_tied && (is_direct || a.at.start > 0 && is_from(reading, a.at.start - 1))
}

/// `from`, `von`
fn is_from(reading: &Reading<'_>, at: usize) -> bool {
    matches!(reading.class(at), Some(Class::Elsewhere | Class::Link))
}
