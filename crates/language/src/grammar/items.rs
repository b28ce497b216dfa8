//! What is delivered, in the instruction's words: `this box`, `the red box`, `这个箱子`.

use std::ops::Range;

use super::door::Door;
use super::reading::Reading;
use crate::lexicon::class::Class;
use crate::lexicon::lexeme::Lex;
use crate::lexicon::tokens::Kind;

/// The most words of no lexicon that describe an item: of more, some are of the words before.
const MOST_ADJECTIVES: usize = 2;

/// For each door the item that goes there; empty where none is named.
pub(crate) fn items(reading: &Reading<'_>, doors: &[Door]) -> Vec<String> {
    // Each item is given to one door; the others of its list share it.
    let mut free = all(reading);
    let mut named: Vec<String> = Vec::new();
    for i in 0..doors.len() {
        let item = match own(reading, doors, i, &free) {
            Some(found) => reading.words(free.remove(found)).to_owned(),
            None => shared(reading, doors, i, &named),
        };
        named.push(item);
    }
    named
}

/// The item of the door before door `i`, if no sentence ends between them: `this box to unit 1 and
/// unit 2`.
fn shared(reading: &Reading<'_>, doors: &[Door], i: usize, named: &[String]) -> String {
    let Some(before) = i.checked_sub(1) else {
        return String::new();
    };
    let gap = doors[before].last.min(doors[i].first)..doors[i].first;
    if has_stop(reading, gap) {
        String::new()
    } else {
        named[before].clone()
    }
}

/// Which of the items that are left belongs to door `i`: tied to it (`3号楼的快递`), before it, or,
/// behind the last door of a sentence, behind it.
fn own(reading: &Reading<'_>, doors: &[Door], i: usize, free: &[Range<usize>]) -> Option<usize> {
    let door = &doors[i];
    let after = i
        .checked_sub(1)
        .map_or(0, |before| doors[before].last.min(door.first));
    let next = doors.get(i + 1).map(|next| next.first);
    let until = next.unwrap_or(usize::MAX);
    let is_linked = reading.lex(door.last) == Some(&Lex::Word(Class::Link, true));
    let tied = free
        .iter()
        .position(|item| is_linked && item.start == door.last + 1);
    let before = free.iter().rposition(|item| {
        item.start >= after && item.end <= door.first && !has_stop(reading, item.end..door.first)
    });
    let is_last = next.is_none_or(|next| has_stop(reading, door.last..next));
    let behind = free.iter().position(|item| {
        is_last
            && item.start >= door.last
            && item.end <= until
            && !has_stop(reading, door.last..item.start)
    });
    tied.or(before).or(behind)
}

/// Whether a sentence ends in a range.
fn has_stop(reading: &Reading<'_>, mut range: Range<usize>) -> bool {
    range.any(|at| reading.is_stop(at))
}

/// All items: a noun with what stands before it.
fn all(reading: &Reading<'_>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for at in 0..reading.lexemes.len() {
        if reading.class(at) != Some(Class::Item) {
            continue;
        }
        let start = begin(reading, at);
        // Adjacent nouns are one item: `letter box`.
        match found.last_mut().filter(|last| last.end >= start) {
            Some(last) => last.end = at + 1,
            None => found.push(start..at + 1),
        }
    }
    found
}

/// Where the item of a noun begins: at its determiner, number or adjectives.
fn begin(reading: &Reading<'_>, noun: usize) -> usize {
    let mut start = noun;
    let mut adjectives = 0;
    for at in (0..noun).rev() {
        match reading.lex(at) {
            Some(Lex::Word(Class::Determiner | Class::Article | Class::All, _)) => return at,
            Some(Lex::Number { .. } | Lex::Quantity | Lex::Word(Class::Item, _)) => start = at,
            Some(Lex::Unknown) if adjectives < MOST_ADJECTIVES && is_word(reading, at) => {
                adjectives += 1;
                start = at;
            }
            _ => break,
        }
    }
    start
}

fn is_word(reading: &Reading<'_>, at: usize) -> bool {
    reading
        .token(at)
        .is_some_and(|token| token.kind == Kind::Letters)
}
