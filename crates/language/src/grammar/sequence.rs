//! Which stops must come before which, where the instruction says so: `first`, `then`, `before`, `after`, `last`.
//!
//! The order in which stops are merely listed binds nothing.

use std::ops::Range;

use super::intent::is_order_after_not;
use super::lexicon::Class;
use super::pairing::Door;
use super::reading::Reading;
use super::words::Lex;

/// Pairs (earlier, later) of indices into `doors`.
///
/// What comes first wins where they contradict each other: what is said after the last correction comes before what is said at all.
pub(crate) fn constraints(reading: &Reading<'_>, doors: &[Door]) -> Vec<(usize, usize)> {
    let end = reading.lexemes.len();
    let swap = (0..end).rev().find(|at| reading.class(*at) == Some(Class::Swap));
    let corrects = |at: &usize| matches!(reading.class(*at), Some(Class::Correct | Class::Swap));
    let mut pairs = match (0..end).rev().find(corrects) {
        Some(correction) => within(reading, doors, correction..end),
        None => Vec::new(),
    };
    if let Some(swap) = swap {
        pairs.extend(within(reading, doors, 0..swap).into_iter().map(|(earlier, later)| (later, earlier)));
    }
    pairs.extend(within(reading, doors, 0..end));
    pairs
}

/// What the words in a part of the instruction say of the doors that are named in it.
fn within(reading: &Reading<'_>, doors: &[Door], part: Range<usize>) -> Vec<(usize, usize)> {
    let mut pairs = stages(reading, doors, &part);
    let staged = !pairs.is_empty();
    for at in part.clone() {
        match reading.lex(at) {
            Some(Lex::Word(Class::First, _)) if !staged => first(reading, doors, at, &mut pairs),
            Some(Lex::Number { label, ordinal: true })
                if !staged && label == "1" && is_adverb(reading, doors, at) =>
            {
                first(reading, doors, at, &mut pairs);
            }
            Some(Lex::Word(Class::Last, _)) if is_adverb(reading, doors, at) => {
                last(reading, doors, at, &mut pairs)
            }
            Some(Lex::Word(Class::Then, _)) if is_behind(reading, doors, at) => {
                afterwards(reading, doors, at, &mut pairs);
            }
            Some(Lex::Word(Class::Finally, _))
                if doors.iter().all(|d| d.first > at) || is_behind(reading, doors, at) =>
            {
                last(reading, doors, at, &mut pairs);
            }
            // `A. Before, B`
            Some(Lex::Word(Class::Before, false))
                if reading.lex(at + 1) == Some(&Lex::Comma)
                    && at > 0
                    && reading.lex(at - 1) == Some(&Lex::Stop) =>
            {
                earlier(reading, doors, at, &mut pairs);
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
            Some(Lex::Word(Class::Earlier, _)) => earlier(reading, doors, at, &mut pairs),
            Some(Lex::Word(Class::TowardOrAfter, _)) => pairs.extend(onward(reading, doors, at)),
            _ => {}
        }
    }
    if part.clone().any(|at| reading.class(at) == Some(Class::InOrder)) {
        let here: Vec<usize> = (0..doors.len()).filter(|i| part.contains(&doors[*i].first)).collect();
        pairs.extend(here.windows(2).map(|pair| (pair[0], pair[1])));
    }
    pairs
}

/// Each `then` between two doors of a part parts all doors before it from all after it.
fn stages(reading: &Reading<'_>, doors: &[Door], part: &Range<usize>) -> Vec<(usize, usize)> {
    let mut stage = vec![0; doors.len()];
    let inside = |i: usize| part.start <= doors[i].first && doors[i].last <= part.end;
    let first = (0..doors.len()).find(|i| inside(*i)).unwrap_or(doors.len());
    let end = (first..doors.len()).find(|i| !inside(*i)).unwrap_or(doors.len());
    for i in first + 1..end {
        let between = doors[i - 1].last.min(doors[i].first)..doors[i].first;
        let parted = between.clone().any(|at| is_then(reading, at) && !is_behind(reading, doors, at));
        stage[i] = stage[i - 1] + usize::from(parted);
    }
    let mut pairs = Vec::new();
    for later in first..end {
        pairs.extend(
            (first..later).filter(|earlier| stage[*earlier] < stage[later]).map(|earlier| (earlier, later)),
        );
    }
    pairs
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

/// The lexemes of the sentence around a place.
fn sentence(reading: &Reading<'_>, at: usize) -> Range<usize> {
    let stop = |at: &usize| reading.lex(*at) == Some(&Lex::Stop);
    let begin = (0..at).rev().find(stop).map_or(0, |stop| stop + 1);
    begin..(at..reading.lexemes.len()).find(stop).unwrap_or(reading.lexemes.len())
}

/// Whether a `then` or `last` ends its sentence and so is of a door before it: `building 3 comes last.`
fn is_behind(reading: &Reading<'_>, doors: &[Door], at: usize) -> bool {
    let Range { start: begin, end } = sentence(reading, at);
    // `3号楼的随后再送，…`
    let ends =
        matches!(reading.lex(at), Some(Lex::Word(_, true))) && reading.lex(at + 1) == Some(&Lex::Comma);
    // `Haus 5 kommt als Letztes dran, vorher …`, but `and finally, building 5`
    let is_last = reading.class(at) == Some(Class::Finally) && reading.lex(at + 1) != Some(&Lex::Comma);
    let comma = |at: &usize| is_last && reading.lex(*at) == Some(&Lex::Comma);
    let end = (at..end).find(comma).unwrap_or(end);
    let is_alone = ends || !doors.iter().any(|door| door.first > at && door.first < end);
    is_alone && doors.iter().any(|door| door.first >= begin && door.last <= at)
}

/// `A; B and C afterwards`: the doors of the sentence come after all of the sentences before.
fn afterwards(reading: &Reading<'_>, doors: &[Door], at: usize, pairs: &mut Vec<(usize, usize)>) {
    let begin = sentence(reading, at).start;
    let here = (0..doors.len()).filter(|i| doors[*i].first >= begin && doors[*i].last <= at);
    for later in here {
        pairs.extend((0..doors.len()).filter(|i| doors[*i].last <= begin).map(|earlier| (earlier, later)));
    }
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
    let after = doors.iter().position(|d| d.first > at);
    let is_parted = |from: usize, to: usize| (from..to).any(|at| reading.lex(at) == Some(&Lex::Stop));
    // `building 6 has to get theirs first; building 1 …`
    let before_in_sentence = before.filter(|i| {
        !is_parted(doors[*i].last, at) && after.is_none_or(|after| is_parted(at, doors[after].first))
    });
    // `3号楼优先，5号楼…`
    let ends = matches!(reading.lex(at + 1), None | Some(Lex::Comma | Lex::Stop));
    let behind = before.filter(|i| ends && !is_parted(doors[*i].last, at));
    if let Some(target) = beside.or(behind).or(before_in_sentence).or(after).or(before) {
        pairs.extend((0..doors.len()).filter(|i| *i != target).map(|i| (target, i)));
    }
}

fn last(reading: &Reading<'_>, doors: &[Door], at: usize, pairs: &mut Vec<(usize, usize)>) {
    let before = || doors.iter().rposition(|d| d.last <= at);
    let after = || doors.iter().position(|d| d.first > at);
    // `最后一站12栋`
    let begins = at == 0 || matches!(reading.lex(at - 1), Some(Lex::Comma | Lex::Stop));
    let target = if begins { after().or_else(before) } else { before().or_else(after) };
    if let Some(target) = target {
        pairs.extend((0..doors.len()).filter(|i| *i != target).map(|i| (i, target)));
    }
}

/// `A. Before that, B`, `A, and B before that`: B, then A.
fn earlier(reading: &Reading<'_>, doors: &[Door], at: usize, pairs: &mut Vec<(usize, usize)>) {
    let Some(before) = doors.iter().rposition(|door| door.last <= at) else { return };
    // `…, but before that …`
    let opening = (0..at).rev().take_while(|at| reading.class(*at) == Some(Class::Filler)).count();
    let begins = at == opening
        || matches!(
            reading.lex(at - opening - 1),
            Some(Lex::Stop | Lex::Comma | Lex::Mark | Lex::Word(Class::And, _))
        );
    let is_near = |door: usize| (at..doors[door].first).all(|at| reading.lex(at) != Some(&Lex::Stop));
    let after = (0..doors.len()).filter(|i| begins && doors[*i].first > at && is_near(*i));
    let count = pairs.len();
    pairs.extend(after.map(|after| (after, before)));
    if pairs.len() == count && before > 0 {
        pairs.push((before, before - 1));
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
    let is_article = |at: &usize| reading.class(*at) == Some(Class::Article);
    let behind = at + 1 + (at + 1..reading.lexemes.len()).take_while(is_article).count();
    if !is_door && matches!(reading.lex(behind), Some(Lex::Number { .. } | Lex::Quantity)) {
        return None;
    }
    // `9号楼6点之前`
    let is_time = at > 0 && matches!(reading.lex(at - 1), Some(Lex::Quantity | Lex::Word(Class::Measure, _)));
    if postfix && is_time {
        return None;
    }
    // `before lunch, and …`, but `after leaving the box at building 3`
    let is_parted = |lex: &Lex| matches!(lex, Lex::Comma | Lex::Stop | Lex::Word(Class::And, _));
    let next =
        doors.iter().map(|d| d.first).filter(|first| *first > at).min().unwrap_or(reading.lexemes.len());
    let is_of_something_else = (at..next).any(|at| reading.lex(at).is_some_and(is_parted));
    if !is_door && reading.lex(at + 1) == Some(&Lex::Unknown) && is_of_something_else {
        return None;
    }
    let stop = |mut range: Range<usize>| range.any(|at| reading.lex(at) == Some(&Lex::Stop));
    let before = doors.iter().rposition(|d| d.last <= at && !stop(d.last..at));
    let mut after = (0..doors.len()).filter(|i| doors[*i].first > at && !stop(at..doors[*i].first));
    let Some(next) = after.next() else {
        // `B must come before, at 2 pm`
        let is_alone = !postfix && matches!(reading.lex(at + 1), None | Some(Lex::Comma | Lex::Stop));
        if is_alone && reading.class(at) == Some(Class::Before) {
            return before.and_then(|b| Some((b, b.checked_sub(1)?)));
        }
        // `AはBの後にして`
        let pair = before.filter(|_| postfix).and_then(|b| Some((b.checked_sub(1)?, b)));
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
