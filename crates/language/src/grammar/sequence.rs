//! Which stops must come before which, where the instruction says so: `first`, `then`, `before`, `after`, `last`.
//!
//! The order in which stops are merely listed binds nothing.

use super::intent::is_order_after_not;
use super::lexicon::Class;
use super::mentions::Reading;
use super::pairing::Door;
use super::words::Lex;

/// Pairs (earlier, later) of indices into `doors`.
pub(crate) fn constraints(reading: &Reading<'_>, doors: &[Door]) -> Vec<(usize, usize)> {
    let mut pairs = stages(reading, doors);
    let staged = !pairs.is_empty();
    for at in 0..reading.lexemes.len() {
        match reading.lex(at) {
            Some(Lex::Word(Class::First, _)) if !staged => first(reading, doors, at, &mut pairs),
            Some(Lex::Number { label, ordinal: true })
                if !staged && label == "1" && is_adverb(reading, doors, at) =>
            {
                first(reading, doors, at, &mut pairs);
            }
            Some(Lex::Word(Class::Last, _)) if is_adverb(reading, doors, at) => last(doors, at, &mut pairs),
            Some(Lex::Word(Class::Finally, _)) if doors.iter().all(|d| d.first > at) => {
                last(doors, at, &mut pairs);
            }
            Some(Lex::Word(Class::Before, postfix)) => {
                let pair = around(reading, doors, at, *postfix);
                let turned = is_order_after_not(reading, at);
                pairs.extend(pair.map(|(a, b)| if turned { (b, a) } else { (a, b) }));
            }
            Some(Lex::Word(Class::After, postfix)) => {
                let pair = around(reading, doors, at, *postfix);
                pairs.extend(pair.map(|(earlier, later)| (later, earlier)));
            }
            Some(Lex::Word(Class::Wait, _)) if is_for_a_door(reading, doors, at) => {
                let pair = around(reading, doors, at, false);
                pairs.extend(pair.map(|(waiting, other)| (other, waiting)));
            }
            Some(Lex::Word(Class::TowardOrAfter, _)) => pairs.extend(onward(reading, doors, at)),
            _ => {}
        }
    }
    pairs
}

/// Each `then` between two doors parts all doors before it from all after it.
fn stages(reading: &Reading<'_>, doors: &[Door]) -> Vec<(usize, usize)> {
    let mut stage = vec![0; doors.len()];
    for i in 1..doors.len() {
        let between = doors[i - 1].last.min(doors[i].first)..doors[i].first;
        let parted =
            between.clone().any(|at| matches!(reading.class(at), Some(Class::Then | Class::Finally)));
        stage[i] = stage[i - 1] + usize::from(parted);
    }
    let mut pairs = Vec::new();
    for later in 1..doors.len() {
        pairs.extend(
            (0..later).filter(|earlier| stage[*earlier] < stage[later]).map(|earlier| (earlier, later)),
        );
    }
    pairs
}

/// `first`, not `the first box` and not the label of a door.
fn is_adverb(reading: &Reading<'_>, doors: &[Door], at: usize) -> bool {
    let described =
        at > 0 && matches!(reading.class(at - 1), Some(Class::Article | Class::Determiner | Class::Sign));
    let label = doors.iter().any(|d| d.first <= at && at < d.last);
    let describes = matches!(
        reading.lex(at + 1),
        Some(
            Lex::Unknown
                | Lex::Word(Class::Item | Class::Building | Class::Unit | Class::Room | Class::Floor, _)
        )
    );
    !described && !label && !describes
}

fn first(reading: &Reading<'_>, doors: &[Door], at: usize, pairs: &mut Vec<(usize, usize)>) {
    let before = doors.iter().rposition(|d| d.last <= at);
    let beside = before.filter(|i| (doors[*i].last..at).all(|i| reading.class(i) == Some(Class::Filler)));
    let after = || doors.iter().position(|d| d.first > at);
    if let Some(target) = beside.or_else(after).or(before) {
        pairs.extend((0..doors.len()).filter(|i| *i != target).map(|i| (target, i)));
    }
}

fn last(doors: &[Door], at: usize, pairs: &mut Vec<(usize, usize)>) {
    let target = doors.iter().rposition(|d| d.last <= at).or_else(|| doors.iter().position(|d| d.first > at));
    if let Some(target) = target {
        pairs.extend((0..doors.len()).filter(|i| *i != target).map(|i| (i, target)));
    }
}

/// `nach A geht es zu B`: A, then B.
fn onward(reading: &Reading<'_>, doors: &[Door], at: usize) -> Option<(usize, usize)> {
    let from = doors.iter().position(|d| d.first > at)?;
    let to = from + 1;
    let mut gap = doors[from].last..doors.get(to)?.first;
    let goes_on = gap.clone().any(|i| reading.class(i) == Some(Class::Verb))
        && gap.clone().any(|i| reading.class(i) == Some(Class::Toward));
    let stops = gap.any(|i| matches!(reading.lex(i), Some(Lex::Stop | Lex::Word(Class::And, _))));
    (goes_on && !stops).then_some((from, to))
}

/// `wait until building 3 …`, not `wait for a signature`: whether a door follows, words without weight between.
fn is_for_a_door(reading: &Reading<'_>, doors: &[Door], at: usize) -> bool {
    let Some(door) = doors.iter().find(|d| d.first > at) else { return false };
    let is_light = |i: usize| {
        matches!(
            reading.class(i),
            Some(Class::Article | Class::Link | Class::Toward | Class::Filler | Class::Verb | Class::First)
        )
    };
    (at + 1..door.first).all(is_light)
}

/// The doors that a `before` relates: `A before B`, `before B, A`; after the place in some languages: `B之前先去A`.
fn around(reading: &Reading<'_>, doors: &[Door], at: usize, postfix: bool) -> Option<(usize, usize)> {
    // `before 6 pm`, but `前に12号棟`
    let is_door = doors.iter().any(|d| d.first == at + 1);
    if !is_door && matches!(reading.lex(at + 1), Some(Lex::Number { .. } | Lex::Quantity | Lex::Unknown)) {
        return None;
    }
    let stop = |mut range: std::ops::Range<usize>| range.any(|at| reading.lex(at) == Some(&Lex::Stop));
    let before = doors.iter().rposition(|d| d.last <= at && !stop(d.last..at));
    let mut after = (0..doors.len()).filter(|i| doors[*i].first > at && !stop(at..doors[*i].first));
    let Some(next) = after.next() else {
        // `AはBの後にして`, but not `9号楼6点之前`
        let is_time = at > 0 && reading.lex(at - 1) == Some(&Lex::Quantity);
        let pair = before.filter(|_| postfix && !is_time).and_then(|b| Some((b.checked_sub(1)?, b)));
        return pair.filter(|(a, b)| !stop(doors[*a].last.min(doors[*b].first)..doors[*b].first));
    };
    let second = after.next();
    match (before, second) {
        (Some(before), _) if postfix => Some((next, before)),
        (Some(before), _) => Some((before, next)),
        (None, Some(second)) => Some((second, next)),
        (None, None) => None,
    }
}
