//! What is delivered, in the instruction's words: `this box`, `the red box`, `这个箱子`.

use std::ops::Range;

use super::lexicon::Class;
use super::pairing::Door;
use super::reading::Reading;
use super::text::Kind;
use super::words::Lex;

/// How many words of no lexicon may describe an item.
const ADJECTIVES: usize = 2;

/// For each door the item that goes there; empty where none is named.
pub(crate) fn items(reading: &Reading<'_>, doors: &[Door]) -> Vec<String> {
    let mut free = all(reading);
    let mut named: Vec<String> = Vec::new();
    for i in 0..doors.len() {
        let item = match own(reading, doors, i, &free) {
            Some(found) => reading.words(free.remove(found)).to_owned(),
            // `this box to unit 1 and unit 2`
            None => match i.checked_sub(1) {
                Some(p) if !parted(reading, doors[p].last.min(doors[i].first)..doors[i].first) => {
                    named[p].clone()
                }
                _ => String::new(),
            },
        };
        named.push(item);
    }
    named
}

/// Which of the items that are left belongs to door `i`: tied to it (`3号楼的快递`), before it, or, after the last door of a
/// sentence, behind it.
fn own(reading: &Reading<'_>, doors: &[Door], i: usize, free: &[Range<usize>]) -> Option<usize> {
    let door = &doors[i];
    let after = i.checked_sub(1).map_or(0, |p| doors[p].last.min(door.first));
    let until = doors.get(i + 1).map_or(usize::MAX, |next| next.first);
    let tied = || {
        let linked = reading.lex(door.last) == Some(&Lex::Word(Class::Link, true));
        free.iter().position(|item| linked && item.start == door.last + 1)
    };
    let before = || {
        let fits = |item: &Range<usize>| {
            item.start >= after && item.end <= door.first && !parted(reading, item.end..door.first)
        };
        free.iter().rposition(fits)
    };
    let behind = || {
        let last = until == usize::MAX || parted(reading, door.last..until);
        let fits = |item: &Range<usize>| {
            item.start >= door.last && item.end <= until && !parted(reading, door.last..item.start)
        };
        free.iter().position(|item| last && fits(item))
    };
    tied().or_else(before).or_else(behind)
}

/// Whether a sentence ends there.
fn parted(reading: &Reading<'_>, mut range: Range<usize>) -> bool {
    range.any(|at| reading.lex(at) == Some(&Lex::Stop))
}

/// All items: a noun with what stands before it.
fn all(reading: &Reading<'_>) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for at in (0..reading.lexemes.len()).filter(|at| reading.class(*at) == Some(Class::Item)) {
        let start = begin(reading, at);
        match found.last_mut().filter(|last| last.end >= start) {
            Some(last) => last.end = at + 1,
            None => found.push(start..at + 1),
        }
    }
    found
}

fn begin(reading: &Reading<'_>, noun: usize) -> usize {
    let (mut start, mut adjectives) = (noun, 0);
    for at in (0..noun).rev() {
        match reading.lex(at) {
            Some(Lex::Word(Class::Determiner | Class::Article | Class::All, _)) => return at,
            Some(Lex::Number { .. } | Lex::Quantity | Lex::Word(Class::Item, _)) => start = at,
            Some(Lex::Unknown)
                if adjectives < ADJECTIVES && reading.token(at).is_some_and(|t| t.kind == Kind::Letters) =>
            {
                adjectives += 1;
                start = at;
            }
            _ => break,
        }
    }
    start
}
